"""A record by itself. Truth: what the test has put in, and the mechanism of the independent simulator's records."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from mechid.analysis.look import Drive, look_at
from mechid.analysis.shared_resonances import shared_resonances
from mechid.analysis.survey import survey
from mechid.command import Command, RateProfile
from mechid.command.edges import steps_travelled
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


def test_a_resonance_in_a_sweep_is_told_from_what_follows_the_rate():
    """A resonance at 46 Hz lifts orders 1 and 2; a third order that is large at 60 steps/s alone is none."""
    rate = RateProfile.through([(0.0, 5.0), (20.0, 100.0)])
    travel, now = steps_travelled(rate, TIME), np.interp(TIME, (0.0, 20.0), (5.0, 100.0))

    def response(f):
        return 1.0 / np.hypot(1.0 - (f / 46.0) ** 2, 0.1 * f / 46.0)

    y = sum(0.1 / o * response(o * now) * np.sin(2.0 * np.pi * o * travel) for o in (1.0, 2.0))
    y = y + 0.3 * np.exp(-(((now - 60.0) / 4.0) ** 2)) * np.sin(2.0 * np.pi * 3.0 * travel) + noise(1)
    look = look_at(record(y), stepped(rate))
    tracked = [found for found in look.channels[0].resonances if found.orders]
    assert [(round(found.frequency_hz), found.orders) for found in tracked] == [(46, (1.0, 2.0))]
    assert [round(one.frequency_hz) for one in shared_resonances([look])] == [46]
    peak = max((line for line in look.channels[0].over_rate if line.order == 1.0), key=lambda line: line.power())
    assert peak.rate == pytest.approx(46.0, abs=2.0)
    assert math.sqrt(peak.power()) == pytest.approx(0.1 * 10.0, rel=0.1)


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


def test_the_mechanism_of_the_independent_simulator(campaign_folder):
    """Truth: the housing's frequency and that of the gear under the load, within the width of the humps."""
    truth = json.loads((campaign_folder / "noisy" / "truth.json").read_text())
    found = survey([campaign_folder / "noisy" / "campaign.toml"])
    low, high = (one.frequency_hz for one in shared_resonances(found.looks))
    assert low == pytest.approx(59.4, abs=1.0)  # the campaign drives it at its resonance
    assert high == pytest.approx(truth["housing.frequency"] / (2.0 * math.pi), rel=0.05)
    for look in found.looks:
        assert look.channels[0].noise.sigma == pytest.approx(0.002, rel=0.05)
