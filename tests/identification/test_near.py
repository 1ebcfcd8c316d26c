"""An identification from values that are near already: no search, and what they leave of the records is noise."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from mechid.campaign.bench import TRUTH
from mechid.identification.identify import identify
from mechid.identification.result.fit import FitOutcome
from synthetic import COMMANDS, NOISE_NM, RATE_HZ, bench, campaign, displaced, record, torque_of, truth

FREE = ("gear.stiffness", "gear.damping", "stepper.torque_constant", "housing.gain")
NEAR = {name: TRUTH[name] for name in FREE}


def coloured(seed, *, hertz, radius, samples, settled=5000):
    """Return two records of the truth in settled noise of an AR(2) process, told by its poles' frequency and radius."""
    rng = np.random.default_rng(seed)
    a = [1.0, -2.0 * radius * math.cos(2.0 * math.pi * hertz / RATE_HZ), radius**2]
    records = []
    for name in ("full_46", "micro_46"):
        noise = lfilter([1.0], a, rng.standard_normal(settled + samples))[settled:]
        torque = torque_of(truth(), COMMANDS[name], samples) + NOISE_NM * noise / noise.std()
        records.append(record(name, torque, COMMANDS[name]))
    return records


def assert_true(fit):
    """See that a fit has converged to the values that made the records, within 5 sigma."""
    assert fit.outcome is FitOutcome.CONVERGED
    for name, value in NEAR.items():
        p = fit.parameters[name]
        assert abs(p.value - value) < 5.0 * p.std_error, name


def test_it_ends_where_the_search_ends():
    """Truth: the optimum that the search finds from a start some way off, to a hundredth of a standard error."""
    start = displaced(truth(), dict.fromkeys(FREE, 1.3))
    records = bench(start, truth(), "full_46", "micro_46", seed=9, seconds=0.3)
    searched, near = identify(records), identify(records, near=NEAR)
    assert [s.name for s in near.stages] == ["joint fit", "noise re-estimated"]
    assert near.outcome is FitOutcome.CONVERGED
    for name in FREE:
        p = searched.parameters[name]
        assert near.parameters[name].value == pytest.approx(p.value, abs=0.01 * p.std_error), name


def test_noise_is_what_is_left_also_where_it_is_coloured():
    """Truth: the values that made the records, within 5 sigma; the noise's floor is ten times too low here."""
    records = coloured(12, hertz=888.0, radius=0.9, samples=3001)
    assert_true(identify(campaign(displaced(truth(), dict.fromkeys(FREE, 1.3)), *records), near=NEAR))


def test_a_quiet_stretch_tells_the_search_how_loud_coloured_noise_is():
    """Truth: the values that made the records, within 5 sigma, from a start some way off; the floor alone misleads."""
    quiet = {"step": "quiet", "text": "", "channel": "torque", "rms": NOISE_NM}
    heard = coloured(14, hertz=888.0, radius=0.9, samples=4001)
    told = [replace(r, data=replace(r.data, treatments=(quiet,))) for r in heard]
    fit = identify(campaign(displaced(truth(), dict.fromkeys(FREE, 1.2)), *told))
    assert_true(fit)
    assert all(r.prefilter_order >= 2 for r in fit.records.values())


def test_a_narrow_resonance_in_the_noise_is_whitened_until_it_is_white():
    """Truth: the AR(2) process added, and the values that made the records, within 5 sigma.

    Weighted by sample alone the first fit errs by more than the process's own innovation, 200 times below its RMS:
    the filter of what that leaves is not the noise's, and the errors behind it are not those of white noise.
    """
    records = coloured(13, hertz=46.0, radius=0.99, samples=4001, settled=10_000)
    fit = identify(campaign(displaced(truth(), dict.fromkeys(FREE, 1.3)), *records), near=NEAR)
    assert_true(fit)
    assert "whitened again" in [s.name for s in fit.stages]
    assert [r.prefilter_order for r in fit.records.values()] == [2, 2]
    for name in NEAR:
        p = fit.parameters[name]
        assert p.std_error == pytest.approx(p.std_error_white, rel=0.05), name
