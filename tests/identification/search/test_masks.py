"""Masks of single windows of misfit. Truth: the mechanism of the records, and the samples that a knock was added to."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.identification.identify import make_problem
from mechid.identification.search.gates import grow_horizons
from mechid.identification.search.horizons import gate_window, unfollowed_records
from mechid.identification.search.masks import (
    apply_masks,
    grow_past_misfit,
    is_rare,
    lift_followed_masks,
    mask_near,
    masked_runs,
)
from mechid.identification.search.settings import SEARCH
from synthetic import RATE_HZ, bench, displaced, truth, with_leading
from synthetic_knock import knock

FREE = {"gear.stiffness": 1.01, "gear.damping": 0.9}
FULL, MICRO = "full_46", "micro_46"


def knocked(*knocks, seconds=0.5):
    """Return the problem of two records with knocks: record, when and how long in s."""
    problem = make_problem(bench(displaced(truth(), FREE), truth(), FULL, MICRO, seed=6, seconds=seconds), 1)
    targets = {t.name: t for t in problem.targets}
    for name, at_s, lasts_s in knocks:
        torque = knock(np.array(targets[name].leading.measured), at_s, lasts_s)
        targets[name] = with_leading(targets[name], measured=torque)
    return replace(problem, targets=tuple(targets.values()))


def grown(problem):
    """Return the growth of a problem that stalls at a knock."""
    return grow_horizons(problem, problem.start, rng(), escapes=0, leaps=2)


def rng():
    return np.random.default_rng(3)


def at_truth(problem):
    return problem.coordinates.point({name: truth().value(name) for name in FREE})


@pytest.mark.parametrize("lasts_s", [0.001, 0.005, 0.01])
def test_a_knock_is_masked_and_the_rest_followed(lasts_s):
    """Truth: the samples of the knock, of which one window to either side is left out at most, and the mechanism."""
    problem = knocked((FULL, 0.25, lasts_s))
    stalled = grown(problem)
    assert not stalled.complete
    masked, growth = grow_past_misfit(problem, stalled, rng())
    assert growth.complete
    ((first, stop),) = masked_runs(masked)[FULL]
    window = gate_window(problem.targets[0])
    assert 2500 - 2 * window <= first <= 2500
    assert 2500 + lasts_s * RATE_HZ <= stop <= 2500 + lasts_s * RATE_HZ + 2 * window
    assert masked_runs(masked).keys() == {FULL}
    values = masked.coordinates.values(growth.q)
    assert values["gear.stiffness"] == pytest.approx(truth().value("gear.stiffness"), rel=2e-4)


@pytest.mark.parametrize(
    "knocks",
    [
        [(FULL, 0.25, 0.1)],
        [(FULL, at_s, 0.005) for at_s in (0.1, 0.2, 0.3, 0.4)],
        [(FULL, 0.25, 0.005), (FULL, 0.35, 0.005)],
        [(FULL, 0.25, 0.005), (MICRO, 0.25, 0.005)],
        [(FULL, 0.48, 0.005)],
    ],
    ids=["it lasts", "it comes again and again", "more than a hundredth", "in every record", "nothing behind it"],
)
def test_what_is_no_single_moment_is_not_masked(knocks):
    """Truth: the knocks, which last longer, repeat, are in all records, or at the end, and no mask may hide."""
    problem = knocked(*knocks)
    assert grow_past_misfit(problem, grown(problem), rng()) is None


def test_a_longer_record_may_have_several_moments():
    """Truth: two knocks in 4 s, 50 ms of masks at most, within a hundredth; and three times as many, which are not."""
    problem = knocked((FULL, 1.0, 0.003), (FULL, 3.0, 0.003), seconds=4.0)
    found = apply_masks(problem, {FULL: [(9950, 10100), (29950, 30100)]})
    assert is_rare(found)
    assert not unfollowed_records(found, at_truth(found))
    assert not is_rare(apply_masks(problem, {FULL: [(k, k + 50) for k in range(1000, 31000, 5000)]}))


def test_a_moment_that_is_followed_counts_again():
    """Truth: masks where a knock is and where none is, at the mechanism that made the records."""
    problem = knocked((FULL, 0.25, 0.005))
    masked = apply_masks(problem, {FULL: [(1000, 1150), (2450, 2600)], MICRO: [(2000, 2100)]})
    found = lift_followed_masks(masked, at_truth(problem))
    assert masked_runs(found) == {FULL: ((2450, 2600),)}
    np.testing.assert_array_equal(found.targets[0].leading.rejected, np.arange(2450, 2600))
    assert lift_followed_masks(found, at_truth(problem)) is found


def test_masks_leave_gaps_as_they_are():
    """Truth: samples that were never measured do not count, also where the mask about them is lifted."""
    problem = knocked()
    gap = np.arange(1020, 1030)
    target = with_leading(problem.targets[0], bridged=gap, rejected=gap)
    problem = replace(problem, targets=(target, *problem.targets[1:]))
    masked = apply_masks(problem, {FULL: [(1000, 1150)]})
    assert masked_runs(masked) == {FULL: ((1000, 1150),)}
    found = lift_followed_masks(masked, at_truth(problem))
    np.testing.assert_array_equal(found.targets[0].leading.rejected, gap)
    assert apply_masks(problem, {}) is problem


def test_trusted_values_mask_what_they_do_not_follow():
    """Truth: the knock; and records without one, at which nothing changes."""
    plain, problem = knocked(), knocked((FULL, 0.25, 0.005))
    q = at_truth(plain)
    assert mask_near(plain, q, rng()) == (plain, q)
    masked, moved = mask_near(problem, q, rng())
    assert masked_runs(masked) == {FULL: ((2450, 2600),)}
    assert not unfollowed_records(masked, moved, most=SEARCH.gate_limit)
