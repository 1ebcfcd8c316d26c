"""Search coordinates of a mechanism, and their maps to kernel values and file values.

A positive parameter is searched by its logarithm. A detent with free amplitude and phase is searched by its cosine and
sine parts, so that the phase keeps a derivative at zero amplitude. A parameter that never lies below another, as static
friction above Coulomb friction, is searched by its excess over that one. All others are searched directly.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.output_error.settings import PROBLEM
from mechid.parameter import Parameter
from mechid.plant.mechanism import Mechanism


@dataclass(frozen=True)
class Coordinate:
    """Coordinate of the optimiser: name, kind and bounds in its own scale.

    Kinds: ``log`` (of the parameter), ``linear``, ``cosine`` and ``sine`` (of an amplitude-phase pair with the phase
    `partner`), ``excess`` (over the parameter `below`).
    """

    name: str
    kind: str
    lower: float
    upper: float
    partner: str = ""
    below: str = ""


@dataclass(frozen=True)
class SearchSpace:
    """Coordinates of a mechanism's free parameters, and the maps from them.

    Parameters
    ----------
    mechanism : Mechanism
        Holds the values of all fixed parameters.
    polar : frozenset of str
        Amplitudes that are searched directly, with their phases, because their limit is active.
    """

    mechanism: Mechanism
    polar: frozenset[str] = frozenset()

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """All coordinates, (n,), in the order of the file."""
        pairs = self._cartesian_pairs
        phases = set(pairs.values())
        result: list[Coordinate] = []
        for q in self.mechanism.free:
            if q.name in pairs:
                result += [Coordinate(q.name, kind, -q.max, q.max, pairs[q.name]) for kind in ("cosine", "sine")]
            elif q.name not in phases:
                result.append(self._plain_coordinate(q))
        return tuple(result)

    @cached_property
    def _cartesian_pairs(self) -> dict[str, str]:
        """Phase by amplitude, for the pairs that are free in the whole disc."""
        parameters = self.mechanism.parameters
        return {
            pair.amplitude: pair.phase
            for pair in self.mechanism.plant.polar_pairs
            if pair.amplitude not in self.polar
            and (a := parameters[pair.amplitude]).is_free
            and a.min == 0.0
            and math.isfinite(a.max)
            and (f := parameters[pair.phase]).is_free
            and f.is_periodic
        }

    @cached_property
    def _below(self) -> dict[str, str]:
        """Lower bound parameter of each parameter that has one."""
        return self.mechanism.plant.related_parameters("above")

    @cached_property
    def _above(self) -> dict[str, str]:
        """Inverse of `_below`: the parameter that never lies below each one."""
        return {lower: upper for upper, lower in self._below.items()}

    def _plain_coordinate(self, q: Parameter) -> Coordinate:
        if q.name in self._below:
            lower = self.mechanism.parameters[self._below[q.name]]
            least = lower.min if lower.is_free else lower.value
            most = lower.max if lower.is_free else lower.value
            return Coordinate(q.name, "excess", max(0.0, q.min - most), max(q.max - least, 1e-12), below=lower.name)
        # Capped by the largest value of the upper parameter, because the excess above it cannot be negative.
        if q.name in self._above:
            upper = self.mechanism.parameters[self._above[q.name]]
            above = math.inf if upper.tied_to else upper.max if upper.is_free else upper.value
            most = min(q.max, above)
            return Coordinate(q.name, "linear", q.min, max(most, q.min + 1e-12))
        if q.is_periodic:
            return Coordinate(q.name, "linear", -720.0, 720.0)
        if q.min > 0.0:
            return Coordinate(q.name, "log", math.log(q.min), math.log(q.max))
        return Coordinate(q.name, "linear", q.min, q.max)

    def is_turning(self, c: Coordinate) -> bool:
        """Tell whether a coordinate is a free angle, which has no bounds."""
        return c.kind == "linear" and self.mechanism.parameters[c.name].is_periodic

    def stands_alone(self, c: Coordinate) -> bool:
        """Tell whether a coordinate changes exactly one parameter."""
        return c.kind in ("linear", "log") and c.name not in self._below and c.name not in self._above

    def outside_disc(self, q: FloatArray) -> frozenset[str]:
        """Return the amplitudes beyond their limit at `q`."""
        values = self.values(q[: self.size])
        found = (c.name for c in self.coordinates if c.kind == "cosine" and values[c.name] > c.upper)
        return frozenset(found)

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.coordinates)

    @cached_property
    def lower(self) -> FloatArray:
        """Lower bounds, (n,)."""
        return np.array([c.lower for c in self.coordinates])

    @cached_property
    def upper(self) -> FloatArray:
        """Upper bounds, (n,)."""
        return np.array([c.upper for c in self.coordinates])

    def clip(self, q: FloatArray) -> FloatArray:
        """Return the nearest point within the bounds."""
        return np.clip(q, self.lower, self.upper)

    def from_values(self, values: Mapping[str, float]) -> FloatArray:
        """Return the coordinates, (n,), of the file's values of all free parameters."""
        return self.clip(np.array([self._coordinate_of(c, values) for c in self.coordinates]))

    @cached_property
    def start(self) -> FloatArray:
        """Coordinates of the mechanism's own values."""
        return self.from_values({q.name: q.value for q in self.mechanism.parameters.values()})

    @staticmethod
    def _coordinate_of(c: Coordinate, values: Mapping[str, float]) -> float:
        value = values[c.name]
        if c.kind == "log":
            return math.log(max(value, 1e-300))
        if c.kind == "excess":
            return value - values[c.below]
        if c.kind == "cosine":
            return value * math.cos(math.radians(values[c.partner]))
        if c.kind == "sine":
            return value * math.sin(math.radians(values[c.partner]))
        return value

    @cached_property
    def _value_entries(self) -> list[tuple[str, str, str, float, float]]:
        """Name, kind, partner and bounds of each coordinate."""
        # Prepared once, because a search converts thousands of points.
        known = self.mechanism.parameters
        return [(c.name, c.kind, c.partner, known[c.name].min, known[c.name].max) for c in self.coordinates]

    def values(self, q: FloatArray) -> dict[str, float]:
        """Return the file's values, {name: value}, of the free parameters at `q`."""
        out: dict[str, float] = {}
        for (name, kind, partner, least, most), x in zip(self._value_entries, q.tolist(), strict=True):
            if kind == "log":
                out[name] = min(max(math.exp(x), least), most)
            elif kind == "cosine":
                out[name], out[partner] = x, 0.0
            elif kind == "sine":
                a = out[name]
                out[name], out[partner] = math.hypot(a, x), math.degrees(math.atan2(x, a))
            else:
                out[name] = x
        for upper, lower in self._below.items():
            if upper in out:
                out[upper] = self._within_bounds(upper, out[upper] + out.get(lower, self.mechanism.value(lower)))
        return out

    def _excess_slopes(self, q: FloatArray) -> dict[str, float]:
        """Return 1 for each free parameter searched by its excess that can move with it, 0 if it is at a bound."""
        values, known = self.values(q), self.mechanism.parameters
        return {n: float(known[n].min < values[n] < known[n].max) for n in self._below if known[n].is_free}

    def _within_bounds(self, name: str, value: float) -> float:
        """Clip a value that the conversion from coordinates may have moved past its bounds."""
        q = self.mechanism.parameters[name]
        return min(max(value, q.min), q.max)

    def at(self, q: FloatArray) -> Mechanism:
        """Return the mechanism with its free parameters at `q`."""
        return self.mechanism.with_values(self.values(q))

    def kernel(self, q: FloatArray, own: Mapping[str, float] | None = None) -> FloatArray:
        """Return the kernel's parameters, (NP,), at `q`; `own` replaces values of the mechanism."""
        return self.mechanism.kernel_values({**self.values(q), **(own or {})})

    def kernel_jacobian(
        self, q: FloatArray, own: Mapping[str, float] | None = None, moved: Sequence[str] = ()
    ) -> FloatArray:
        """Return dp/dq, (NP, n), at `q` with `own` values, followed by a column dp/d(value) for each of `moved`."""
        mechanism = self.at(q).with_values(own or {})
        by_file = mechanism.kernel_jacobian()
        order = {s: i for i, s in enumerate(mechanism.plant.parameters)}
        pairs = {p.amplitude: p for p in mechanism.plant.polar_pairs}
        out, carried = np.zeros((len(order), self.size + len(moved))), self._excess_slopes(q)
        for j, name in enumerate(moved, self.size):
            out[:, j] = by_file[name]
        for j, (c, x) in enumerate(zip(self.coordinates, q, strict=True)):
            if own and c.name in own:
                continue
            if c.kind in ("cosine", "sine"):
                pair = pairs[c.name]
                out[order[pair.cosine if c.kind == "cosine" else pair.sine], j] = 1.0
            elif c.kind == "excess":
                out[:, j] = by_file[c.name] * carried[c.name]
            else:
                out[:, j] = by_file[c.name] * (math.exp(x) if c.kind == "log" else 1.0)
                if carried.get(self._above.get(c.name, "")):
                    out[:, j] += by_file[self._above[c.name]]
        return out

    def value_jacobian(self, q: FloatArray) -> tuple[tuple[str, ...], FloatArray]:
        """Return the names of the free parameters, (m,), and d(value)/dq, (m, n), in the file's units."""
        values = self.values(q)
        names = tuple(p.name for p in self.mechanism.free)
        out, carried = np.zeros((len(names), self.size)), self._excess_slopes(q)
        for j, c in enumerate(self.coordinates):
            i = names.index(c.name)
            if c.kind in ("cosine", "sine"):
                # Columns of an amplitude-phase pair are the derivatives of (hypot, atan2); at amplitude 0 that of the
                # phase is infinite, so the amplitude is bounded from below there.
                amplitude, phase = values[c.name], math.radians(values[c.partner])
                toward, across = math.cos(phase), -math.sin(phase)
                if c.kind == "sine":
                    toward, across = math.sin(phase), math.cos(phase)
                out[i, j] = toward
                out[names.index(c.partner), j] = math.degrees(across / max(amplitude, PROBLEM.least_amplitude_nm))
            elif c.kind == "excess":
                out[i, j] = carried[c.name]
            else:
                out[i, j] = values[c.name] if c.kind == "log" else 1.0
                if self._above.get(c.name) in names:
                    out[names.index(self._above[c.name]), j] = carried[self._above[c.name]]
        return names, out
