"""Truth: the certified parameters, standard deviations and residual sums of NIST's StRD, to 11 digits.

The solver is mechid's own on triangles reduced as its own; the problems have no bounds. `python
tests/identification/test_nist_strd.py` prints the table of docs/validation.md.
"""

import inspect
import sys
from functools import cache

import numpy as np
import pytest

from measured_data import data_folder
from mechid.identification.search.solve import covariance, descend, solve
from nist_strd import NAMES, digits, read

pytestmark = pytest.mark.data
STEPS = 3000
OWN_TOLERANCE, TIGHT_TOLERANCE = inspect.signature(solve).parameters["tolerance"].default, 1e-15
"""Relative fall of the cost that ends a search: as an identification uses it, and down to rounding."""
PROMISED = 6.0
ROUNDED = {"Lanczos1": 2.5}
"""Residuals of 1e-13 beside data of order one: in double precision their size, and with it every standard
deviation, is known to some three digits."""


@cache
def problem(name):
    return read(data_folder() / "nist_strd" / "NIST_STRD" / f"{name}.dat")


def solved(name, start, tolerance):
    """Return the solution and the standard errors, s^2 (J^T J)^-1 with s^2 over the degrees of freedom."""
    p = problem(name)
    unbounded = np.full(p.certified.size, np.inf)
    solution = descend(p.norm, p.triangle, p.starts[start], (-unbounded, unbounded), steps=STEPS, tolerance=tolerance)
    scale = solution.triangle.cost / p.freedom
    return solution, np.sqrt(scale * np.diag(covariance(solution.triangle)))


@pytest.mark.parametrize("start", [0, 1], ids=["far", "near"])
@pytest.mark.parametrize("name", NAMES)
def test_six_certified_digits(name, start, figure):
    solution, errors = solved(name, start, TIGHT_TOLERANCE)
    assert solution.converged
    where = f"NIST {name}, {('far', 'near')[start]} start: digits of the"
    figure(f"{where} parameters", digits(solution.q, problem(name).certified), least=PROMISED)
    figure(
        f"{where} standard errors", digits(errors, problem(name).certified_errors), least=ROUNDED.get(name, PROMISED)
    )
    assert digits(solution.triangle.cost, problem(name).certified_sum) >= ROUNDED.get(name, PROMISED)


@pytest.mark.parametrize("start", [0, 1], ids=["far", "near"])
@pytest.mark.parametrize("name", [name for name in NAMES if name not in ROUNDED])
def test_the_tolerance_of_an_identification_stops_well_within_a_standard_error(name, start):
    """Truth: the certified values, as far as their certified standard deviations say that it matters."""
    solution, _ = solved(name, start, OWN_TOLERANCE)
    off = np.abs(solution.q - problem(name).certified) / problem(name).certified_errors
    assert np.max(off) < 2e-4


def table():
    """Write the table of docs/validation.md: digits of parameters, of their errors, evaluations; far / near start."""
    sys.stdout.write("| problem | own tolerance | evaluations | to rounding | evaluations |\n|---|---|---|---|---|\n")
    for name in NAMES:
        cells = [cell for tolerance in (OWN_TOLERANCE, TIGHT_TOLERANCE) for cell in _cells(name, tolerance)]
        sys.stdout.write(f"| {name} | {' | '.join(cells)} |\n")


def _cells(name, tolerance):
    p = problem(name)
    both = [solved(name, start, tolerance) for start in (0, 1)]
    pairs = (f"{digits(s.q, p.certified):.1f}, {digits(e, p.certified_errors):.1f}" for s, e in both)
    return " / ".join(pairs), " / ".join(str(s.evaluations) for s, _ in both)


if __name__ == "__main__":
    table()
