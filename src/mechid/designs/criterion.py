"""Criterion of a design: the logarithm of a standard error, to be minimised.

D is the geometric mean of the standard errors along the axes of the confidence ellipsoid, A their root mean square over
the parameters, E the largest in any direction; alternatively, the standard error of one parameter (Pukelsheim, Optimal
Design of Experiments, 2006, chapters 6 and 9; Atkinson, Donev, Tobias 2007). Coordinates are divided by their size, so
that a difference of 0.1 is about 10 % of a standard error.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.designs.settings import DESIGN
from mechid.errors import UsageError, did_you_mean
from mechid.identification.output_error.space import SearchSpace

KINDS = ("D", "A", "E")
OVER = ("mean", "low")


@dataclass(frozen=True, eq=False)
class Criterion:
    """Optimality criterion of a design.

    Parameters
    ----------
    kind : str
        ``"D"``, ``"A"``, ``"E"``, or the name of a parameter.
    size : (n,)
        Size of each coordinate.
    directions : (points, n) or None
        Derivative of the one parameter at each point, over its size.
    over : {"mean", "low"}
        Aggregation over the mechanisms: the mean, or a quantile of unfavourable ones.
    """

    kind: str
    size: FloatArray
    directions: FloatArray | None = None
    over: str = "mean"

    def values_at(self, information: FloatArray) -> FloatArray:
        """Return the logarithm of the standard error, (points, ...), of informations (points, ..., n, n)."""
        scaled = information * np.outer(self.size, self.size)
        if self.kind == "D":
            # The determinant itself may overflow or underflow; its logarithm does not.
            _, logdet = np.linalg.slogdet(scaled)
            return np.asarray(-0.5 * logdet / self.size.size, dtype=np.float64)
        if self.kind == "E":
            # Without information the eigenvalue is zero or, by rounding, below: the logarithm stays finite.
            return np.asarray(-0.5 * np.log(np.maximum(np.linalg.eigvalsh(scaled)[..., 0], 1e-300)))
        if self.kind == "A":
            spread = np.trace(np.linalg.inv(scaled), axis1=-2, axis2=-1) / self.size.size
            return np.asarray(0.5 * np.log(np.maximum(spread, 1e-300)))
        assert self.directions is not None
        g = self.directions * self.size
        # One derivative per mechanism, broadcast over all candidate sets of that mechanism.
        g = g.reshape(g.shape[0], *([1] * (scaled.ndim - 3)), g.shape[1], 1)
        along = np.linalg.solve(scaled, np.broadcast_to(g, (*scaled.shape[:-1], 1)))
        variance = np.sum(along * g, axis=(-2, -1))
        return np.asarray(0.5 * np.log(np.maximum(variance, 1e-300)))

    def of(self, information: FloatArray) -> FloatArray:
        """Return the criterion, (...), of informations (points, ..., n, n)."""
        each = self.values_at(information)
        if self.over == "mean":
            return np.asarray(each.mean(axis=0))
        return np.asarray(np.quantile(each, DESIGN.low_quantile, axis=0))

    def guided_value(self, information: FloatArray) -> FloatArray:
        """Return the criterion plus a small share of D, (...), to guide the search where the criterion is flat.

        For example, the largest error in any direction does not fall until the last direction is determined.
        """
        found = self.of(information)
        return found if self.kind == "D" else found + DESIGN.guide * replace(self, kind="D").of(information)


def criterion_at(space: SearchSpace, points: FloatArray, kind: str, over: str) -> Criterion:
    """Return the criterion of a kind over mechanisms, (points, n) in search coordinates.

    Raises
    ------
    UsageError
        The kind is neither a letter nor an estimated parameter.
    """
    if kind in KINDS:
        return Criterion(kind, sizes(space, points), None, over)
    names, _ = space.value_jacobian(points[0])
    if kind not in names:
        near = did_you_mean(kind, names) or f"; write D, A, E or one of {', '.join(names)}"
        raise UsageError(f'criterion: "{kind}" is no parameter to be estimated{near}')
    directions = np.array([_direction(space, q, names.index(kind)) for q in points])
    return Criterion(kind, sizes(space, points), directions, over)


def _direction(space: SearchSpace, q: FloatArray, row: int) -> FloatArray:
    """Return the derivative of a parameter relative to its value; of an angle in degrees the absolute derivative."""
    names, slopes = space.value_jacobian(q)
    value = abs(space.values(q)[names[row]])
    # An error relative to an angle would depend on the choice of its zero.
    is_angle = space.mechanism.parameters[names[row]].is_periodic
    return np.asarray(slopes[row] / (1.0 if is_angle or value == 0.0 else value), dtype=np.float64)


def sizes(space: SearchSpace, points: FloatArray) -> FloatArray:
    """Return the size of each search coordinate, (n,): 1 for a logarithm, so that errors are relative.

    For other coordinates it is the root mean square over the points. Both parts of a detent have the size of its
    amplitude; an angle has one radian.
    """
    out = np.ones(space.size)
    root = np.sqrt(np.mean(points**2, axis=0))
    for j, c in enumerate(space.coordinates):
        if c.kind == "cosine":
            # Depending on the detent's phase, either part alone may be near 0.
            out[j] = out[j + 1] = np.hypot(root[j], root[j + 1])
        elif space.is_turning(c):
            out[j] = np.degrees(1.0)
        elif c.kind in ("linear", "excess"):
            out[j] = root[j]
    # A coordinate that is 0 at all points has no size; 1 keeps the scaled information regular.
    return np.where(out > 0.0, out, 1.0)
