"""Dependences between parameters: detection, description, and the parameter to hold.

A high correlation alone does no harm: R, L and k_m of the paper's mechanism correlate at 0.99 and are known to a
thousandth. A dependence counts only where the records cannot separate directions at all, or where a standard error
exceeds its prior's sigma or the user's limit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechid.arrays import BoolArray, FloatArray
from mechid.campaign.identify_options import IdentifyOptions
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.reduction import Triangle
from mechid.identification.search.settings import SEARCH
from mechid.identification.search.solve import covariance
from mechid.identification.uncertainty.settings import VERDICTS
from mechid.parameter import Parameter


@dataclass(frozen=True)
class Dependence:
    """Parameters that the records cannot separate, or one that they hardly determine.

    Attributes
    ----------
    ruined : str
        The parameter whose estimate suffers most.
    involved : tuple of str
        All parameters that take part, the ruined one among them.
    held : str
        The parameter of least influence, which would be frozen.
    why, words : str
        The measure that exceeds its limit; a description of the direction.
    """

    ruined: str
    involved: tuple[str, ...]
    held: str
    why: str
    words: str

    @property
    def sentence(self) -> str:
        """Describe the dependence to a user, with its remedies."""
        if len(self.involved) == 1:
            return f"{self.why}; add a record that excites it more, or give it a sigma from another source"
        others = " or ".join(self.involved)
        return f"{self.why}: {self.words}; give {others} a sigma, or add a record that moves them independently"


@dataclass(frozen=True)
class EstimatedParameters:
    """Estimated parameters with their values and covariance, in the file's coordinates.

    `influence` is the change of all samples, in sigmas, over a parameter's prior sigma or range, the others held.
    """

    parameters: tuple[Parameter, ...]
    values: FloatArray
    covariance: FloatArray
    influence: FloatArray

    @property
    def sigma(self) -> FloatArray:
        """Standard errors, (n,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> FloatArray:
        """Correlation matrix, (n, n)."""
        scale = np.where(self.sigma > 0.0, self.sigma, 1.0)
        return np.asarray(self.covariance / np.outer(scale, scale), dtype=np.float64)


def worst_dependence(
    problem: Problem, q: FloatArray, triangle: Triangle, counted: BoolArray, options: IdentifyOptions
) -> Dependence | None:
    """Return the dependence that harms the estimate most, or None.

    Parameters
    ----------
    problem : Problem
    q : (n,)
    triangle : Triangle
        Records and active priors: a prior may resolve a direction that the records do not.
    counted : (n,) of bool
        Coordinates that are estimated: neither on a bound nor unseen.
    options : IdentifyOptions
    """
    known = _estimated_parameters(problem, q, triangle, counted)
    if not known.parameters:
        return None
    return (
        _find_singular(problem, q, triangle, counted, known)
        or _find_uncertain(known, options)
        or _find_correlated(known, options)
    )


def _estimated_parameters(
    problem: Problem, q: FloatArray, triangle: Triangle, counted: BoolArray
) -> EstimatedParameters:
    """Map the estimate to the file's coordinates; a singular direction has a huge variance.

    The covariance is the white one. The robust one also grows by the residual that a previously held parameter leaves,
    so holding one parameter would lead to holding the next.
    """
    here = q[: problem.space.size]
    names, slopes = problem.space.value_jacobian(here)
    part = counted[: problem.space.size]
    # A parameter that also moves with uncounted coordinates has no covariance from the counted ones alone.
    kept = [i for i, name in enumerate(names) if np.any(slopes[i, part] != 0.0) and not np.any(slopes[i, ~part] != 0.0)]
    maps = slopes[kept][:, part]
    moving = np.flatnonzero(part)
    estimated = covariance(Triangle(triangle.norm, triangle.jacobian[:, counted], triangle.samples))
    own = estimated[: moving.size, : moving.size]
    parameters = tuple(problem.space.mechanism.parameters[names[i]] for i in kept)
    values = np.array([problem.space.values(here)[p.name] for p in parameters])
    ranges = np.array([p.sigma or (p.max - p.min) / math.sqrt(12.0) for p in parameters])
    alone = np.linalg.norm(triangle.jacobian[:, moving] @ np.linalg.pinv(maps), axis=0)
    return EstimatedParameters(parameters, values, maps @ own @ maps.T, ranges * alone)


def _find_singular(
    problem: Problem, q: FloatArray, triangle: Triangle, counted: BoolArray, known: EstimatedParameters
) -> Dependence | None:
    """Find a direction in which the records change by rounding errors only."""
    # Columns of unit length: the ratio of singular values then does not depend on the units of the coordinates.
    J = triangle.jacobian[:, counted]
    size = np.linalg.norm(J, axis=0)
    if not size.size or np.any(size == 0.0):
        return None
    _, s, Vt = np.linalg.svd(J / size, full_matrices=False)
    if s[-1] > SEARCH.singular * s[0]:
        return None
    step = np.zeros(problem.size)
    step[counted] = Vt[-1] / size
    _, slopes = problem.space.value_jacobian(q[: problem.space.size])
    names = [p.name for p in problem.space.mechanism.free]
    direction = slopes @ step[: problem.space.size]
    rows = [names.index(p.name) for p in known.parameters]
    moved = _relative_changes(known, direction[rows])
    involved = np.flatnonzero(np.abs(moved) > VERDICTS.involved_share * np.abs(moved).max())
    why = f"the smallest singular value is {s[-1] / s[0]:.1g} of the largest"
    return _build_dependence(known, int(np.argmax(np.abs(moved))), involved, moved, why)


def _find_uncertain(known: EstimatedParameters, options: IdentifyOptions) -> Dependence | None:
    """Find the estimate whose error most exceeds its prior's sigma or the user's relative limit."""
    ratios, whys = np.zeros(len(known.parameters)), [""] * len(known.parameters)
    for i, (p, value, sigma) in enumerate(zip(known.parameters, known.values, known.sigma, strict=True)):
        limits = {}
        if p.sigma and options.priors != "fit":
            limits[p.sigma] = f"its prior's {p.sigma:.3g}"
        if options.max_relative_error and not p.is_periodic and value != 0.0:
            limits[options.max_relative_error * abs(value)] = f"{options.max_relative_error:g} of its value"
        if limits:
            ratios[i] = sigma / min(limits)
            whys[i] = f"{p.name}: its standard error {sigma:.3g} exceeds {limits[min(limits)]}"
    worst = int(np.argmax(ratios))
    if ratios[worst] <= 1.0:
        return None
    return _dependence_of_partners(known, worst, whys[worst])


def _find_correlated(known: EstimatedParameters, options: IdentifyOptions) -> Dependence | None:
    """Find the largest correlation above the user's limit."""
    if options.max_correlation is None or len(known.parameters) < 2:
        return None
    off = np.abs(known.correlation - np.eye(len(known.parameters)))
    i, j = np.unravel_index(int(np.argmax(off)), off.shape)
    if off[i, j] <= options.max_correlation:
        return None
    why = f"correlation {known.correlation[i, j]:+.4f} beyond the limit {options.max_correlation:g}"
    pair = np.array([i, j])
    return _build_dependence(known, int(i), pair, _relative_changes(known, known.covariance[i]), why)


def _dependence_of_partners(known: EstimatedParameters, worst: int, why: str) -> Dependence:
    partners = np.flatnonzero(np.abs(known.correlation[worst]) > VERDICTS.partner_correlation)
    return _build_dependence(known, worst, partners, _relative_changes(known, known.covariance[worst]), why)


def _build_dependence(
    known: EstimatedParameters, ruined: int, involved: NDArray[np.intp], moved: FloatArray, why: str
) -> Dependence:
    names = [p.name for p in known.parameters]
    # The parameter of least influence: holding it at its value changes the records least.
    held = min(involved.tolist() or [ruined], key=lambda i: known.influence[i])
    return Dependence(
        ruined=names[ruined],
        involved=tuple(names[i] for i in involved) or (names[ruined],),
        held=names[held],
        why=why,
        words=describe_direction([names[i] for i in involved], moved[involved]),
    )


def _relative_changes(known: EstimatedParameters, change: FloatArray) -> FloatArray:
    """Scale changes by the parameter values; by the ranges for angles and for values at zero."""
    scale = np.array(
        [
            abs(v) if v != 0.0 and not p.is_periodic else p.max - p.min
            for p, v in zip(known.parameters, known.values, strict=True)
        ]
    )
    return np.asarray(change / np.where(np.isfinite(scale) & (scale > 0.0), scale, 1.0), dtype=np.float64)


def describe_direction(names: Sequence[str], moved: FloatArray) -> str:
    """Describe which parameters move together, and the combination that the records still determine.

    Parameters
    ----------
    names : sequence of str, (n,)
    moved : (n,)
        Relative changes along the direction.

    Examples
    --------
    >>> describe_direction(["stepper.coil_resistance", "stepper.coil_inductance"], np.array([1.0, 1.02]))
    'stepper.coil_resistance and stepper.coil_inductance rise together: only their ratio is seen'
    """
    if len(names) < 2:
        return f"{names[0]} alone moves" if names else ""
    if len(names) == 2:
        (a, b), (x, y) = names, moved
        equal = abs(abs(x) - abs(y)) < VERDICTS.equal_difference * max(abs(x), abs(y))
        if x * y > 0.0:
            seen = "their ratio" if equal else "a combination of them"
            return f"{a} and {b} rise together: only {seen} is seen"
        seen = "their product" if equal else "a combination of them"
        return f"{a} rises as {b} falls: only {seen} is seen"
    lead = float(moved[np.argmax(np.abs(moved))])
    up = [n for n, x in zip(names, moved, strict=True) if x * lead > 0.0]
    down = [n for n, x in zip(names, moved, strict=True) if x * lead < 0.0]
    text = " and ".join(up) + (" rise together" if len(up) > 1 else " rises")
    return text + (f" as {' and '.join(down)} fall" if down else "") + ": only combinations of them are seen"
