"""An identification from values that are near already: no search, and what they leave of the records is noise."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from mechid.campaign.bench import TRUTH
from mechid.identification.identify import identify
from mechid.identification.result.fit import FitOutcome
from synthetic import COMMANDS, NOISE_NM, bench, campaign, displaced, record, torque_of, truth

FREE = ("gear.stiffness", "gear.damping", "stepper.torque_constant", "housing.gain")
NEAR = {name: TRUTH[name] for name in FREE}


def test_it_ends_where_the_search_ends():
    """Truth: the optimum that the search finds from a start some way off, to a hundredth of a standard error."""
    start = displaced(truth(), dict.fromkeys(FREE, 1.3))
    records = bench(start, truth(), "full_46", "micro_46", seed=9, seconds=0.3)
    searched, near = identify(records), identify(records, near=NEAR)
    assert [s.name for s in near.stages] == ["joint fit", "noise released"]
    assert near.outcome is FitOutcome.CONVERGED
    for name in FREE:
        p = searched.parameters[name]
        assert near.parameters[name].value == pytest.approx(p.value, abs=0.01 * p.std_error), name


def test_noise_is_what_is_left_also_where_it_is_coloured():
    """Truth: the values that made the records, within 5 sigma; the noise's floor is ten times too low here."""
    rng = np.random.default_rng(12)
    a = [1.0, -2.0 * 0.9 * math.cos(2.0 * math.pi * 888.0 / 10_000.0), 0.81]
    records = []
    for name in ("full_46", "micro_46"):
        noise = lfilter([1.0], a, rng.standard_normal(8001))[5000:]
        torque = torque_of(truth(), COMMANDS[name], 3001) + NOISE_NM * noise / noise.std()
        records.append(record(name, torque, COMMANDS[name]))
    fit = identify(campaign(displaced(truth(), dict.fromkeys(FREE, 1.3)), *records), near=NEAR)
    assert fit.outcome is FitOutcome.CONVERGED
    for name, value in NEAR.items():
        p = fit.parameters[name]
        assert abs(p.value - value) < 5.0 * p.std_error, name


def test_a_quiet_stretch_tells_the_search_how_loud_coloured_noise_is():
    """Truth: the values that made the records, within 5 sigma, from a start some way off; the floor alone misleads."""
    rng = np.random.default_rng(14)
    a = [1.0, -2.0 * 0.9 * math.cos(2.0 * math.pi * 888.0 / 10_000.0), 0.81]
    told = []
    for name in ("full_46", "micro_46"):
        noise = lfilter([1.0], a, rng.standard_normal(9001))[5000:]
        torque = torque_of(truth(), COMMANDS[name], 4001) + NOISE_NM * noise / noise.std()
        heard = record(name, torque, COMMANDS[name])
        quiet = {"step": "quiet", "text": "", "channel": "torque", "rms": NOISE_NM}
        told.append(replace(heard, data=replace(heard.data, treatments=(quiet,))))
    fit = identify(campaign(displaced(truth(), dict.fromkeys(FREE, 1.2)), *told))
    assert fit.outcome is FitOutcome.CONVERGED
    assert all(r.prefilter_order >= 2 for r in fit.records.values())
    for name, value in NEAR.items():
        p = fit.parameters[name]
        assert abs(p.value - value) < 5.0 * p.std_error, name


def test_a_narrow_resonance_in_the_noise_is_whitened_until_it_is_white():
    """Truth: the AR(2) process added, and the values that made the records, within 5 sigma.

    Weighted by sample alone the first fit errs by more than the process's own innovation, 200 times below its RMS:
    the filter of what that leaves is not the noise's, and the errors behind it are not those of white noise.
    """
    rng = np.random.default_rng(13)
    a = [1.0, -2.0 * 0.99 * math.cos(2.0 * math.pi * 46.0 / 10_000.0), 0.99**2]
    records = []
    for name in ("full_46", "micro_46"):
        noise = lfilter([1.0], a, rng.standard_normal(14_001))[10_000:]
        torque = torque_of(truth(), COMMANDS[name], 4001) + NOISE_NM * noise / noise.std()
        records.append(record(name, torque, COMMANDS[name]))
    fit = identify(campaign(displaced(truth(), dict.fromkeys(FREE, 1.3)), *records), near=NEAR)
    assert fit.outcome is FitOutcome.CONVERGED
    assert "whitened again" in [s.name for s in fit.stages]
    assert [r.prefilter_order for r in fit.records.values()] == [2, 2]
    for name, value in NEAR.items():
        p = fit.parameters[name]
        assert abs(p.value - value) < 5.0 * p.std_error, name
        assert p.std_error == pytest.approx(p.std_error_white, rel=0.05), name
