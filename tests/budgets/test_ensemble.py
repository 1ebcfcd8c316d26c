"""Draws of an ensemble and what is made of them, against closed forms, over many seeds."""

import numpy as np
import pytest
from scipy import stats

from mechid.budgets.ensemble import make_ensemble
from mechid.budgets.ensemble_level import ensemble_level
from mechid.budgets.indices import Index
from mechid.budgets.levels import constant_member, member_level
from mechid.budgets.main_effects import main_effects
from mechid.budgets.other_errors import OtherError
from mechid.budgets.pointing_error import PointingError
from mechid.errors import UsageError

APE = Index("APE")


def biases(*axes, spread=1.0, group=""):
    """Return a bias of mean 0 along each of the lines of sight that are named, of two."""
    return tuple(
        OtherError(name=f"b{k}", kind="bias", axes=np.arange(2) == axis, size_rad=0.0, spread_rad=spread, group=group)
        for k, axis in enumerate(axes)
    )


def over_the_ensemble(errors, confidence, axis, interpretation, seed):
    ensemble = make_ensemble((), np.zeros(0), errors, seed)

    def member(draw):
        whole = PointingError(np.zeros(2))
        for error, one in zip(errors, draw, strict=True):
            whole = error.add_to(whole, float(one))
        return constant_member(whole)

    effects = main_effects(
        lambda z: member_level(member(z @ ensemble.follows), APE, confidence, axis, interpretation, 1024),
        len(ensemble.variables),
    )
    return ensemble_level(member, ensemble.along(effects.direction), APE, confidence, axis, interpretation)


@pytest.mark.parametrize(
    ("errors", "axis", "quantile"),
    [
        pytest.param(biases(0), 0, lambda p: stats.norm.ppf(0.5 + 0.5 * p), marks=pytest.mark.slow),
        (biases(0, 0, 0, 0, spread=0.5), 0, lambda p: stats.norm.ppf(0.5 + 0.5 * p)),
        (biases(0, 1), None, lambda p: stats.chi(2).ppf(p)),
    ],
    ids=["one bias", "four biases", "cone of two"],
)
@pytest.mark.parametrize("interpretation", ["temporal", "mixed"])
@pytest.mark.parametrize("confidence", [pytest.param(0.9545, marks=pytest.mark.slow), 0.9973])
def test_the_standard_error_is_that_of_the_seeds(errors, axis, quantile, interpretation, confidence):
    """Truth: the normal and the Rayleigh quantile, in units of the spread, at 10 seeds.

    Of a bias of mean 0 the level is its size, the same all the time; of two across one another the worst members lie
    on a circle, which no direction of the draws meets alone.
    """
    found = [over_the_ensemble(errors, confidence, axis, interpretation, seed) for seed in range(10)]
    expected = quantile(0.5 * (1.0 + confidence) if interpretation == "temporal" else confidence)
    off, stated = np.array([s.value for s in found]) - expected, np.array([s.sigma for s in found])
    assert np.sqrt(np.mean((off / stated) ** 2)) < 1.5
    assert np.sqrt(np.mean(off**2)) < 0.03
    assert stated.mean() < 3.0 * np.sqrt(np.mean(off**2))


def test_members_further_out_count_for_less():
    """Truth: mean 0, variance 1 and no correlation of what is drawn, in any direction; and the normal tail."""
    ensemble = make_ensemble(("p", "q"), np.ones(2), biases(0), seed=3)
    members = ensemble.along(np.array([0.6, 0.0, -0.8]))
    weights = members.weights.ravel() / len(members.weights)
    draws = members.draws.reshape(weights.size, -1)
    np.testing.assert_allclose(weights @ draws, 0.0, atol=0.01)
    np.testing.assert_allclose(draws.T @ (weights[:, None] * draws), np.eye(3), atol=0.03)
    along = draws @ [0.6, 0.0, -0.8]
    assert weights @ (along > 3.0) == pytest.approx(stats.norm.sf(3.0), rel=0.05)
    assert np.mean(along > 3.0) == pytest.approx(stats.norm.sf(1.5), rel=0.05)


def test_what_varies_on_its_own():
    """Truth: the spreads. Errors of a group follow one variable, two of one name do not, what has none is left out."""
    pair, alone = biases(0, 1, group="g"), biases(0)[0]
    ensemble = make_ensemble(("p", "q"), np.array([0.1, 0.0]), (*pair, alone, alone), seed=0)
    assert ensemble.variables == ("p", "errors of g", "error b0", "error b0 (3)")
    np.testing.assert_array_equal(
        ensemble.follows,
        [[1, 0, 0, 0, 0, 0], [0, 0, 1, 1, 0, 0], [0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1]],
    )


def test_main_effects():
    """Truth: moments of 3 + 2 a + b^2 for normal a, b: mean 4, variance 4 + 2."""
    effects = main_effects(lambda z: 3.0 + 2.0 * z[0] + z[1] ** 2, 2)
    assert (effects.mean, effects.sigma) == pytest.approx((4.0, np.sqrt(6.0)))
    assert dict(effects.shares(("a", "b"))) == pytest.approx({"a": 4.0 / 6.0, "b": 0.0, "curvature": 2.0 / 6.0})
    assert effects.direction @ [1.0, 0.0] > 0.7
    still = main_effects(lambda z: 3.0, 2)
    assert (still.mean, still.sigma, still.shares(("a", "b"))) == (3.0, 0.0, {"a": 0.0, "b": 0.0})
    np.testing.assert_array_equal(still.direction, [1.0, 0.0])
    alone = main_effects(lambda z: 3.0, 0)
    assert (alone.mean, alone.sigma, alone.shares(())) == (3.0, 0.0, {})


def test_an_unknown_interpretation_is_refused():
    with pytest.raises(UsageError, match='did you mean "mixed"'):
        member_level(constant_member(PointingError(np.zeros(1))), APE, 0.9, 0, "mixd")
