"""Resonances in a record. Truth: those that the test has put in, and the mechanism of the independent simulator."""

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


def test_the_mechanism_of_the_independent_simulator(campaign_folder):
    """Truth: the housing's frequency and that of the gear under the load, within the width of the humps."""
    truth = json.loads((campaign_folder / "noisy" / "truth.json").read_text())
    found = survey([campaign_folder / "noisy" / "campaign.toml"])
    low, high = (one.frequency_hz for one in shared_resonances(found.looks))
    assert low == pytest.approx(59.4, abs=1.0)  # the campaign drives it at its resonance
    assert high == pytest.approx(truth["housing.frequency"] / (2.0 * math.pi), rel=0.05)
    for look in found.looks:
        assert look.channels[0].noise.sigma == pytest.approx(0.002, rel=0.05)
