"""Predicted standard errors against what identify reports of records with noise, and against their scatter."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from mechid.campaign.bench import TRUTH
from mechid.designs.planned_record import PlannedRecord
from mechid.designs.prediction import NO_PHASE, ON_BOUND, UNSEEN, planned_problem, predicted_errors
from mechid.identification.identify import identify
from mechid.identification.output_error.space import SearchSpace
from refits import normalised
from synthetic import COMMANDS, bench, truth

SECONDS = 0.3
NAMES = ("full_46", "micro_92")


def planned(*names, seconds=SECONDS):
    return [PlannedRecord(name=n, command=COMMANDS[n], duration_s=seconds) for n in names]


def test_the_prediction_is_what_identify_reports():
    """Truth: standard errors of a fit to noisy records of the same commands, all 15 parameters, before any is taken.

    Residuals give sigma to 1 % in 6000 samples, and the fit is a standard error or so away: 4 %.
    """
    space = SearchSpace(truth())
    problem = planned_problem(space, planned(*NAMES))
    errors = predicted_errors(problem, problem.start)
    fit = identify(bench(truth(), truth(), *NAMES, seed=2, seconds=SECONDS), near=TRUTH)
    assert fit.outcome.good
    assert not errors.reasons
    for name in errors.names:
        assert errors.std_error(name) == pytest.approx(fit.parameters[name].std_error_white, rel=0.04), name


def test_the_scatter_of_refits_is_as_predicted():
    """Truth: the squared distances of refits from the truth add up to chi-square, within its 0.1 % quantiles."""
    space = SearchSpace(truth().with_free(("stepper.torque_constant", "gear.stiffness", "gear.damping")))
    _, distance = normalised(planned_problem(space, planned("full_46")), 24, seed=7)
    low, high = chi2.ppf([0.001, 0.999], 24 * 3)
    assert low < distance.sum() < high


def test_what_has_no_standard_error_says_why():
    """Truth: the housing is not seen at rest, a detent of zero torque has no phase, a value on its bound none."""
    q = truth().parameters["gear.damping"]
    mechanism = truth({"stepper.detent.1.amplitude": 0.0}).with_parameters({q.name: replace(q, value=q.max)})
    problem = planned_problem(SearchSpace(mechanism), planned("full_46"))
    errors = predicted_errors(problem, problem.start)
    assert errors.reasons == {"gear.damping": ON_BOUND, "stepper.detent.1.phase_deg": NO_PHASE}
    assert errors.std_error("gear.damping") is None
    resting = replace(
        planned("full_46")[0],
        command=replace(COMMANDS["full_46"], rate=replace(COMMANDS["full_46"].rate, rates=(0.0,))),
    )
    still = planned_problem(SearchSpace(truth({"friction.static": 0.09})), [resting])
    assert set(predicted_errors(still, still.start).reasons.values()) == {UNSEEN}


def test_what_is_known_already_counts():
    """Truth: a record's own information twice is the record twice: standard errors fall by the root of two."""
    problem = planned_problem(SearchSpace(truth()), planned(*NAMES))
    alone = predicted_errors(problem, problem.start)
    J = problem.joint(problem.start, problem.whole_windows()).jacobian
    both = predicted_errors(problem, problem.start, J.T @ J)
    for name in alone.names:
        assert both.std_error(name) == pytest.approx(alone.std_error(name) / np.sqrt(2.0), rel=1e-4)
