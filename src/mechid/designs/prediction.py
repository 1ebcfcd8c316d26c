"""Predicted standard error of every parameter for records not yet taken."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.designs.planned_record import PlannedRecord
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.reduction import Triangle, combine_triangles, triangle_of_rows
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.search.solve import covariance
from mechid.identification.uncertainty.verdict import seen_coordinates

UNSEEN = "no record sees it"
ON_BOUND = "on the bound of the mechanism file"
NO_PHASE = "zero torque, no phase"


@dataclass(frozen=True, eq=False)
class PredictedErrors:
    """Standard errors that records would give, in the file's coordinates and units.

    Attributes
    ----------
    names : tuple of str, (k,)
        Every free parameter.
    values : (k,)
        Values at which they are predicted.
    covariance : (k, k)
        Zero for parameters without a standard error.
    reasons : mapping of str to str
        Why a parameter has no standard error.
    """

    names: tuple[str, ...]
    values: FloatArray
    covariance: FloatArray
    reasons: Mapping[str, str]

    def std_error(self, name: str) -> float | None:
        """Return the standard error of a parameter, None if it has none."""
        if name in self.reasons:
            return None
        k = self.names.index(name)
        return math.sqrt(self.covariance[k, k])

    @property
    def correlation(self) -> FloatArray:
        """Correlation matrix, (k, k); zero for parameters without a standard error."""
        scale = np.sqrt(np.diag(self.covariance))
        # Parameters without a standard error have zero rows; 1 avoids 0 / 0.
        scale[scale == 0.0] = 1.0
        return np.asarray(self.covariance / np.outer(scale, scale))


def planned_problem(
    space: SearchSpace,
    records: Sequence[PlannedRecord],
    *,
    priors: Mapping[str, tuple[float, float]] | None = None,
    workers: int = 1,
) -> Problem:
    """Return the identification problem of planned records; their measured values are zero."""
    return Problem(space, tuple(r.target() for r in records), priors or {}, workers=workers)


def predicted_errors(problem: Problem, q: FloatArray, before: FloatArray | None = None) -> PredictedErrors:
    """Return the standard errors, for white noise, that the records of a problem give at a point.

    Parameters
    ----------
    problem : Problem
    q : (n,)
        Mechanism's coordinates and free time offsets.
    before : (m, m) or None
        Existing information on the mechanism's m coordinates.

    Raises
    ------
    ArithmeticError
        A record cannot be simulated at that point.
    """
    parts = [*problem.triangles(q, problem.whole_windows()), *problem.prior_triangles(q)]
    if before is not None:
        # A square root of the information acts as further rows of the Jacobian; rounding may leave eigenvalues below
        # zero.
        values, vectors = np.linalg.eigh(before)
        rows = np.zeros((before.shape[0], problem.size))
        rows[:, : before.shape[0]] = (vectors * np.sqrt(np.maximum(values, 0.0))).T
        parts.append(triangle_of_rows(np.zeros(before.shape[0]), rows))
    triangle = combine_triangles(parts or [triangle_of_rows(np.zeros(1), np.zeros((1, problem.size)))])
    if not np.all(np.isfinite(triangle.jacobian)):
        raise ArithmeticError("a record cannot be simulated at the values of the mechanism file")
    on, seen = problem.coordinates.on_bound(q), seen_coordinates(problem, triangle)
    # A parameter on its bound does not move with noise, and one that is not seen has no finite error.
    counted = seen & ~on
    inverse = np.zeros((problem.size, problem.size))
    J = triangle.jacobian[:, counted]
    inverse[np.ix_(counted, counted)] = covariance(Triangle(triangle.norm, J, triangle.samples))
    names, slopes = problem.coordinates.value_slopes(q)
    found = _values(problem, q, names)
    return PredictedErrors(names, found, slopes @ inverse @ slopes.T, _reasons(problem, found, names, seen, on))


def _values(problem: Problem, q: FloatArray, names: Sequence[str]) -> FloatArray:
    at = problem.coordinates
    own = dict(zip(at.record_parameter_names, at.of_records(q).tolist(), strict=True))
    found = problem.space.values(at.of_mechanism(q)) | own
    return np.array([found[name] for name in names])


def _reasons(
    problem: Problem, values: FloatArray, names: Sequence[str], seen: BoolArray, on: BoolArray
) -> dict[str, str]:
    """Return why parameters have no standard error."""
    reasons: dict[str, str] = {}
    for name, is_seen, is_on in zip(problem.coordinates.names, seen, on, strict=True):
        if not is_seen or is_on:
            reasons[name] = ON_BOUND if is_on else UNSEEN
    for c in problem.space.coordinates:
        if c.partner and c.name in reasons:
            reasons[c.partner] = reasons[c.name]
        # At zero amplitude the phase has no effect on the torque.
        elif c.partner and abs(values[names.index(c.name)]) < 1e-9 * c.upper:
            reasons[c.partner] = NO_PHASE
    return reasons
