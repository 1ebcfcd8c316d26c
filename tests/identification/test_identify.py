"""The whole identification on records that mechid did not make, and its behaviour when steered or stopped."""

import json
from dataclasses import replace

import numpy as np
import pytest

import synthetic
from mechid.campaign import Stage, load_campaign
from mechid.errors import FitError
from mechid.identification.identify import identify, identify_from, make_problem
from mechid.identification.result.grade import FitOutcome
from mechid.identification.uncertainty.covariance import residual
from synthetic import displaced


@pytest.fixture(scope="module")
def noisy(campaign_folder):
    return load_campaign(campaign_folder / "noisy")


@pytest.fixture(scope="module")
def truth(campaign_folder):
    return json.loads((campaign_folder / "noisy" / "truth.json").read_text())


@pytest.fixture(scope="module")
def fit(noisy):
    return identify(noisy, seed=0)


def squares(campaign, values):
    """Return the sum of squared residuals in units of the true sigma, 2 mN m, offset and drift fitted."""
    problem = make_problem(campaign, 1).with_sigmas({r.name: 2e-3 for r in campaign.records})
    problem = replace(problem, substeps=2)
    q = problem.space.from_values({**{p.name: p.value for p in campaign.mechanism.parameters.values()}, **values})
    return sum(float(np.sum(residual(problem, t, q, (0, t.samples))[0] ** 2)) / 4e-6 for t in problem.targets)


def test_the_optimum_is_reached_from_the_catalogue(noisy, truth, fit):
    """Truth: the key of an independent simulator's noisy campaign; no stages, catalogue start."""
    assert fit.outcome is FitOutcome.CONVERGED
    found = {p.name: p.value for p in fit.parameters.values() if p.status == "free"}
    assert squares(noisy, found) <= squares(noisy, truth)


def test_every_parameter_is_within_five_sigma_of_the_key(truth, fit):
    """Truth: the key; a phase is compared on the circle."""
    for name, value in truth.items():
        p = fit.parameters[name]
        error = p.value - value
        if p.unit == "deg":
            error = (error + 180.0) % 360.0 - 180.0
        assert abs(error) <= 5.0 * p.std_error, name


def test_what_is_written_is_json_and_complete(noisy, fit):
    """Truth: the contract of estimate.json."""
    content = json.loads(json.dumps(fit.to_dict()))
    assert set(noisy.mechanism.parameters) <= set(content["parameters"])
    assert content["parameters"]["stepper.back_emf_constant"]["status"] == "tied"
    assert np.shape(content["correlation"]["matrix"]) == (15, 15)
    np.testing.assert_allclose(np.diag(content["correlation"]["matrix"]), 1.0)
    assert set(content["records"]) == {r.name for r in noisy.records}


def test_stages_move_only_what_they_free(noisy):
    """Truth: the campaign file; the rest keeps its catalogue value, without a standard error."""
    stage = Stage(records=("full_res",), window_s=(0.0, 0.02), free=("stepper.torque_constant",))
    steered = identify(replace(noisy, stages=(stage,)))
    assert steered.outcome is FitOutcome.STAGES_DONE
    moved = steered.parameters["stepper.torque_constant"]
    held = steered.parameters["gear.stiffness"]
    assert moved.value != moved.start
    assert moved.std_error is not None
    assert (held.value, held.std_error, held.status) == (held.start, None, "frozen")


def test_an_interrupt_keeps_the_best_so_far(noisy):
    """Truth: the outcome; the search is stopped in its second stage, after the multi-start."""

    def stop(progress):
        if progress.number == 2:
            raise KeyboardInterrupt

    stopped = identify(noisy, listener=stop)
    assert stopped.outcome is FitOutcome.INTERRUPTED
    assert stopped.parameters["gear.stiffness"].value != 2200.0
    json.dumps(stopped.to_dict())


START = {"gear.stiffness": 1.15, "gear.damping": 0.8, "friction.viscous": 1.1}


@pytest.fixture(scope="module")
def campaign():
    """Return two records whose file's start is far off; the start that is given is not."""
    far = {"gear.stiffness": 2.4, "gear.damping": 1.2, "friction.viscous": 0.2}
    return synthetic.bench(
        displaced(synthetic.truth(), far), synthetic.truth(), "full_46", "micro_92", seed=3, seconds=0.3
    )


def test_it_comes_to_the_truth_and_tells_how(campaign):
    reports = []
    values = {name: synthetic.truth().value(name) * factor for name, factor in START.items()}
    fit = identify_from(campaign, values, workers=1, listener=reports.append)
    assert fit.outcome is FitOutcome.CONVERGED
    for name in START:
        p = fit.parameters[name]
        assert abs(p.value - synthetic.truth().value(name)) < 4.0 * p.std_error
        assert reports[0].values[name] == pytest.approx(values[name], rel=1e-9)
        assert reports[-1].values[name] == pytest.approx(p.value, rel=1e-9)
    samples = sum(r.data.samples for r in campaign.records)
    assert reports[0].cost > 10.0 * samples
    assert [r.number for r in reports] == sorted(r.number for r in reports)
    assert all(0 < r.number <= r.total for r in reports)


def test_nothing_free_is_said(campaign):
    held = synthetic.bench(synthetic.truth().with_free(()), synthetic.truth(), "full_46", seed=3, seconds=0.05)
    with pytest.raises(FitError, match="no parameter to estimate"):
        identify_from(held, {})
