"""All that the optimiser moves: the mechanism's search coordinates, then those that belong to one record alone.

This is the one place that knows which coordinate belongs to whom and how it acts on a record's run. A parameter of a
record's own is a value of the mechanism that holds for that record alone, whose derivative is a lane of the kernel; or
a state of its start, whose lane moves no parameter and begins at the derivatives of the states there; or it moves the
instants of its samples (`CLOCK`), whose derivative follows from the rate of the output. A new one of any kind is one
more entry: the names, bounds, values, priors and derivatives of all are worked out here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mechid.campaign.campaign import TIME_OFFSET, is_of_start, mechanism_name
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import Target
from mechid.parameter import Parameter
from mechid.simulation.simulator import Block
from mechid.simulation.start import Start

FloatArray = NDArray[np.float64]
Slope = Callable[[Block, int, int], FloatArray]
"""dy/d(value) of an output, by its number, over the last n samples of a block, (n,)."""
ON_BOUND = 1e-6
"""Share of its range within which a coordinate counts as on its bound."""


def _of_time_offset(block: Block, output: int, n: int) -> FloatArray:
    """Return minus the rate: a time offset shifts the whole run to later times."""
    return -block.rate[-n:, output]


CLOCK: Mapping[str, Slope] = {TIME_OFFSET.key: _of_time_offset}
"""Parameters of a record's own that move the instants of its samples, by key; every other one is the mechanism's."""


def is_of_clock(parameter: Parameter) -> bool:
    """Tell whether a record's own parameter moves its instants, and is none of the mechanism's values."""
    return mechanism_name(parameter.name) in CLOCK


@dataclass(frozen=True)
class RecordCoordinate:
    """A number that is moved for one record alone, in the file's unit.

    Attributes
    ----------
    record : str
        Name of its target.
    parameter : Parameter
        Its name, start and bounds.
    lane : int or None
        Of the kernel, that carries its derivative; None where it is the clock's.
    """

    record: str
    parameter: Parameter
    lane: int | None

    def slope(self, block: Block, output: int, n: int) -> FloatArray:
        """Return dy/d(value) of an output over the last n samples of a block of its record, (n,)."""
        if self.lane is None:
            return CLOCK[mechanism_name(self.parameter.name)](block, output, n)
        return block.jacobian[-n:, output, self.lane]


@dataclass(frozen=True, eq=False)
class Coordinates:
    """The coordinates of a mechanism and of its records, in this order, and the maps from and to them.

    Attributes
    ----------
    space : SearchSpace
        Of the mechanism's free parameters.
    own : tuple of RecordCoordinate
        Of single records: those of their clocks, then those of their values of the mechanism.
    priors : mapping of str to (float, float)
        Value and standard deviation by dotted name, in the file's units; those of what is not moved say nothing.
    """

    space: SearchSpace
    own: tuple[RecordCoordinate, ...] = ()
    priors: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return self.space.size + len(self.own)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Dotted name behind every coordinate; both parts of a detent have that of its amplitude."""
        return (*(c.name for c in self.space.coordinates), *(c.parameter.name for c in self.own))

    @cached_property
    def lower(self) -> FloatArray:
        """Lower bounds, (n,)."""
        return np.concatenate([self.space.lower, [c.parameter.min for c in self.own]])

    @cached_property
    def upper(self) -> FloatArray:
        """Upper bounds, (n,)."""
        return np.concatenate([self.space.upper, [c.parameter.max for c in self.own]])

    @property
    def span(self) -> FloatArray:
        """Width of each range, (n,)."""
        return self.upper - self.lower

    def clip(self, q: FloatArray) -> FloatArray:
        """Return the nearest points within the bounds, (..., n)."""
        return np.clip(q, self.lower, self.upper)

    @cached_property
    def start(self) -> FloatArray:
        """The values of the file, (n,)."""
        return np.concatenate([self.space.start, [c.parameter.value for c in self.own]])

    @property
    def own_names(self) -> tuple[str, ...]:
        """Dotted names of the coordinates that are single records'."""
        return tuple(self._places)

    @cached_property
    def _places(self) -> dict[str, int]:
        """Where each coordinate of a record stands, by dotted name."""
        return {c.parameter.name: j for j, c in enumerate(self.own, self.space.size)}

    def of_mechanism(self, q: FloatArray) -> FloatArray:
        """Return the part of a point that is the mechanism's."""
        return q[: self.space.size]

    def of_records(self, q: FloatArray) -> FloatArray:
        """Return the part of a point that is single records'."""
        return q[self.space.size :]

    def point(self, values: Mapping[str, float]) -> FloatArray:
        """Return the coordinates, (n,), of values by dotted name; what is not among them keeps that of the file."""
        mechanism = self.space.mechanism.parameters
        here = self.space.from_values({**{name: p.value for name, p in mechanism.items()}, **values})
        return np.concatenate([here, self.records_point(values)])

    def records_point(self, values: Mapping[str, float]) -> FloatArray:
        """Return the coordinates that belong to single records, by dotted name; others keep that of the file."""
        return np.array([values.get(c.parameter.name, c.parameter.value) for c in self.own])

    def values(self, q: FloatArray) -> dict[str, float]:
        """Return the file's values of all that is free, by dotted name, at `q`."""
        mechanism = self.space.at(self.of_mechanism(q))  # angles are wrapped there
        own = {p.name: mechanism.value(p.name) for p in mechanism.free}
        return own | dict(zip(self._places, self.of_records(q).tolist(), strict=True))

    def value(self, parameter: Parameter, q: FloatArray) -> float:
        """Return the value at `q` of what is a record's own: its coordinate's, or the one that is known."""
        place = self._places.get(parameter.name)
        return parameter.value if place is None else float(q[place])

    def value_slopes(self, q: FloatArray) -> tuple[tuple[str, ...], FloatArray]:
        """Return the names of all free parameters, (m,), and d(value)/dq, (m, n), in the file's units."""
        names, slopes = self.space.value_jacobian(self.of_mechanism(q))
        whole = np.zeros((len(names) + len(self.own), self.size))
        whole[: len(names), : self.space.size] = slopes
        whole[len(names) :, self.space.size :] = np.eye(len(self.own))
        return (*names, *self._places), whole

    def on_bound(self, q: FloatArray) -> NDArray[np.bool_]:
        """Return which coordinates stand on a bound of the file, (n,); that of a detent's disc is its radius."""
        gap = ON_BOUND * self.span
        on = (q - self.lower < gap) | (self.upper - q < gap)
        for j, c in enumerate(self.space.coordinates):
            if c.kind == "excess":
                static = self.space.mechanism.parameters[c.name]
                value, near = self.space.values(self.of_mechanism(q))[c.name], ON_BOUND * static.max
                on[j] |= value >= static.max - near or 0.0 < static.min >= value - near
            elif c.kind == "cosine":
                on[j] = on[j + 1] = math.hypot(q[j], q[j + 1]) > (1.0 - ON_BOUND) * c.upper
            elif self.space.is_turning(c):
                on[j] = False
        return np.asarray(on, dtype=np.bool_)

    def prior_rows(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return how far each prior is from its value, (k,) in sigmas, and its derivative, (k, n)."""
        if not self.priors:
            return np.zeros(0), np.zeros((0, self.size))
        names, slopes = self.value_slopes(q)
        values = self.space.values(self.of_mechanism(q)) | dict(zip(self._places, self.of_records(q), strict=True))
        rows = [(i, name, *self.priors[name]) for i, name in enumerate(names) if name in self.priors]
        away, J = np.zeros(len(rows)), np.zeros((len(rows), self.size))
        for k, (i, name, value, sigma) in enumerate(rows):
            off, known = values[name] - value, self.space.mechanism.parameters.get(name)
            if known is not None and known.is_periodic:
                off = (off + 180.0) % 360.0 - 180.0
            away[k], J[k] = off / sigma, slopes[i] / sigma
        return away, J

    @property
    def lanes(self) -> int:
        """Number of lanes that any run asks for: the mechanism's, and those of the record that has most of its own."""
        return max((c.lane + 1 for c in self.own if c.lane is not None), default=self.space.size)

    def time_offset(self, target: Target, q: FloatArray) -> float:
        """Return the time offset of a target at `q`, s."""
        return self.value(target.time_offset, q)

    def own_values(self, target: Target, q: FloatArray) -> dict[str, float]:
        """Return the values at `q` that hold for a target alone, by the mechanism's names."""
        return {mechanism_name(p.name): self.value(p, q) for p in target.own if not (is_of_clock(p) or is_of_start(p))}

    def start_values(self, target: Target, q: FloatArray) -> dict[str, float]:
        """Return the states of a target's start at `q`, by the keys of `Plant.starts`; none where it starts at rest."""
        return {mechanism_name(p.name): self.value(p, q) for p in target.own if is_of_start(p)}

    def start_of(self, target: Target, q: FloatArray, *, carried: bool) -> Start:
        """Return where the run of a target begins at `q`, with lanes of the states that are free where `carried`."""
        free = [c for c in self.of(target) if is_of_start(c.parameter)]
        lanes = {mechanism_name(c.parameter.name): c.lane for c in free if c.lane is not None}
        return Start(self.start_values(target, q), lanes if carried else {})

    def kernel(self, target: Target, q: FloatArray) -> FloatArray:
        """Return the kernel's parameters of a target at `q`, (NP,)."""
        return self.space.kernel(self.of_mechanism(q), self.own_values(target, q))

    def directions(self, target: Target, q: FloatArray) -> FloatArray:
        """Return what the lanes of a target move of the kernel's parameters, (NP, m), one lane at least.

        Of a clock that is free alone the rate is wanted, which comes with sensitivities only.
        """
        lanes = [c.parameter for c in self.of(target) if c.lane is not None]
        carried = [mechanism_name(p.name) for p in lanes if not is_of_start(p)]
        found = self.space.kernel_jacobian(self.of_mechanism(q), self.own_values(target, q), carried)
        found = np.hstack([found, np.zeros((found.shape[0], len(lanes) - len(carried)))])
        return found if found.size else np.zeros((found.shape[0], 1))

    def of(self, target: Target) -> list[RecordCoordinate]:
        """Return the coordinates that are a target's own."""
        return [c for c in self.own if c.record == target.name]

    def write_slopes(self, rows: FloatArray, target: Target, output: int, block: Block, n: int) -> None:
        """Write dy/dq of an output over the last n samples of a block as rows; what is another record's has none."""
        moved = self.space.size
        rows[:moved, :n] = block.jacobian[-n:, output, :moved].T
        for j, c in enumerate(self.own, moved):
            rows[j, :n] = c.slope(block, output, n) if c.record == target.name else 0.0

    def block_slopes(self, target: Target, output: int, block: Block, n: int) -> FloatArray:
        """Return dy/dq of an output over the last n samples of a block, (n, size)."""
        rows = np.zeros((self.size, n))
        self.write_slopes(rows, target, output, block, n)
        return rows.T


def coordinates_of(
    space: SearchSpace, targets: Sequence[Target], priors: Mapping[str, tuple[float, float]]
) -> Coordinates:
    """Return the coordinates of a mechanism and of what is free of its records' own."""
    clocks = [RecordCoordinate(t.name, p, None) for t in targets for p in t.moved if is_of_clock(p)]
    carried = [
        RecordCoordinate(t.name, p, lane)
        for t in targets
        for lane, p in enumerate(sorted((p for p in t.moved if not is_of_clock(p)), key=is_of_start), space.size)
    ]
    return Coordinates(space, (*clocks, *carried), priors)
