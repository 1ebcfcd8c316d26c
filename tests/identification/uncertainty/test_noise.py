"""Spikes, coloured noise and small model errors: what is done about them on the way to the estimate."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from mechid.campaign.identify_options import IdentifyOptions
from mechid.identification.identify import identify
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import target_of
from mechid.identification.result.grade import FitOutcome
from mechid.identification.search.solve import solve
from mechid.identification.uncertainty.covariance import residual, uncertainty
from mechid.identification.uncertainty.noise import (
    reject_outliers,
    reject_spikes,
    release_noise,
    set_residual_levels,
)
from synthetic import (
    COMMANDS,
    NOISE_NM,
    campaign,
    displaced,
    measured,
    measuring,
    record,
    torque_of,
    truth,
    with_leading,
)

GEAR = {"gear.stiffness": 1.1, "gear.damping": 0.8}
SHORT_S = 0.12
SPIKES = (40, 333, 334, 700, 1100)
"""Two beside each other, and one in the first step."""


def spiky(fraction):
    torque = measured(truth(), COMMANDS["full_46"], np.random.default_rng(71), seconds=SHORT_S)
    torque[list(SPIKES)] += fraction * np.array([1.0, 1.0, -1.0, -1.0, 1.0])
    made = campaign(displaced(truth(), GEAR), record("full_46", torque, COMMANDS["full_46"]))
    return replace(made, options=IdentifyOptions(spikes="reject"))


@pytest.mark.parametrize("height", [0.05, 1.0])
def test_the_spikes_added_are_those_rejected(height):
    """Truth: the samples that were changed, and the mechanism that made the record."""
    fit = identify(spiky(height), workers=1)
    assert fit.outcome is FitOutcome.CONVERGED
    assert fit.records["full_46"].rejected == len(SPIKES)
    said = next(w for w in fit.warnings if "rejected as spikes" in w)
    assert all(f"{k / 1e4:.6g}" in said for k in SPIKES)
    assert fit.records["full_46"].residual_rms == pytest.approx(NOISE_NM, rel=0.1)
    for name in GEAR:
        p = fit.parameters[name]
        assert abs(p.value - truth().value(name)) < 4.0 * p.std_error


@pytest.mark.parametrize("name", list(COMMANDS))
def test_a_clean_record_has_no_spikes(name):
    """Truth: none was added; full steps are as sharp as torque gets, the housing's peaks among them."""
    torque = measured(truth(), COMMANDS[name], np.random.default_rng(72), seconds=1.0)
    target = target_of(record(name, torque, COMMANDS[name]))
    assert reject_spikes(target) is target
    problem = Problem(SearchSpace(displaced(truth(), dict.fromkeys(GEAR, 1.0))), (target,), substeps=2)
    assert reject_outliers(problem, problem.start, problem.whole_windows()) is problem


AR = np.array([1.0, -2.0 * 0.9 * np.cos(2.0 * np.pi * 888.0 / 1e4), 0.81])
"""Poles of radius 0.9 at 888 Hz, sampled at 10 kHz: where the housing resonates."""


def coloured(rng, samples):
    _, a1, a2 = AR
    variance = (1.0 + a2) / ((1.0 - a2) * ((1.0 + a2) ** 2 - a1**2))
    return lfilter([1.0], AR, NOISE_NM / np.sqrt(variance) * rng.standard_normal(samples + 500))[500:]


def whitened(draws, seconds):
    """Return errors, (draws, n), and both covariances of fits under this noise with a prefilter, from the truth."""
    names = ("gear.stiffness", "gear.damping", "stepper.torque_constant", "housing.frequency")
    space = SearchSpace(truth().with_free(names))
    torque = torque_of(truth(), COMMANDS["full_46"], round(seconds * 1e4) + 1)
    target = with_leading(target_of(record("full_46", torque, COMMANDS["full_46"])), sigma=NOISE_NM)
    found = []
    for rng in np.random.default_rng(73).spawn(draws):
        noisy = measuring(target, torque + coloured(rng, torque.size))
        here = Problem(space, (noisy,), substeps=2)
        here, _ = release_noise(here, here.start, here.whole_windows(), IdentifyOptions(colour="prefilter"))
        solution = solve(here, here.start, here.whole_windows())
        every = np.ones(here.size, dtype=bool)
        u = uncertainty(here, solution.q, here.whole_windows(), solution.triangle, every)
        found.append((solution.q - here.start, u.white, u.robust, here.targets[0].leading.prefilter))
    return found


def test_a_prefilter_whitens_coloured_noise():
    """Truth: the AR(2) process that was added; of white residuals both covariances are the same."""
    ((_, white, robust, prefilter),) = whitened(1, 0.4)
    assert prefilter.order == 2
    assert prefilter.coefficients == pytest.approx(AR, abs=0.05)
    assert np.sqrt(np.diag(robust)) == pytest.approx(np.sqrt(np.diag(white)), rel=0.05)


@pytest.mark.slow
def test_estimates_behind_a_prefilter_scatter_as_reported():
    """Truth: the scatter over 60 draws of the noise."""
    draws = 60
    found = whitened(draws, 0.2)
    errors, white = np.array([f[0] for f in found]), np.array([f[1] for f in found])
    ratio = np.mean(errors**2 / np.diagonal(white, axis1=1, axis2=2), axis=0)
    assert ratio == pytest.approx(1.0, abs=0.1 + 4.0 * np.sqrt(2.0 / draws))


@pytest.mark.slow
@pytest.mark.parametrize("terms", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_record_with_a_small_model_error_is_judged_by_itself(terms):
    """Truth: a sine of 1.1 sigma that no parameter makes; the model follows all the rest to the end.

    The residual is larger than the noise floor throughout, which the growth that confirms cannot help.
    """
    torque = measured(truth(), COMMANDS["full_46"], np.random.default_rng(74), seconds=0.3)
    torque += 1.1 * np.sqrt(2.0) * NOISE_NM * np.sin(2.0 * np.pi * 311.0 * np.arange(torque.size) / 1e4)
    made = campaign(displaced(truth(), GEAR), record("full_46", torque, COMMANDS["full_46"]))
    fit = identify(replace(made, options=IdentifyOptions(terms=terms)), workers=1)
    assert fit.outcome is FitOutcome.CONVERGED
    assert "growth again" not in [s.name for s in fit.stages]
    assert not [w for w in fit.warnings if "stick/slip threshold" in w]
    assert [w for w in fit.warnings if "the model lacks something" in w]


def test_a_record_that_fits_keeps_its_floor():
    """Truth: the noise that was added."""
    torque = measured(truth(), COMMANDS["full_46"], np.random.default_rng(75), seconds=SHORT_S)
    target = target_of(record("full_46", torque, COMMANDS["full_46"]))
    problem = Problem(SearchSpace(displaced(truth(), dict.fromkeys(GEAR, 1.0))), (target,), substeps=2)
    assert set_residual_levels(problem, problem.start).targets[0] is target
    (r,) = residual(problem, target, problem.start, (0, target.samples))
    assert float(np.std(r)) == pytest.approx(NOISE_NM, rel=0.1)
