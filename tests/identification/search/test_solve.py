"""The trust region against certified optima, with bounds, interruptions and points that cannot be simulated."""

import math

import numpy as np
import pytest

from mechid.identification.identify import identify
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.reduction import Triangle, absorb, drop_projected_rows
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import target_of
from mechid.identification.result.grade import FitOutcome
from mechid.identification.search.solve import covariance, descend, solve
from synthetic import COMMANDS, campaign, displaced, measured, record, truth

X = np.array([77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0])
Y = np.array([10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78])
"""Misra1a of the NIST Statistical Reference Datasets: y = b1 (1 - exp(-b2 x))."""
CERTIFIED = np.array([2.3894212918e2, 5.5015643181e-4])
CERTIFIED_ERRORS = np.array([2.7070075241, 7.2668688436e-6])
CERTIFIED_SQUARES = 1.2455138894e-1
STARTS = ([500.0, 1e-4], [250.0, 5e-4])
FAR = (np.array([1.0, 1e-6]), np.array([1e4, 1e-2]))


def residual(q):
    return q[0] * (1.0 - np.exp(-q[1] * X)) - Y


def jacobian(q):
    decay = np.exp(-q[1] * X)
    return np.column_stack([1.0 - decay, q[0] * X * decay])


def norm(q):
    return float(np.linalg.norm(residual(q)))


def triangle(q):
    """Return the triangle of [r J], as the records' blocks leave it."""
    rows = np.column_stack([residual(q), jacobian(q)])
    R = np.zeros((3, 3))
    absorb(R, np.ascontiguousarray(rows.T), len(rows))
    return drop_projected_rows(R, 0, len(rows))


def least(start, bounds=FAR, norm=norm, triangle=triangle, steps=200):
    return descend(norm, triangle, np.array(start), bounds, steps=steps, tolerance=1e-14)


@pytest.mark.parametrize("start", STARTS)
def test_the_certified_optimum_is_found(start):
    """Truth: NIST's certified values, errors and sum of squares, from both of its starts."""
    found = least(start)
    assert found.converged
    np.testing.assert_allclose(found.q, CERTIFIED, rtol=1e-7)
    assert found.triangle.cost == pytest.approx(CERTIFIED_SQUARES, rel=1e-9)
    errors = np.sqrt(np.diag(covariance(found.triangle)) * CERTIFIED_SQUARES / 12)
    np.testing.assert_allclose(errors, CERTIFIED_ERRORS, rtol=1e-6)


@pytest.mark.parametrize("start", STARTS)
def test_an_active_bound_is_kept_and_the_rest_is_optimal_on_it(start):
    """Truth: with b2 at its limit the model is linear in b1, whose optimum is f.y / f.f."""
    limit = 5e-4
    found = least(start, (FAR[0], np.array([1e4, limit])))
    f = 1.0 - np.exp(-limit * X)
    assert found.q[1] <= limit
    assert found.q[1] == pytest.approx(limit, rel=1e-6)
    assert found.q[0] == pytest.approx(f @ Y / (f @ f), rel=1e-6)


def test_a_start_on_its_bounds_gets_away():
    """Truth: NIST's certified values, from a corner of the box."""
    found = least([500.0, 1e-4], (np.array([1.0, 1e-4]), np.array([500.0, 1e-2])))
    np.testing.assert_allclose(found.q, CERTIFIED, rtol=1e-7)


def test_it_says_when_it_runs_out_of_steps():
    """Truth: two steps from afar are not enough."""
    found = least([500.0, 1e-4], steps=2)
    assert not found.converged
    assert found.triangle.cost > 2.0 * CERTIFIED_SQUARES


def test_points_that_fail_are_never_good():
    """Truth: beyond a wall nothing can be simulated; the search stays before it, at the finite cost it has there."""
    wall = 5.3e-4

    def failing(q):
        return math.inf if q[1] > wall else norm(q)

    found = least([250.0, 5e-4], norm=failing)
    assert found.q[1] <= wall
    assert found.triangle.norm == pytest.approx(norm(found.q), rel=4.0 * np.finfo(float).eps)  # summed in another order
    assert CERTIFIED_SQUARES < found.triangle.cost < norm(np.array([250.0, 5e-4])) ** 2


@pytest.mark.parametrize("value", [math.inf, math.nan])
def test_where_nothing_can_be_simulated_the_start_stays_with_infinite_cost(value):
    def lost(q):
        return Triangle(math.inf, np.full((3, 2), math.nan), 0)

    found = least([250.0, 5e-4], norm=lambda q: value, triangle=lost)
    assert not found.converged
    assert found.triangle.norm == math.inf
    np.testing.assert_array_equal(found.q, [250.0, 5e-4])


def test_failing_sensitivities_end_the_search_at_the_last_good_point():
    """Truth: the point at which the sensitivities were last finite."""
    good = []

    def failing(q):
        if len(good) == 2:
            return Triangle(math.inf, np.full((3, 2), math.nan), 0)
        good.append(q.copy())
        return triangle(q)

    found = least([500.0, 1e-4], triangle=failing)
    assert not found.converged
    np.testing.assert_array_equal(found.q, good[-1])
    assert found.triangle.norm == pytest.approx(norm(good[-1]), rel=1e-12)


FREE = {"gear.stiffness": 1.05, "gear.damping": 0.8, "stepper.coil_resistance": 1.02}


@pytest.fixture(scope="module")
def problem():
    """Return a short record and a start some percent beside its truth."""
    torque = measured(truth(), COMMANDS["full_46"], np.random.default_rng(8), seconds=0.1)
    own = record("full_46", torque, COMMANDS["full_46"])
    return Problem(SearchSpace(displaced(truth(), FREE)), (target_of(own),), substeps=2)


@pytest.fixture(scope="module")
def lost():
    """Return a campaign whose mechanism diverges wherever it starts: the load has next to no inertia."""
    torque = measured(truth(), COMMANDS["full_46"], np.random.default_rng(9), seconds=0.1)
    start = displaced(truth({"load.inertia": 1e-9}), FREE)
    return campaign(start, record("full_46", torque, COMMANDS["full_46"]))


def test_a_short_record_is_fitted_to_its_truth(problem):
    """Truth: the mechanism that made the record, in Fisher's measure: 3 parameters, a chi-square below 20."""
    found = solve(problem, problem.start, problem.whole_windows())
    off = found.q - SearchSpace(truth().with_free(tuple(FREE))).start
    assert found.converged
    assert off @ np.linalg.solve(covariance(found.triangle), off) < 20.0
    assert found.triangle.cost < 0.01 * problem.joint(problem.start, problem.whole_windows()).cost


@pytest.mark.parametrize("calls", [1, 2, 3])
def test_an_interrupt_leaves_the_best_accepted_point(problem, calls):
    """Truth: each accepted point is better than those before, and an interruption passes through."""
    accepted, told = [], []

    def stop(cost):
        told.append(cost)
        if len(told) == calls:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        solve(
            problem, problem.start, problem.whole_windows(), progress=stop, accepted=lambda q: accepted.append(q.copy())
        )
    costs = [problem.joint(q, problem.whole_windows()).cost for q in accepted]
    assert costs == sorted(costs, reverse=True)
    assert len(set(costs)) == len(costs)
    assert not costs or costs[-1] == pytest.approx(min(told[: len(told) - 1]), rel=1e-9)


def test_a_failed_simulation_costs_everything(lost):
    """Truth: nothing is known of it, which is infinitely bad, not free of residual."""
    problem = Problem(SearchSpace(lost.mechanism), (target_of(lost.records[0]),))
    assert problem.norms(problem.start, problem.whole_windows()) == [math.inf]
    assert problem.joint(problem.start, problem.whole_windows()).norm == math.inf
    found = solve(problem, problem.start, problem.whole_windows())
    assert (found.converged, found.triangle.norm) == (False, math.inf)


def test_a_mechanism_that_diverges_is_no_fit(lost):
    """Truth: the file; its values stay, nothing has an error, and the records no fit."""
    fit = identify(lost, workers=1)
    assert fit.outcome is FitOutcome.FAILED
    for name in FREE:
        p = fit.parameters[name]
        assert (p.value, p.std_error) == (lost.mechanism.value(name), None)
    assert math.isnan(fit.records["full_46"].residual_rms)
