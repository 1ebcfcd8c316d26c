"""Whether the likelihood around an estimate is what its derivatives say, and which switches graze."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.identification.conclude import conclude
from mechid.identification.identify import make_problem
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import target_of
from mechid.identification.result.grade import Cause, FitOutcome
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.solve import covariance, solve
from mechid.identification.uncertainty.draws import examine_draws, grazing_switches, parameters_resting_on
from synthetic import COMMANDS, NOISE_NM, campaign, displaced, measured, record, truth, with_leading

GEAR = ("gear.stiffness", "gear.damping")


def at_truth(names, *records, seconds, changes=None):
    """Return the problem at the truth, its point, windows and covariance."""
    rng, made_by = np.random.default_rng(81), truth(changes)
    targets = [target_of(record(n, measured(made_by, COMMANDS[n], rng, seconds=seconds), COMMANDS[n])) for n in records]
    space = SearchSpace(displaced(made_by, dict.fromkeys(names, 1.0)))
    problem = Problem(space, tuple(with_leading(t, sigma=NOISE_NM) for t in targets), substeps=2)
    q, windows = problem.start, problem.whole_windows()
    return problem, q, windows, covariance(problem.joint(q, windows))


def test_a_smooth_cost_departs_nowhere():
    """Truth: over 0.1 s of full steps the torque is all but linear in the gear within its errors."""
    assert examine_draws(*at_truth(GEAR, "full_46", "micro_46", seconds=0.1), 0).departures == ()


def switches(problem, target, q):
    run = problem.model.run(target, q, target.samples, jacobian=True, events=500)
    for _ in run.blocks():
        pass
    return run.switching


def test_the_logged_derivatives_are_those_of_the_instants():
    """Truth: central differences of the instants along the search coordinates."""
    problem, q, _, _ = at_truth(GEAR, "full_46", seconds=0.1)
    target = problem.targets[0]
    log = switches(problem, target, q)
    assert log.time.size >= 2
    assert log.sensitivity.shape == (log.time.size, problem.size)
    for j in range(problem.size):
        h = np.zeros(problem.size)
        h[j] = 1e-6
        by_difference = (switches(problem, target, q + h).time - switches(problem, target, q - h).time) / 2e-6
        np.testing.assert_allclose(log.sensitivity[:, j], by_difference, rtol=1e-3, atol=1e-9)


@pytest.fixture(scope="module")
def spread():
    """Return the gear's problem with a covariance so wide that instants scatter by more than a tenth of a gap."""
    problem, q, windows, narrow = at_truth(GEAR, "full_46", seconds=0.1)
    return problem, q, windows, narrow


def test_well_known_instants_do_not_graze(spread):
    """Truth: the definition, worked out from the log by hand at a tenth of the width that would graze."""
    problem, q, windows, narrow = spread
    assert grazing_switches(problem, q, windows, (0.1 / _share(problem, q, narrow) * 0.99) ** 2 * narrow) == []


def test_the_switch_that_grazes_most_is_named(spread):
    """Truth: the definition, worked out from the log by hand."""
    problem, q, windows, narrow = spread
    factor = 0.1 / _share(problem, q, narrow) * 1.01
    (found,) = grazing_switches(problem, q, windows, factor**2 * narrow)
    log = switches(problem, problem.targets[0], q)
    worst = int(np.argmax(_shares(log, narrow)))
    assert (found.record, found.count, found.switches) == ("full_46", 1, log.time.size)
    assert found.instant_s == pytest.approx(log.time[worst], abs=1e-12)
    assert found.spread_s / found.gap_s == pytest.approx(0.101, rel=1e-6)
    assert f"record full_46 at {log.time[worst]:.6g} s: the instant of a stick/slip is known only to" in str(found)


def _share(problem, q, covariance):
    return float(_shares(switches(problem, problem.targets[0], q), covariance).max())


def _shares(log, covariance):
    sigma = [float(np.sqrt(s @ covariance @ s)) for s in log.sensitivity]
    gap = [np.abs(np.delete(log.time, i) - t).min() for i, t in enumerate(log.time)]
    return np.array(sigma) / np.array(gap)


COULOMB = "friction.coulomb"


def hanging():
    """Return a Coulomb friction, N m, at which a stick hangs by a thread, and the instant it does, by bisection.

    Over 0.3 s of full steps the mechanism with the one switches twice more than that with the other.
    """
    few, many = 4.87e-4, 4.38e-4
    logs = {}
    while few - many > 1e-8:
        middle = 0.5 * (few + many)
        problem, q, *_ = at_truth((COULOMB,), "full_46", seconds=0.3, changes={COULOMB: middle})
        log = switches(problem, problem.targets[0], q)
        logs[middle] = log.time
        few, many = (middle, many) if log.time.size <= 24 else (few, middle)
    short, long = logs[few], logs[many]
    assert (short.size, long.size) == (24, 26)
    return few, float(long[np.flatnonzero(np.abs(long[:24] - short) > 1e-4)[0]])


def test_a_stick_that_comes_and_goes_is_found_in_its_record_and_instant():
    """Truth: where, by bisection, the one stick more comes in; the record of microsteps has no switch at all."""
    value, instant = hanging()
    problem, q, windows, own = at_truth((COULOMB,), "full_46", "micro_92", seconds=0.3, changes={COULOMB: value})
    assert np.sqrt(own[0, 0]) > 1e-6  # the thread lies within the error
    (found,) = examine_draws(problem, q, windows, own, 0).departures
    assert found.record == "full_46"
    assert 5 <= found.draws <= 25  # half of them fall to the other side
    assert abs(found.instant_s - instant) < 5e-3
    assert found.across == (COULOMB,)  # the thread hangs to one side


def test_a_standard_error_rests_on_the_record_that_tells_it():
    """Truth: the stiffness moves full steps, and microsteps above the resonance far less."""
    problem, q, windows, _ = at_truth(("gear.stiffness",), "full_46", "micro_92", seconds=0.3)
    every = np.ones(1, dtype=bool)
    assert parameters_resting_on(problem, q, windows, ["full_46"], every) == ("gear.stiffness",)
    assert parameters_resting_on(problem, q, windows, ["micro_92"], every) == ()


@pytest.fixture(scope="module")
def beside_the_optimum():
    """Return a campaign and a state that calls itself converged 2.5 standard errors beside its optimum."""
    rng, made_by = np.random.default_rng(81), truth()
    start = displaced(made_by, dict.fromkeys(GEAR, 1.0))
    names = ("full_46", "micro_46")
    records = [record(n, measured(made_by, COMMANDS[n], rng, seconds=0.3), COMMANDS[n]) for n in names]
    of = campaign(start, *records)
    problem = make_problem(of, 1)
    problem = replace(problem, targets=tuple(with_leading(t, sigma=NOISE_NM) for t in problem.targets), substeps=2)
    windows = problem.whole_windows()
    best = solve(problem, problem.start, windows)
    q = best.q + 2.5 * np.sqrt(np.diag(covariance(best.triangle))) * [1.0, 0.0]
    state = SearchState(problem, q, windows, outcome=FitOutcome.CONVERGED, searched=True)
    return of, state, best


def test_a_draw_that_is_lower_than_the_point_it_is_drawn_about_is_found(beside_the_optimum):
    """Truth: the costs, simulated again; 2.5 standard errors off the cost is 6.25 above that of the optimum."""
    _, state, best = beside_the_optimum
    lower = examine_draws(state.problem, state.q, state.windows, covariance(best.triangle), 0).lower
    costs = [state.problem.total_norm(q, state.windows) ** 2 for q in (state.q, lower.q)]
    assert costs[0] - costs[1] == pytest.approx(lower.gain, rel=1e-6)
    assert 1.0 < lower.gain <= 6.3
    assert examine_draws(state.problem, best.q, state.windows, covariance(best.triangle), 0).lower is None


def test_a_fit_goes_on_from_a_lower_draw_and_converges(beside_the_optimum):
    of, state, best = beside_the_optimum

    def go_on(was, lower):
        return replace(was, q=solve(was.problem, lower.q, was.windows).q)

    fit = conclude(of, state, 0, 0.0, go_on)
    assert fit.outcome is FitOutcome.CONVERGED
    expected = state.problem.coordinates.values(best.q)
    for name in GEAR:
        assert fit.parameters[name].value == pytest.approx(expected[name], rel=1e-5)


def test_where_the_search_does_not_go_on_the_fit_has_not_converged(beside_the_optimum):
    """A fall of the cost by hundreds once stood beside "converged"."""
    of, state, _ = beside_the_optimum
    fit = conclude(of, state, 0, 0.0)
    assert fit.outcome is FitOutcome.NOT_CONVERGED
    assert fit.reasons[0].cause is Cause.NEAR_OPTIMUM
    assert any("lower than the estimate" in line for line in fit.warnings)
