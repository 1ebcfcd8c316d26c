"""The grid's frequency in several series, and lines that follow its drift. Truth: what made the series."""

import numpy as np
import pytest
from scipy.signal import zoom_fft

from mechid.signal.grid import HumSeries, _power, _powers, combined_amplitude, drifting_lines, evident_grid
from mechid.signal.trend import fit_line
from mechid.signal.window import hann

RATE_HZ, NOISE = 2000.0, 2e-3


def hummed(seconds, hz, rng, *, size=2e-3, drift_hz=0.0, more=0.0):
    """Return noise with hum of three multiples, whose frequency rises by so much over the series."""
    t = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    turns = (hz - 0.5 * drift_hz) * t + 0.5 * drift_hz / seconds * t**2 + rng.random()
    hum = size * sum(np.sin(2.0 * np.pi * k * turns + k) / k for k in (1, 2, 3))
    return HumSeries(NOISE * rng.standard_normal(t.size) + hum + more, RATE_HZ)


@pytest.mark.parametrize(("hz", "nominal"), [(50.02, 50.0), (49.95, 50.0), (60.03, 60.0), (50.17, 50.0), (59.8, 60.0)])
def test_several_records_tell_the_frequency_together(hz, nominal):
    """Truth: that of the hum, of which no record has more than a third of its noise."""
    rng = np.random.default_rng(1)
    some = [hummed(seconds, hz, rng, size=NOISE / 3.0) for seconds in (1.0, 4.0, 20.0)]
    found = evident_grid(some, nominal)
    assert found.hz == pytest.approx(hz, abs=2e-3)
    for own, one in zip(found.own_hz, some, strict=True):
        assert own == pytest.approx(hz, abs=2e-3)
        left = one.series - fit_line(one.series, 0, None, [k * own / RATE_HZ for k in (1, 2, 3)]).at(0, one.series.size)
        assert np.std(left) == pytest.approx(NOISE, rel=0.02)


def test_a_record_of_another_day_has_its_own():
    rng = np.random.default_rng(2)
    some = [hummed(30.0, 50.02, rng), hummed(30.0, 49.96, rng), hummed(1.0, 50.02, rng)]
    each = evident_grid(some, 50.0).own_hz
    np.testing.assert_allclose(each[:2], [50.02, 49.96], atol=1e-3)


@pytest.mark.parametrize("seed", range(20))
def test_noise_alone_is_no_hum(seed):
    rng = np.random.default_rng(seed)
    some = [HumSeries(np.cumsum(rng.standard_normal(round(s * RATE_HZ))) * 1e-3, RATE_HZ) for s in (1.0, 5.0, 20.0)]
    assert evident_grid(some, 50.0) is None


@pytest.mark.parametrize("drift_hz", [0.0, 0.02, -0.02, 0.05])
@pytest.mark.parametrize("seconds", [20.0, 60.0])
def test_lines_follow_a_slow_drift(drift_hz, seconds):
    """Truth: hum ten times the noise whose frequency drifts; at its multiples less than the noise's own is left."""
    rng = np.random.default_rng(3)
    one = hummed(seconds, 50.02, rng, size=10.0 * NOISE, drift_hz=drift_hz)
    (own,) = evident_grid([one], 50.0).own_hz
    lines = [line for k in (1, 2, 3) for line in drifting_lines(one, k * own)]
    assert drift_hz or len(lines) == 3
    fitted = fit_line(one.series, 0, None, [line / RATE_HZ for line in lines])
    left = one.series - fitted.at(0, one.series.size)
    assert np.std(left) == pytest.approx(NOISE, rel=0.02)
    spectrum, hz = np.abs(np.fft.rfft(left)) ** 2, np.fft.rfftfreq(left.size, 1.0 / RATE_HZ)
    for k in (1, 2, 3):
        near, around = np.abs(hz - k * 50.02) < 0.15, np.abs(hz - k * 50.02) < 5.0
        noise = np.mean(spectrum[around & ~near])
        assert (
            np.sum(spectrum[near]) < (near.sum() + 2.0 * np.log(spectrum.size)) * noise
        )  # what pays for no more lines
    waves = [(w.turns * RATE_HZ, np.hypot(w.cosine, w.sine), np.arctan2(-w.sine, w.cosine)) for w in fitted.waves]
    for k in (1, 2, 3):
        size = combined_amplitude([wave for wave in waves if abs(wave[0] / (k * 50.0) - 1.0) < 0.01])
        assert size == pytest.approx(10.0 * NOISE / k, rel=0.02)


def test_orders_that_cross_the_grid_are_no_hum():
    """Truth: a sweep whose lines pass 50 Hz and its multiples, with no hum; and what is projected of it with hum."""
    rng = np.random.default_rng(4)
    t = np.arange(round(20.0 * RATE_HZ)) / RATE_HZ
    steps = sum(np.sin(2.0 * np.pi * order * 2.0 * t**2) for order in (0.5, 1.0, 1.5, 2.0, 4.0)) * 10.0 * NOISE
    quiet = HumSeries(steps + NOISE * rng.standard_normal(t.size), RATE_HZ)
    assert evident_grid([quiet], 50.0) is None
    lines = [k * 50.02 / RATE_HZ for k in (1, 2, 3)]
    taken = fit_line(quiet.series, 0, None, lines).at(0, t.size)
    assert np.std(taken) < 0.02 * np.std(quiet.series)


def test_a_band_of_a_long_series_has_the_power_of_the_whole():
    """Truth: the transform of all samples, beside a sweep whose lines are 1000 times the noise."""
    samples = 100_003
    t = np.arange(samples) / RATE_HZ
    sweep = np.sin(2.0 * np.pi * (20.0 + t) * t)
    y = (sweep + 1e-3 * np.random.default_rng(5).standard_normal(samples)) * hann(samples)
    for hz in (np.linspace(49.8, 50.2, 200), np.linspace(0.5, 12.0, 300), np.linspace(149.0, 151.0, 300)):
        whole, band = _power(y, RATE_HZ, hz), _powers(y, RATE_HZ)(hz)
        np.testing.assert_allclose(np.sqrt(band), np.sqrt(whole), rtol=0.0, atol=1e-3 * np.sqrt(np.median(whole)))


@pytest.mark.parametrize(("samples", "points"), [(1000, 37), (36, 400), (100_003, 513)])
def test_the_power_between_bins_is_that_of_the_sum(samples, points):
    """Truth: scipy.signal's zoom transform."""
    y, hz = np.random.default_rng(5).standard_normal(samples), np.linspace(49.8, 50.2, points)
    expected = np.abs(zoom_fft(y, [49.8, 50.2], points, fs=RATE_HZ, endpoint=True)) ** 2
    np.testing.assert_allclose(_power(y, RATE_HZ, hz), expected, rtol=1e-6, atol=1e-8 * expected.max())
