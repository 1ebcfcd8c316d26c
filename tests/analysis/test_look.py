"""A record by itself. Truth: what the test has put in, and the mechanism of the independent simulator's records."""

import math
from pathlib import Path

import numpy as np
import pytest

from mechid.analysis.look import Drive, look_at
from mechid.command import Command, RateProfile
from mechid.records import Channel, Record

RATE_HZ = 2000.0
TIME = np.arange(40_000) / RATE_HZ


def record(y, **channel):
    made = Channel(quantity="torque", unit="N*m", data=y, role="output", column="Mz", **channel)
    return Record(name="a", path=Path("a.csv"), digest="", time_start_s=0.0, sample_rate_hz=RATE_HZ, channels=(made,))


def noise(seed, sigma=0.01):
    return sigma * np.random.default_rng(seed).standard_normal(TIME.size)


def stepped(rate, **changes):
    return Drive(command=Command(stepping="full", microsteps=1, rate=rate), **changes)


def test_orders_of_a_constant_rate_have_their_amplitude_and_sigma():
    """Over 12 draws the distance to the truth is about one sigma; the square of a line in noise is not overrated."""
    rate, z = RateProfile.constant(20.0), []
    for seed in range(12):
        y = 0.05 * np.sin(2.0 * np.pi * 20.0 * TIME) + noise(seed, 0.1)
        (channel,) = look_at(record(y), stepped(rate)).channels
        first = next(line for line in channel.step_lines if line.order == 1.0)
        z.append((first.amplitude - 0.05) / first.sigma)
    assert np.sqrt(np.mean(np.square(z))) == pytest.approx(1.0, abs=0.6)


def test_lines_are_named_by_order_and_by_mains():
    y = sum(np.sin(2.0 * np.pi * o * 23.0 * TIME) for o in (0.5, 1.0, 2.0, 3.0)) + noise(2)
    y += 0.1 * np.sin(2.0 * np.pi * 50.0 * TIME) + 0.05 * np.sin(2.0 * np.pi * 333.3 * TIME)
    (channel,) = look_at(record(y), stepped(RateProfile.constant(23.0))).channels
    names = {
        round(seen.line.frequency_hz, 1): (seen.order, seen.mains and seen.mains.mains_hz) for seen in channel.lines
    }
    assert names == {
        11.5: (0.5, None),
        23.0: (1.0, None),
        46.0: (2.0, None),
        69.0: (3.0, None),
        50.0: (None, 50.0),
        333.3: (None, None),
    }


def test_hum_is_no_step_rate():
    y = sum(np.sin(2.0 * np.pi * 50.0 * k * TIME) / k for k in (1, 2, 3, 5)) + noise(3)
    assert look_at(record(y)).suggested is None


@pytest.mark.parametrize(
    ("make", "rests_on"),
    [
        (lambda: np.sin(2.0 * np.pi * 20.0 * TIME) + noise(4), "floor"),
        (lambda: 0.2 * np.rint(5.0 * (np.sin(2.0 * np.pi * 0.2 * TIME))), "resolution"),
        (
            lambda: np.where(TIME > 10.0, np.sin(40.0 * TIME), 0.0) + np.convolve(noise(5), np.full(9, 0.3), "same"),
            "quiet stretch",
        ),
    ],
    ids=["white", "coarse", "coloured"],
)
def test_the_noise_says_what_it_rests_on(make, rests_on):
    y = make()
    (channel,) = look_at(record(y)).channels
    assert channel.noise.rests_on == rests_on
    truth = {"floor": 0.01, "resolution": 0.2 / math.sqrt(12.0), "quiet stretch": 0.01 * 0.3 * 3.0}[rests_on]
    near = 0.25 if rests_on == "quiet stretch" else 0.1  # coloured noise scatters, and its quieter parts are picked
    assert channel.noise.sigma == pytest.approx(truth, rel=near)


def test_gaps_clipping_and_spikes_are_found_where_they_are():
    y = 2.0 * np.sin(2.0 * np.pi * 1.0 * TIME) + noise(6, 1e-3)
    y = np.clip(y, -1.5, 1.5)
    y[7_777] += 1.0
    missing = np.arange(1_000, 1_010)
    (channel,) = look_at(record(y, bridged=missing)).channels
    assert channel.gaps == ((1_000, 1_010),)
    assert 7_777 in channel.spikes
    assert len(channel.clipped) == 40
    assert channel.rms == pytest.approx(np.std(y))


def test_three_phases_have_lines_at_sixths():
    """Truth: sines of 0.2 and 0.1 N m at a sixth and a third of the step rate, the orders of six steps a period."""
    y = 0.2 * np.sin(2.0 * np.pi * 5.0 * TIME) + 0.1 * np.sin(2.0 * np.pi * 10.0 * TIME) + noise(0, 1e-3)
    command = Command(stepping="full", microsteps=1, rate=RateProfile.constant(30.0), phases=3)
    (channel,) = look_at(record(y), Drive(command=command)).channels
    found = {round(one.order, 6): one.amplitude for one in channel.step_lines}
    assert found[round(1 / 6, 6)] == pytest.approx(0.2, rel=0.01)
    assert found[round(1 / 3, 6)] == pytest.approx(0.1, rel=0.01)
    assert {round(one.order, 6) for one in channel.lines if one.order} == {round(1 / 6, 6), round(1 / 3, 6)}
