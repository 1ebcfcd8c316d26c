"""Lines of forces and moments beside the torque, held against the lines that made the records."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.analysis.side_components import TRACKED, least_coherence, pool_measurements, side_components, side_lines
from table_of_six import MEASURED, NOISE, measured, tracked

RATE = 40.0
DRIVE = {0.5: 0.04 * np.exp(0.4j), 1.0: 0.1 * np.exp(-2.0j), 2.0: 0.03}
EXERTED = {
    "moment_z": DRIVE,
    "force_x": {1.0: 0.5 * np.exp(1.0j)},
    "force_y": {1.0: 0.2 * np.exp(2.5j), 2.0: 0.1j},
    "moment_x": {0.5: 0.01},
    "force_z": {1.25: 0.3},
}
"""At the mounting point; of force_z at an order at which the torque has no line."""


def lines(seed=0, exerted=EXERTED, **options):
    (at,) = tracked(measured(exerted, RATE, np.random.default_rng(seed), **options), RATE)
    return side_lines(at)


def test_lines_about_the_mounting_point_with_their_phase_to_the_torque():
    """Truth: the lines exerted there; what the lever arm adds at the table is gone. No line but those is heard."""
    found = lines()
    for j, component in enumerate(MEASURED):
        for k, order in enumerate(TRACKED):
            true = EXERTED.get(component, {}).get(order)
            assert found.heard[k, j] == (true is not None), (component, order)
            if true is None:
                continue
            assert abs(found.amplitude[k, j] - abs(true)) < 5.0 * found.sigma[k, j]
            assert found.known[k, j] == (order in DRIVE)
            if order in DRIVE:
                off = np.angle(np.exp(1j * found.phase[k, j]) * DRIVE[order] / true * abs(true) / abs(DRIVE[order]))
                assert abs(off) < 5.0 * found.phase_sigma[k, j] < 0.5


def test_errors_are_as_large_as_they_are_said_to_be():
    """Truth: the scatter over 15 draws of the noise, of amplitudes and of phases."""
    off = []
    for seed in range(15):
        found = lines(seed, noise=30.0 * NOISE)
        for j, component in enumerate(MEASURED):
            for order, true in EXERTED.get(component, {}).items():
                k = TRACKED.index(order)
                if found.known[k, j]:
                    turned = found.phase[k, j] + np.angle(DRIVE[order] / true)
                    off.append(
                        [
                            (found.amplitude[k, j] - abs(true)) / found.sigma[k, j],
                            np.angle(np.exp(1j * turned)) / found.phase_sigma[k, j],
                        ]
                    )
    amplitude, phase = np.sqrt(np.mean(np.square(off), axis=0))
    assert len(off) > 40
    assert 0.7 < amplitude < 1.3
    assert 0.7 < phase < 1.3


@pytest.mark.slow
def test_noise_makes_no_lines():
    """Truth: there are none. At a hundredth a rate, 30 records may have one or two."""
    only = {"moment_z": DRIVE}
    heard = sum(bool(lines(seed, only, seconds=2.0).heard.any()) for seed in range(30))
    assert heard <= 2


def test_a_line_that_wanders_has_no_phase():
    """Truth: its phase changes by 2 rad from window to window; the steady one beside it keeps its own."""
    rng = np.random.default_rng(1)
    record = measured(EXERTED, RATE, rng)
    steps = RATE * np.arange(record.samples) / record.sample_rate_hz
    window = np.minimum(steps // 16, 9)
    wandering = 0.3 * np.cos(2.0 * np.pi * steps + 2.0 * window)
    channels = tuple(replace(c, data=c.data + wandering) if c.quantity == "force_z" else c for c in record.channels)
    (at,) = tracked(replace(record, channels=channels), RATE)
    found, k, j = side_lines(at), TRACKED.index(1.0), MEASURED.index("force_z")
    assert found.heard[k, j]
    assert not found.known[k, j]
    assert found.known[k, 0]


def test_one_window_shows_no_phase():
    assert not lines(seconds=0.5).known.any()
    assert lines(seconds=0.5).heard.any()
    assert 0.999 < least_coherence(2) < 1.0


def test_records_of_one_rate_count_by_their_windows():
    """Truth: the record as a whole, in two pieces."""
    record = measured(EXERTED, RATE, np.random.default_rng(3))
    (whole,) = tracked(record, RATE)  # of nine windows; each half has four
    half = record.samples // 2
    pieces = []
    for part in (slice(0, half), slice(half, None)):
        channels = tuple(replace(c, data=c.data[part]) for c in record.channels)
        pieces += tracked(replace(record, channels=channels), RATE)
    joined = pool_measurements(pieces)
    assert (joined.windows, whole.windows) == (8, 9)
    np.testing.assert_allclose(side_lines(joined).amplitude, side_lines(whole).amplitude, atol=5e-4)


def test_mains_hum_in_a_component_is_no_line():
    """Truth: hum of 50.02 Hz in a force, 1.25 times the step rate, and twice that; the other lines as without it."""
    rate, seconds, sample_rate_hz, rng = 50.02 / 1.25, 10.0, 4000.0, np.random.default_rng(1)
    t = np.arange(round(seconds * sample_rate_hz)) / sample_rate_hz
    torque, force = (size * np.cos(2.0 * np.pi * rate * t) for size in (0.1, 0.5))
    hum = sum(0.2 / k * np.cos(2.0 * np.pi * k * 50.02 * t) for k in (1, 2, 3))
    noise = 1e-3 * rng.standard_normal((2, t.size))
    (plain,) = side_components([torque + noise[0], force + hum + noise[1]], rate * t, sample_rate_hz)
    (found,) = side_components([torque + noise[0], force + hum + noise[1]], rate * t, sample_rate_hz, 50.02)
    at = {order: TRACKED.index(order) for order in (1.0, 1.25, 2.5)}
    assert side_lines(plain).heard[at[1.25], 0]
    assert np.flatnonzero(side_lines(found).heard[:, 0]).tolist() == [at[1.0]]
    assert side_lines(found).amplitude[at[1.0], 0] == pytest.approx(0.5, rel=1e-2)
