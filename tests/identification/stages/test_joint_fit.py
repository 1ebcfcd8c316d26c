"""A fit that has stopped in a singular corner begins again from beside it."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.identification.identify import make_problem
from mechid.identification.search.solve import solve
from mechid.identification.stages.joint_fit import is_on_file_bound, leave_corner
from mechid.parameter import Status
from synthetic import COMMANDS, TRUTH, campaign, measured, record

MADE = {"static": 4.5e-3, "coulomb": 2.5e-3, "viscous": 1e-3, "stribeck_rate": 3.0}
LIMITS = {"static": (1e-4, 0.1), "coulomb": (1e-4, 0.1), "viscous": (1e-5, 0.1), "stribeck_rate": (0.05, 50.0)}


@pytest.fixture(scope="module")
def records():
    """Return three records of a mechanism with Stribeck friction."""
    made_by = stribeck().with_values({**TRUTH, **{f"friction.{key}": value for key, value in MADE.items()}})
    return [
        record(n, measured(made_by, COMMANDS[n], np.random.default_rng((7, k)), seconds=0.3), COMMANDS[n])
        for k, n in enumerate(("full_46", "full_23", "micro_46"))
    ]


def stribeck():
    table = {**CATALOGUE, "friction": {**CATALOGUE["friction"], "law": "stribeck", "stribeck_rate": 2.0}}
    return mechanism_from_table(table, "stribeck")


def problem_of(mechanism, records, start):
    """Return the problem in which friction alone is free, and begins at `start`."""
    known = mechanism.with_values(TRUTH).with_free(())
    free = {
        f"friction.{key}": replace(
            known.parameters[f"friction.{key}"], status=Status.FREE, value=value, min=LIMITS[key][0], max=LIMITS[key][1]
        )
        for key, value in start.items()
    }
    return make_problem(campaign(known.with_parameters(free), *records), 1)


def fitted(problem, q):
    return solve(problem, q, problem.whole_windows())


@pytest.fixture(scope="module")
def plain(records):
    """Return the problem without Stribeck friction, and what it comes to."""
    problem = problem_of(mechanism_from_table(CATALOGUE, "plain"), records, dict.fromkeys(list(MADE)[:3], 3e-3))
    return problem, fitted(problem, problem.start)


@pytest.mark.slow
@pytest.mark.parametrize("rate", [0.06, 45.0])
def test_stribeck_friction_is_found_from_where_a_fit_without_it_ends(records, plain, rate):
    """Truth: the friction that made the records. Without it static friction ends at Coulomb friction."""
    corner = plain[0].coordinates.values(plain[1].q)
    assert corner["friction.static"] == pytest.approx(corner["friction.coulomb"], rel=1e-6)
    wide = problem_of(stribeck(), records, {**dict.fromkeys(list(MADE)[:3], 3e-3), "stribeck_rate": 1.5})
    stopped = fitted(wide, wide.coordinates.point({**corner, "friction.stribeck_rate": rate}))
    found = leave_corner(wide, stopped, lambda q: fitted(wide, q))
    assert found is not stopped, "a rate that is far off leaves the fit in the corner"
    values = wide.coordinates.values(found.q)
    assert [values[f"friction.{key}"] for key in MADE] == pytest.approx(list(MADE.values()), rel=0.02)


def test_static_at_coulomb_friction_is_no_corner_where_nothing_is_hidden_by_it(plain):
    def never(q):
        raise AssertionError("nothing is fitted again")

    assert leave_corner(*plain, never) is plain[1]


def test_a_corner_of_two_parameters_is_held_by_no_bound_of_the_file(records):
    """Truth: static friction at Coulomb friction, by hand; Coulomb friction at its own least."""
    problem = problem_of(stribeck(), records, {**MADE, "static": 2.5e-3, "coulomb": 2.5e-3})
    assert problem.coordinates.on_bound(problem.start).any()
    assert not is_on_file_bound(problem, problem.start)
    at_least = problem_of(stribeck(), records, {**MADE, "coulomb": LIMITS["coulomb"][0]})
    assert is_on_file_bound(at_least, at_least.start)
