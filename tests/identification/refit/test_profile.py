"""Profile likelihood: the parabola where the problem is linear, bounds, cliffs, and going on from a journal."""

import json
import math
from functools import partial

import numpy as np
import pytest
from scipy.stats import chi2

from finished import optimum
from mechid.errors import UsageError
from mechid.identification.computation.journal import Journal
from mechid.identification.refit import profile as module
from mechid.identification.refit.profile import SideEnd, profiles

HOUSING = ("housing.gain", "housing.frequency", "housing.damping")
LIMIT = math.sqrt(chi2.ppf(0.95, 1))


@pytest.fixture(scope="module")
def gain():
    """The torque is linear in the housing's gain: z = K_res times a filter of T_res."""
    return optimum("housing.gain")


@pytest.fixture(scope="module")
def housing():
    return optimum(*HOUSING)


def test_the_profile_of_a_linear_problem_is_the_parabola(gain):
    """Truth: rise = ((value - estimate) / sigma)^2, and the interval estimate +- 1.96 sigma."""
    found = profiles(gain, ["housing.gain"])[0]
    sigma = gain.parameters["housing.gain"].std_error_white
    parabola = [((p.value - found.value) / sigma) ** 2 for p in found.points]
    np.testing.assert_allclose([p.rise for p in found.points], parabola, atol=2e-3)
    np.testing.assert_allclose(found.interval, (found.value - LIMIT * sigma, found.value + LIMIT * sigma), rtol=1e-5)
    assert found.ends == (SideEnd.CROSSED, SideEnd.CROSSED)
    assert not found.cliffs


def test_all_others_are_refitted(housing):
    """Truth: the standard error with the others free; held at the optimum they would make it narrower."""
    sigmas = [housing.parameters[name].std_error_white for name in HOUSING]
    for found, sigma in zip(profiles(housing, HOUSING, workers=2), sigmas, strict=True):
        half = 0.5 * (found.interval[1] - found.interval[0])
        assert half == pytest.approx(LIMIT * sigma, rel=0.02), found.name


def test_a_bound_that_comes_first_is_told():
    """Truth: the bound of the file, less than a sigma above the truth's gain of 4.6."""
    near = optimum("housing.gain", gain={"max": 4.602})
    found = profiles(near, ["housing.gain"])[0]
    assert found.interval[1] is None
    assert found.ends == (SideEnd.CROSSED, SideEnd.BOUND)
    assert found.points[-1].value == 4.602


def test_a_jump_of_the_cost_is_named_with_its_value(gain, monkeypatch):
    """Truth: a parabola with a step of 9 at a value known beforehand."""
    sigma = gain.parameters["housing.gain"].std_error_white
    centre = gain.values(gain.q)["housing.gain"]
    cliff = centre + 0.7 * sigma

    def stepped(found, task):
        _, value, starts = task
        rise = ((value - centre) / sigma) ** 2 + (9.0 if value > cliff else 0.0)
        return {"cost": found.triangle.cost + rise, "q": starts[0], "note": ""}

    monkeypatch.setattr(module, "_refit", stepped)
    found = profiles(gain, ["housing.gain"])[0]
    assert len(found.cliffs) == 1
    assert found.cliffs[0].below <= cliff <= found.cliffs[0].above
    assert found.cliffs[0].above - found.cliffs[0].below < 2e-3 * sigma
    assert found.cliffs[0].jump == pytest.approx(9.0, abs=0.01)
    assert found.ends == (SideEnd.CROSSED, SideEnd.CLIFF)
    assert found.interval[1] == found.cliffs[0].below


def test_a_better_point_than_the_estimate_is_told(gain, monkeypatch):
    """Truth: a parabola whose bottom is one sigma above the estimate, lower by one sigma squared."""
    sigma = gain.parameters["housing.gain"].std_error_white
    centre = gain.values(gain.q)["housing.gain"] + sigma

    def moved(found, task):
        _, value, starts = task
        return {"cost": found.triangle.cost + ((value - centre) / sigma) ** 2 - 1.0, "q": starts[0], "note": ""}

    monkeypatch.setattr(module, "_refit", moved)
    assert profiles(gain, ["housing.gain"])[0].gain == pytest.approx(1.0, abs=0.1)


def test_coloured_residuals_raise_the_level(gain):
    """Truth: the quantile times the ratio of variances; on a parabola the wider interval is wider by its root."""
    own = gain.parameters["housing.gain"]
    own = module.replace(own, std_error=1.5 * own.std_error_white)
    coloured = module.replace(gain, parameters={**gain.parameters, "housing.gain": own})
    found = profiles(coloured, ["housing.gain"])[0]
    assert found.level_coloured == pytest.approx(2.25 * chi2.ppf(0.95, 1))
    widths = [b - a for a, b in (found.interval, found.interval_coloured)]
    assert widths[1] / widths[0] == pytest.approx(1.5, rel=1e-3)


def test_a_resumed_profile_is_the_same(housing, tmp_path):
    """Truth: the undisturbed one, to the bit, from the first half of its journal."""
    path = tmp_path / "profile.jsonl"
    run = partial(profiles, housing, HOUSING[:1])
    whole = run(journal=Journal.open(path, {}))
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[: len(lines) // 2]))
    again = run(journal=Journal.open(path, {}, resume=True))
    assert repr(again) == repr(whole)
    steps = [json.loads(line)["event"] for line in path.read_text().splitlines()].count("step")
    assert steps == len(lines) - 1, "nothing is worked out twice"


def test_what_the_fit_did_not_move_is_refused(gain):
    with pytest.raises(UsageError, match=r"--parameter gear\.stiffness: is known; the fit estimated housing\.gain"):
        profiles(gain, ["gear.stiffness"])
