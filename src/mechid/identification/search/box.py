"""Box of start points for the search, and Sobol points that fill it evenly.

A parameter lies within its declared spread around the catalogue value, or is a typical share of a scale that other
parameters define.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import sympy as sp

from mechid.arrays import FloatArray
from mechid.identification.output_error.space import Coordinate, SearchSpace
from mechid.parameter import Declaration


def sobol_points(dimensions: int, points: int, seed: int) -> FloatArray:
    """Return scrambled Sobol points of the unit cube, (points, dimensions); `points` is a power of 2."""
    from scipy.stats import qmc  # loads for 0.25 s, which commands without a search do not pay

    return np.asarray(qmc.Sobol(dimensions, rng=np.random.default_rng(seed)).random(points), dtype=np.float64)


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
