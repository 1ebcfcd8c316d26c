"""Leaps over windows of misfit, and retreats before them. Truth: the mechanism of the records, and spoilt samples."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.identification.identify import make_problem
from mechid.identification.search.horizons import followed_samples, least_horizons
from mechid.identification.search.leaps import exclude_samples, leap, retreat
from mechid.identification.search.settings import SEARCH
from mechid.identification.search.solve import solve
from synthetic import bench, displaced, truth, with_leading

STIFFNESS = "gear.stiffness"
BEGINS, ENDS = 1500, 1560
MOST = SEARCH.gate_limit


def spoilt(factor, samples):
    """Return the problem of two records, with further torque in the first, from a stiffness a factor off; and gates."""
    campaign = bench(displaced(truth(), {STIFFNESS: factor}), truth(), "full_23", "micro_46", seed=6, seconds=0.3)
    problem = make_problem(campaign, 1)
    target, *others = problem.targets
    torque = np.array(target.leading.measured)
    torque[BEGINS : BEGINS + len(samples)] += samples
    problem = replace(problem, targets=(with_leading(target, measured=torque), *others))
    least = least_horizons(problem)
    gates = {t.name: max(followed_samples(problem, t, problem.start), least[t.name]) for t in problem.targets}
    return problem, gates, least


def off(problem, q):
    """Return how far off the stiffness is, relative."""
    return abs(problem.coordinates.values(q)[STIFFNESS] / truth().value(STIFFNESS) - 1.0)


def test_a_leap_passes_over_a_spoilt_window():
    """Truth: all behind the window is of the mechanism; the window, counted, pulls the stiffness away."""
    problem, gates, least = spoilt(1.02, np.full(ENDS - BEGINS, 0.2))
    assert gates["full_23"] < BEGINS
    assert gates["micro_46"] < 3001
    q, found = leap(problem, problem.start, gates, least, MOST)
    assert found == {"full_23": BEGINS, "micro_46": 3001}
    counted = solve(problem, problem.start, problem.whole_windows(), steps=20).q
    assert off(problem, q) < 5e-4 < off(problem, counted)


@pytest.mark.parametrize("move", [leap, retreat])
def test_nothing_is_gained_where_the_rest_is_not_followed(move):
    """Truth: behind its window the record holds another torque altogether, and all before is followed already."""
    other = 0.2 * np.sign(np.sin(np.arange(3001 - BEGINS) / 20.0))
    problem, gates, least = spoilt(1.0, other)
    assert gates == {"full_23": BEGINS, "micro_46": 3001}
    assert move(problem, problem.start, gates, least, MOST) is None


def test_a_retreat_leaves_out_what_is_just_before_the_horizon():
    """Truth: the mechanism that made the records, which follows both further than a stiffness 2 % off."""
    problem, gates, least = spoilt(1.02, np.full(ENDS - BEGINS, 0.2))
    q, found = retreat(problem, problem.start, gates, least, MOST)
    assert found == {"full_23": BEGINS, "micro_46": 3001}
    assert off(problem, q) < 1e-3


def test_samples_left_out_do_not_count():
    """Truth: the cost of the record without its spoilt samples."""
    problem, _, _ = spoilt(1.0, np.full(ENDS - BEGINS, 0.2))
    target, window = problem.targets[0], {"full_23": (0, 3001)}
    masked = exclude_samples(target, np.arange(BEGINS, ENDS))
    assert exclude_samples(target, np.zeros(0, dtype=np.int64)) is target
    assert problem.norm(target, problem.start, window["full_23"]) ** 2 > 1e4
    cost = problem.norm(masked, problem.start, window["full_23"]) ** 2
    assert cost == pytest.approx(3001 - (ENDS - BEGINS), rel=0.1)
