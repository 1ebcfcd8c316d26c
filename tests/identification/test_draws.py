"""Whether the likelihood around an estimate is what its derivatives say, and which switches graze."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.identification.draws import departures
from mechid.identification.grazing import grazing_switches
from mechid.identification.problem import Problem
from mechid.identification.solve import covariance
from mechid.identification.space import SearchSpace
from mechid.identification.target import target_of
from synthetic import COMMANDS, NOISE_NM, displaced, measured, record, truth

GEAR = ("gear.stiffness", "gear.damping")


def at_truth(names, *records, seconds, widened=1.0):
    """Return the problem at the truth, its point, windows and covariance, the last widened."""
    rng = np.random.default_rng(81)
    targets = [target_of(record(n, measured(truth(), COMMANDS[n], rng, seconds=seconds), COMMANDS[n])) for n in records]
    space = SearchSpace(displaced(truth(), dict.fromkeys(names, 1.0)))
    problem = Problem(space, tuple(replace(t, sigma=NOISE_NM) for t in targets), substeps=2)
    q, windows = problem.start, problem.whole()
    return problem, q, windows, widened * covariance(problem.joint(q, windows))


def test_a_smooth_cost_departs_nowhere():
    """Truth: over 0.1 s of full steps the torque is all but linear in the gear within its errors."""
    assert departures(*at_truth(GEAR, "full_46", "micro_46", seconds=0.1), 0) == []


def switches(problem, target, q):
    run = problem.run(target, q, target.samples, jacobian=True, events=500)
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
    assert (found.record, found.count, found.of) == ("full_46", 1, log.time.size)
    assert found.instant_s == pytest.approx(log.time[worst], abs=1e-12)
    assert found.spread_s / found.gap_s == pytest.approx(0.101, rel=1e-6)
    assert f"record full_46 at {log.time[worst]:.6g} s: a stick/slip grazes" in str(found)


def _share(problem, q, covariance):
    return float(_shares(switches(problem, problem.targets[0], q), covariance).max())


def _shares(log, covariance):
    sigma = [float(np.sqrt(s @ covariance @ s)) for s in log.sensitivity]
    gap = [np.abs(np.delete(log.time, i) - t).min() for i, t in enumerate(log.time)]
    return np.array(sigma) / np.array(gap)


def test_a_stick_that_comes_and_goes_is_found_in_its_record_and_instant():
    """Truth: where the sticks of the draws differ from those of the estimate, by the logs of their switches.

    The covariance of friction is widened until some draws stick once more, or once less, than the estimate.
    """
    names = ("friction.static", "friction.coulomb")
    problem, q, windows, wide = at_truth(names, "full_46", "micro_92", seconds=0.3, widened=25.0)
    found = departures(problem, q, windows, wide, 0)
    assert [d.record for d in found] == ["full_46"]
    here = switches(problem, problem.targets[0], q)
    root = np.linalg.cholesky(wide)
    steps = np.random.default_rng(5).standard_normal((40, 2)) @ root.T
    logs = [switches(problem, problem.targets[0], np.clip(q + s, problem.lower, problem.upper)) for s in steps]
    other = [log for log in logs if log.time.size != here.time.size]
    assert other
    first = []
    for log in other:
        n = min(log.time.size, here.time.size)
        differs = np.flatnonzero((np.abs(log.time[:n] - here.time[:n]) > 1e-3) | (log.after[:n] != here.after[:n]))
        first.append(min(log.time[differs[0]], here.time[differs[0]]) if differs.size else here.time[n - 1])
    assert np.min(np.abs(np.array(first) - found[0].instant_s)) < 2e-3
