"""Dependences that ruin an estimate: where they are, what moves together, and which parameter to hold.

A high correlation alone is no harm: R, L and k_m of the paper's mechanism correlate at 0.99 and are known to a
thousandth. A dependence is acted on where the records cannot tell directions apart at all, or where a standard
error exceeds what the user knows or asks for.
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
    """Parameters that the records do not tell apart, or one that they hardly tell.

    Attributes
    ----------
    ruined : str
        The parameter whose estimate it ruins.
    involved : tuple of str
        All that have part in it, the ruined one among them.
    held : str
        The one of least influence, which would be frozen.
    why, words : str
        The measure that says so; what moves how.
    """

    ruined: str
    involved: tuple[str, ...]
    held: str
    why: str
    words: str

    @property
    def sentence(self) -> str:
        """Return it as a user reads it, with what would resolve it."""
        if len(self.involved) == 1:
            return f"{self.why}; a record that moves it more, or a sigma from elsewhere, would determine it"
        others = " or ".join(self.involved)
        return f"{self.why}: {self.words}; a sigma on {others}, or a record that moves them apart, would separate them"


@dataclass(frozen=True)
class Seen:
    """What is known of the parameters that are estimated.

    `influence` is what a parameter changes of all samples, in sigmas, over what is believed of it, others held.
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
    """Return the dependence that ruins an estimate most, or None.

    Parameters
    ----------
    problem : Problem
    q : (n,)
    triangle : Triangle
        Of the records and of the priors that count: a prior resolves what the records do not.
    counted : (n,) of bool
        Coordinates that are estimated: neither on a bound nor unseen.
    options : IdentifyOptions
    """
    seen = _seen(problem, q, triangle, counted)
    if not seen.parameters:
        return None
    return _singular(problem, q, triangle, counted, seen) or _uncertain(seen, options) or _correlated(seen, options)


def _seen(problem: Problem, q: FloatArray, triangle: Triangle, counted: BoolArray) -> Seen:
    """Express what is known in the file's coordinates; a singular direction has a huge variance.

    The covariance is the white one: that robust to colour also grows by what a parameter held before leaves in the
    residual, and would then take the next one with it.
    """
    here = q[: problem.space.size]
    names, slopes = problem.space.value_jacobian(here)
    part = counted[: problem.space.size]
    kept = [i for i, name in enumerate(names) if np.any(slopes[i, part] != 0.0) and not np.any(slopes[i, ~part] != 0.0)]
    maps = slopes[kept][:, part]
    moving = np.flatnonzero(part)
    estimated = covariance(Triangle(triangle.norm, triangle.jacobian[:, counted], triangle.samples))
    own = estimated[: moving.size, : moving.size]
    parameters = tuple(problem.space.mechanism.parameters[names[i]] for i in kept)
    values = np.array([problem.space.values(here)[p.name] for p in parameters])
    ranges = np.array([p.sigma or (p.max - p.min) / math.sqrt(12.0) for p in parameters])
    alone = np.linalg.norm(triangle.jacobian[:, moving] @ np.linalg.pinv(maps), axis=0)
    return Seen(parameters, values, maps @ own @ maps.T, ranges * alone)


def _singular(problem: Problem, q: FloatArray, triangle: Triangle, counted: BoolArray, seen: Seen) -> Dependence | None:
    """Find a direction of which the records see nothing but rounding."""
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
    rows = [names.index(p.name) for p in seen.parameters]
    moved = _relative(seen, direction[rows])
    involved = np.flatnonzero(np.abs(moved) > VERDICTS.involved * np.abs(moved).max())
    why = f"the smallest singular value is {s[-1] / s[0]:.1g} of the largest"
    return _dependence(seen, int(np.argmax(np.abs(moved))), involved, moved, why)


def _uncertain(seen: Seen, options: IdentifyOptions) -> Dependence | None:
    """Find the estimate that most exceeds its prior's sigma or the user's relative error."""
    ratios, whys = np.zeros(len(seen.parameters)), [""] * len(seen.parameters)
    for i, (p, value, sigma) in enumerate(zip(seen.parameters, seen.values, seen.sigma, strict=True)):
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
    return _around(seen, worst, whys[worst])


def _correlated(seen: Seen, options: IdentifyOptions) -> Dependence | None:
    """Find the largest correlation beyond the user's limit."""
    if options.max_correlation is None or len(seen.parameters) < 2:
        return None
    off = np.abs(seen.correlation - np.eye(len(seen.parameters)))
    i, j = np.unravel_index(int(np.argmax(off)), off.shape)
    if off[i, j] <= options.max_correlation:
        return None
    why = f"correlation {seen.correlation[i, j]:+.4f} beyond the limit {options.max_correlation:g}"
    pair = np.array([i, j])
    return _dependence(seen, int(i), pair, _relative(seen, seen.covariance[i]), why)


def _around(seen: Seen, worst: int, why: str) -> Dependence:
    partners = np.flatnonzero(np.abs(seen.correlation[worst]) > VERDICTS.partner)
    return _dependence(seen, worst, partners, _relative(seen, seen.covariance[worst]), why)


def _dependence(seen: Seen, ruined: int, involved: NDArray[np.intp], moved: FloatArray, why: str) -> Dependence:
    names = [p.name for p in seen.parameters]
    held = min(involved.tolist() or [ruined], key=lambda i: seen.influence[i])
    return Dependence(
        ruined=names[ruined],
        involved=tuple(names[i] for i in involved) or (names[ruined],),
        held=names[held],
        why=why,
        words=describe_direction([names[i] for i in involved], moved[involved]),
    )


def _relative(seen: Seen, change: FloatArray) -> FloatArray:
    """Return changes relative to the values; those of angles, and of values at zero, to their ranges."""
    scale = np.array(
        [
            abs(v) if v != 0.0 and not p.is_periodic else p.max - p.min
            for p, v in zip(seen.parameters, seen.values, strict=True)
        ]
    )
    return np.asarray(change / np.where(np.isfinite(scale) & (scale > 0.0), scale, 1.0), dtype=np.float64)


def describe_direction(names: Sequence[str], moved: FloatArray) -> str:
    """Say which parameters move together, and what of them is left to see.

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
        equal = abs(abs(x) - abs(y)) < VERDICTS.equal * max(abs(x), abs(y))
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
