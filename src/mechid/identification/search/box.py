"""Box of start points for the search, and Sobol points that fill it evenly.

A parameter lies within its declared spread around the catalogue value, or is a typical share of a scale that other
parameters define.

The points equal those of SciPy's ``scipy.stats.qmc.Sobol``, bit for bit. Importing `scipy.stats` takes 0.4 s, which
every identification would pay for its 2048 points. The direction numbers are those of [JoeKuo2008]_; the scramble is a
random linear one with a digital shift [Matousek1998]_.

References
----------
.. [JoeKuo2008] S. Joe, F. Y. Kuo, Constructing Sobol sequences with better two-dimensional projections, SIAM J. Sci.
   Comput. 30 (2008) 2635-2654, doi:10.1137/070709359; numbers: https://web.maths.unsw.edu.au/~fkuo/sobol/.
.. [Matousek1998] J. Matousek, On the L2-discrepancy for anchored boxes, J. Complexity 14 (1998) 527-556,
   doi:10.1006/jcom.1998.0489.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from mechid.arrays import FloatArray
from mechid.identification.output_error.space import Coordinate, SearchSpace
from mechid.parameter import Declaration

Words = NDArray[np.uint32]
BITS = 30
"""Bits of a coordinate, as in SciPy's sequence."""


def sobol_points(dimensions: int, points: int, seed: int) -> FloatArray:
    """Return scrambled Sobol points of the unit cube, (points, dimensions).

    Parameters
    ----------
    dimensions : int
        SciPy generates the points if this exceeds the length of `DIRECTIONS`.
    points : int
        A power of 2.
    seed : int
    """
    rng = np.random.default_rng(seed)
    if dimensions > len(DIRECTIONS):
        from scipy.stats import qmc

        return np.asarray(qmc.Sobol(dimensions, scramble=True, rng=rng).random(points), dtype=np.float64)
    # SciPy scrambles with a spawned generator and draws the shift before the matrices. Any other order gives other
    # points.
    rng = rng.spawn(1)[0]
    shift = rng.integers(2, size=(dimensions, BITS), dtype=np.uint32) @ (1 << np.arange(BITS, dtype=np.uint32))
    mixing = np.tril(rng.integers(2, size=(dimensions, BITS, BITS), dtype=np.uint32))
    directions = _scramble_directions(_directions(dimensions), mixing)
    # Consecutive points of a Sobol sequence in Gray code order differ by one direction number, that of the lowest zero
    # bit.
    lowest_zero = [(~k & (k + 1)).bit_length() - 1 for k in range(points - 1)]
    steps = np.vstack([shift[np.newaxis], directions[:, lowest_zero].T])
    return np.bitwise_xor.accumulate(steps, axis=0) * 0.5**BITS


def _directions(dimensions: int) -> Words:
    """Return the direction numbers of each dimension, (dimensions, BITS), by the recurrence of its polynomial."""
    found = np.ones((dimensions, BITS), dtype=np.uint32)
    for v, (polynomial, first) in zip(found[1:], DIRECTIONS[1:], strict=False):
        degree = len(first)
        v[:degree] = first
        for j in range(degree, BITS):
            v[j] = v[j - degree]
            for k in range(1, degree + 1):
                if polynomial >> (degree - k) & 1:
                    v[j] ^= v[j - k] << k
    return np.asarray(found << np.arange(BITS - 1, -1, -1, dtype=np.uint32), dtype=np.uint32)


def _scramble_directions(directions: Words, mixing: Words) -> Words:
    """Scramble direction numbers by lower triangular bit matrices, (d, BITS, BITS), highest bit first."""
    places = np.arange(BITS - 1, -1, -1, dtype=np.uint32)
    mixing[:, np.arange(BITS), np.arange(BITS)] = 1
    bits = directions[:, np.newaxis, :] >> places[:, np.newaxis] & np.uint32(1)
    return np.asarray(np.sum((mixing @ bits % 2) << places[:, np.newaxis], axis=1, dtype=np.uint32))


DIRECTIONS: tuple[tuple[int, tuple[int, ...]], ...] = (
    (1, (1,)),
    (3, (1,)),
    (7, (1, 3)),
    (11, (1, 3, 1)),
    (13, (1, 1, 1)),
    (19, (1, 1, 3, 3)),
    (25, (1, 3, 5, 13)),
    (37, (1, 1, 5, 5, 17)),
    (41, (1, 1, 5, 5, 5)),
    (47, (1, 1, 7, 11, 19)),
    (55, (1, 1, 5, 1, 1)),
    (59, (1, 1, 1, 3, 11)),
    (61, (1, 3, 5, 5, 31)),
    (67, (1, 3, 3, 9, 7, 49)),
    (91, (1, 1, 1, 15, 21, 21)),
    (97, (1, 3, 1, 13, 27, 49)),
    (103, (1, 1, 1, 15, 7, 5)),
    (109, (1, 3, 1, 15, 13, 25)),
    (115, (1, 1, 5, 5, 19, 61)),
    (131, (1, 3, 7, 11, 23, 15, 103)),
    (137, (1, 3, 7, 13, 13, 15, 69)),
    (143, (1, 1, 3, 13, 7, 35, 63)),
    (145, (1, 3, 5, 9, 1, 25, 53)),
    (157, (1, 3, 1, 13, 9, 35, 107)),
    (167, (1, 3, 1, 5, 27, 61, 31)),
    (171, (1, 1, 5, 11, 19, 41, 61)),
    (185, (1, 3, 5, 3, 3, 13, 69)),
    (191, (1, 1, 7, 13, 1, 19, 1)),
    (193, (1, 3, 7, 5, 13, 19, 59)),
    (203, (1, 1, 3, 9, 25, 29, 41)),
    (211, (1, 3, 5, 13, 23, 1, 55)),
    (213, (1, 3, 7, 3, 13, 59, 17)),
    (229, (1, 3, 1, 3, 5, 53, 69)),
    (239, (1, 1, 5, 5, 23, 33, 13)),
    (241, (1, 1, 7, 7, 1, 61, 123)),
    (247, (1, 1, 7, 9, 13, 61, 49)),
    (253, (1, 3, 3, 5, 3, 55, 33)),
    (285, (1, 3, 1, 15, 31, 13, 49, 245)),
    (299, (1, 3, 5, 15, 31, 59, 63, 97)),
    (301, (1, 3, 1, 11, 11, 11, 77, 249)),
    (333, (1, 3, 1, 11, 27, 43, 71, 9)),
    (351, (1, 1, 7, 15, 21, 11, 81, 45)),
    (355, (1, 3, 7, 3, 25, 31, 65, 79)),
    (357, (1, 3, 1, 1, 19, 11, 3, 205)),
    (361, (1, 1, 5, 9, 19, 21, 29, 157)),
    (369, (1, 3, 7, 11, 1, 33, 89, 185)),
    (391, (1, 3, 3, 3, 15, 9, 79, 71)),
    (397, (1, 3, 7, 11, 15, 39, 119, 27)),
    (425, (1, 1, 3, 1, 11, 31, 97, 225)),
    (451, (1, 1, 1, 3, 23, 43, 57, 177)),
    (463, (1, 3, 7, 7, 17, 17, 37, 71)),
    (487, (1, 3, 1, 5, 27, 63, 123, 213)),
    (501, (1, 1, 3, 5, 11, 43, 53, 133)),
    (529, (1, 3, 5, 5, 29, 17, 47, 173, 479)),
    (539, (1, 3, 3, 11, 3, 1, 109, 9, 69)),
    (545, (1, 1, 1, 5, 17, 39, 23, 5, 343)),
    (557, (1, 3, 1, 5, 25, 15, 31, 103, 499)),
    (563, (1, 1, 1, 11, 11, 17, 63, 105, 183)),
    (601, (1, 1, 5, 11, 9, 29, 97, 231, 363)),
    (607, (1, 1, 5, 15, 19, 45, 41, 7, 383)),
    (617, (1, 3, 7, 7, 31, 19, 83, 137, 221)),
    (623, (1, 1, 1, 3, 23, 15, 111, 223, 83)),
    (631, (1, 1, 5, 13, 31, 15, 55, 25, 161)),
    (637, (1, 1, 3, 13, 25, 47, 39, 87, 257)),
)
"""Primitive polynomial over GF(2), as bits, and first direction numbers of each dimension."""


def sample_box(space: SearchSpace, points: int, seed: int) -> FloatArray:
    """Return start points, (points, n): the catalogue values first, then a scrambled Sobol sequence."""
    box = _Box(space)
    unit = sobol_points(space.size, points, seed)
    return np.array([space.start] + [box.point(u) for u in unit[1:].tolist()])


@dataclass(frozen=True)
class _Box:
    """Data shared by all points of a box."""

    space: SearchSpace

    @cached_property
    def declarations(self) -> list[Declaration]:
        """Declaration of each coordinate."""
        parameters = self.space.mechanism.parameters
        return [parameters[c.name].declaration for c in self.space.coordinates]

    @cached_property
    def spread_coordinates(self) -> list[tuple[int, Callable[[float], float]]]:
        """Coordinates within a spread, each with its map from the unit interval to a value."""
        each = enumerate(zip(self.space.coordinates, self.declarations, strict=True))
        return [(j, _map_to_spread(self.space, c, d.spread)) for j, (c, d) in each if not d.typical]

    @cached_property
    def scaled_coordinates(self) -> list[tuple[int, Coordinate, tuple[str, float, float]]]:
        """Coordinates that are shares of a scale."""
        each = enumerate(zip(self.space.coordinates, self.declarations, strict=True))
        return [(j, c, d.typical) for j, (c, d) in each if d.typical]

    @cached_property
    def scale_texts(self) -> tuple[str, ...]:
        """Expressions of the scales, in the file's symbols."""
        return tuple(sorted({typical[0] for _, _, typical in self.scaled_coordinates}))

    @cached_property
    def mechanism_values(self) -> dict[str, float]:
        """Values of the mechanism by dotted name."""
        return {name: self.space.mechanism.value(name) for name in self.space.mechanism.parameters}

    @cached_property
    def scale(self) -> Callable[[Mapping[str, float]], dict[str, float]]:
        """Function that returns the value of every scale from values by dotted name."""
        parameters = self.space.mechanism.parameters
        masters = [q.tied_to or name for name, q in parameters.items()]
        function = _scale_function(tuple(q.declaration.symbol for q in parameters.values()), self.scale_texts)
        return lambda values: dict(zip(self.scale_texts, function(*[values[name] for name in masters]), strict=True))

    def point(self, unit: Sequence[float]) -> FloatArray:
        """Map a point of the unit cube into the box."""
        q = self.space.start.copy()
        # Coordinates within a spread come first: the scales of the others are evaluated at them.
        for j, value in self.spread_coordinates:
            q[j] = value(unit[j])
        if self.scaled_coordinates:
            scales = self.scale({**self.mechanism_values, **self.space.values(q)})
            for j, c, typical in self.scaled_coordinates:
                q[j] = _typical_share(c, j, unit, typical, scales)
        return self.space.clip(q)


def _map_to_spread(space: SearchSpace, c: Coordinate, spread: float) -> Callable[[float], float]:
    """Return the map from the unit interval to a coordinate within its spread."""
    value = space.mechanism.parameters[c.name].value
    if c.kind == "log":
        middle, half = math.log(value), math.log(spread)
        return lambda u: min(max(middle + (2.0 * u - 1.0) * half, c.lower), c.upper)
    if math.isfinite(c.lower) and math.isfinite(c.upper):
        return lambda u: c.lower + u * (c.upper - c.lower)
    return lambda u: float(value * spread ** (2.0 * u - 1.0))


@lru_cache(maxsize=8)
def _scale_function(symbols: tuple[str, ...], texts: tuple[str, ...]) -> Callable[..., list[float]]:
    named = {name: sp.Symbol(name) for name in symbols}
    compiled: Callable[..., list[float]] = sp.lambdify(
        list(named.values()), [sp.sympify(text, locals=named) for text in texts], modules="math"
    )
    return compiled


def _typical_share(
    c: Coordinate, j: int, unit: Sequence[float], typical: tuple[str, float, float], scales: Mapping[str, float]
) -> float:
    text, least, most = typical
    scale, u = scales[text], unit[j]
    # A vector is drawn evenly over its disc, hence the square root. Its components share two coordinates of the unit
    # cube: radius and angle.
    if c.kind in ("cosine", "sine"):
        first = j if c.kind == "cosine" else j - 1
        radius, turn = most * scale * math.sqrt(unit[first]), 2.0 * math.pi * unit[first + 1]
        return radius * (math.cos(turn) if c.kind == "cosine" else math.sin(turn))
    value = scale * (least * (most / least) ** u if least > 0.0 else most * u)
    return math.log(value) if c.kind == "log" else value
