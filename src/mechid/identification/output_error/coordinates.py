"""Coordinates of the optimiser: the search coordinates of the mechanism, followed by those of single records.

This module alone knows which coordinate belongs to which record and how it acts on the record's run. A record parameter
is one of three kinds: a value of the mechanism that holds for that record only, whose derivative is a lane of the
kernel; a state of its start, whose lane changes no parameter and begins at the derivatives of the start states; or a
shift of its sample instants (`INSTANTS`), whose derivative follows from the rate of the output. A parameter that
several records share under one name, such as a common clock, is one coordinate. The names, bounds, values, priors and
derivatives of all coordinates are computed here; a new record parameter of any kind is one more entry.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import count

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.campaign.campaign import is_of_start
from mechid.command import Timing
from mechid.identification.output_error.point_cache import PointCache
from mechid.identification.output_error.record_parameters import Mean, RecordCoordinate, means_of
from mechid.identification.output_error.settings import PROBLEM
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import Target, is_clock
from mechid.parameter import Parameter
from mechid.simulation.block import Block
from mechid.simulation.time_scale import clock_direction, output_slope
from mechid.units import angle_difference


@dataclass(frozen=True, eq=False)
class Coordinates:
    """Coordinates of a mechanism and of its records, in this order, with the maps from and to them.

    Attributes
    ----------
    space : SearchSpace
        Coordinates of the mechanism's free parameters.
    own : tuple of RecordCoordinate
        Coordinates of records: those that shift instants, then values of the mechanism and start states.
    priors : mapping of str to (float, float)
        Value and standard deviation by dotted name, in the file's units; entries of fixed parameters are ignored. For a
        per-record value whose mean is a free parameter, the standard deviation is that of its difference from the mean.
    means : tuple of Mean
    shrinkage : mapping of str to float
        Standard deviation about 0 of the mechanism's coordinates by dotted name, in their own scale. Both parts of a
        detent have that of its amplitude, which itself has no derivative at 0.
    capacity : int
        Least number of lanes of the kernel, so that models of one plant share a kernel.
    """

    space: SearchSpace
    own: tuple[RecordCoordinate, ...] = ()
    priors: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    means: tuple[Mean, ...] = ()
    shrinkage: Mapping[str, float] = field(default_factory=dict)
    capacity: int = 0
    _latest: PointCache = field(default_factory=PointCache, repr=False)

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return self.space.size + len(self.own)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Dotted name of every coordinate; both parts of a detent have that of its amplitude."""
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
        """Values of the file, (n,)."""
        return np.concatenate([self.space.start, [c.parameter.value for c in self.own]])

    @property
    def record_parameter_names(self) -> tuple[str, ...]:
        """Dotted names of the coordinates of records."""
        return tuple(self._places)

    @cached_property
    def _places(self) -> dict[str, int]:
        """Index of each record coordinate, by dotted name."""
        return {c.parameter.name: j for j, c in enumerate(self.own, self.space.size)}

    def of_mechanism(self, q: FloatArray) -> FloatArray:
        """Return the mechanism's part of a point."""
        return q[: self.space.size]

    def of_records(self, q: FloatArray) -> FloatArray:
        """Return the records' part of a point."""
        return q[self.space.size :]

    def point(self, values: Mapping[str, float]) -> FloatArray:
        """Return the coordinates, (n,), of values by dotted name; missing names keep the file's values."""
        mechanism = self.space.mechanism.parameters
        here = self.space.from_values({**{name: p.value for name, p in mechanism.items()}, **values})
        return np.concatenate([here, self.records_point(values)])

    def records_point(self, values: Mapping[str, float]) -> FloatArray:
        """Return the record coordinates of values by dotted name; missing names keep the file's values."""
        return np.array([values.get(c.parameter.name, c.parameter.value) for c in self.own])

    def values(self, q: FloatArray) -> dict[str, float]:
        """Return the file's values of all free parameters at `q`, by dotted name."""
        # Values are read back from the mechanism, which wraps free angles into one turn.
        mechanism = self.space.at(self.of_mechanism(q))
        return {p.name: mechanism.value(p.name) for p in mechanism.free} | self.records_values(q)

    def value(self, parameter: Parameter, q: FloatArray) -> float:
        """Return the value of a record parameter at `q`: that of its coordinate, or its known value."""
        place = self._places.get(parameter.name)
        return parameter.value if place is None else float(q[place])

    def records_values(self, q: FloatArray) -> dict[str, float]:
        """Return the values of the record coordinates at `q`, by dotted name."""
        return dict(zip(self._places, self.of_records(q).tolist(), strict=True))

    def value_slopes(self, q: FloatArray) -> tuple[tuple[str, ...], FloatArray]:
        """Return the names of all free parameters, (m,), and d(value)/dq, (m, n), in the file's units."""
        names, slopes = self.space.value_jacobian(self.of_mechanism(q))
        whole = np.zeros((len(names) + len(self.own), self.size))
        whole[: len(names), : self.space.size] = slopes
        whole[len(names) :, self.space.size :] = np.eye(len(self.own))
        return (*names, *self._places), whole

    def on_bound(self, q: FloatArray) -> BoolArray:
        """Return which coordinates lie on a bound of the file, (n,).

        For both parts of a detent, the bound is the radius of their disc.
        """
        gap = PROBLEM.on_bound * self.span
        on = (q - self.lower < gap) | (self.upper - q < gap)
        for j, c in enumerate(self.space.coordinates):
            if c.kind == "excess":
                static = self.space.mechanism.parameters[c.name]
                value, near = self.space.values(self.of_mechanism(q))[c.name], PROBLEM.on_bound * static.max
                on[j] |= value >= static.max - near or 0.0 < static.min >= value - near
            elif c.kind == "cosine":
                # The parts of a detent have no bounds of their own: the limit of the amplitude is a circle.
                on[j] = on[j + 1] = math.hypot(q[j], q[j + 1]) > (1.0 - PROBLEM.on_bound) * c.upper
            elif self.space.is_turning(c):
                on[j] = False
        return np.asarray(on, dtype=np.bool_)

    def prior_rows(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the deviation of each prior and each mean, (k,) in sigmas, and its derivative, (k, n)."""
        shrunk, D = self._shrunk_rows(q)
        if not self.priors and not self.means:
            return shrunk, D
        names, slopes = self.value_slopes(q)
        slope = dict(zip(names, slopes, strict=True))
        values = self.space.values(self.of_mechanism(q)) | self.records_values(q)
        known, around = self.space.mechanism.parameters, self._mean_parameters
        away, J = [], []
        for name in (name for name in names if name in self.priors):
            value, sigma = self.priors[name]
            off, turn = values[name] - value, slope[name]
            if name in around:
                off, turn = off - (values[around[name]] - known[around[name]].value), turn - slope[around[name]]
            if name in known and known[name].is_periodic:
                # A periodic parameter has no bounds, so its value may be whole turns away from the prior's.
                off = angle_difference(off)
            away.append(off / sigma)
            J.append(turn / sigma)
        for mean in self.means:
            off = float(np.mean([values[name] for name in mean.own])) - values.get(mean.of, known[mean.of].value)
            away.append(off / mean.sigma)
            J.append(_mean_slope(mean, slope) / mean.sigma)
        return np.concatenate([away, shrunk]), np.vstack([np.reshape(J, (len(away), self.size)), D])

    def undetermined_means(self, q: FloatArray) -> list[tuple[FloatArray, int]]:
        """Return the change of the score if a mean that no record determines is off by its standard error, (n,).

        Each is paired with the degrees of freedom of that standard error. The estimate moves by (J^T J)^-1 times the
        change.
        """
        names, slopes = self.value_slopes(q)
        slope, values = dict(zip(names, slopes, strict=True)), self.records_values(q)
        return [
            (
                _mean_slope(mean, slope) * mean.standard_error([values[n] for n in mean.own]) / mean.sigma**2,
                len(mean.own) - 1,
            )
            for mean in self.means
            if not mean.is_determined
        ]

    def _shrunk_rows(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the value of each coordinate shrunk towards 0, (k,) in sigmas, and its derivative, (k, n)."""
        places = [j for j, c in enumerate(self.space.coordinates) if c.name in self.shrinkage]
        widths = np.array([self.shrinkage[self.space.coordinates[j].name] for j in places])
        D = np.zeros((len(places), self.size))
        D[np.arange(len(places)), places] = 1.0 / widths
        return q[places] / widths, D

    @cached_property
    def _mean_parameters(self) -> dict[str, str]:
        """Name of the free mechanism parameter that is the mean, by the name of the record's value."""
        free = {p.name for p in self.space.mechanism.free}
        return {name: mean.of for mean in self.means if mean.of in free for name in mean.own}

    @property
    def lanes(self) -> int:
        """Number of lanes of any run: the mechanism's and those of the record that has most, at least `capacity`."""
        return max(self.space.size, *(c.lane + 1 for c in self.own if c.lane is not None), self.capacity)

    def timing(self, target: Target, q: FloatArray) -> Timing:
        """Return the map from record time to command time of a target at `q`."""
        clock_ppm = sum(self.value(clock, q) for clock in target.clocks)
        return Timing(self.value(target.time_offset, q), clock_ppm, target.clock_reference)

    def own_values(self, target: Target, q: FloatArray) -> dict[str, float]:
        """Return the values at `q` that hold for one target only, by the mechanism's names."""
        return {p.replaces: self.value(p, q) for p in target.own if p.replaces}

    def kernel(self, target: Target, q: FloatArray) -> FloatArray:
        """Return the kernel's parameters of a target at `q`, (NP,)."""
        own, here = self.own_values(target, q), self.of_mechanism(q)
        if own:
            return self.space.kernel(here, own)
        return self._latest.of("values", here, self.space.kernel)

    def directions(self, target: Target, q: FloatArray) -> FloatArray:
        """Return the derivatives of the kernel's parameters with respect to a target's lanes, (NP, m).

        There is at least one lane: shifts of instants need the rate of the output, which only runs with sensitivities
        compute.
        """
        lanes, here = [c for c in self.of(target) if c.lane is not None], self.of_mechanism(q)
        own = self.own_values(target, q)
        if not lanes and not own and self.space.size:
            return self._latest.of("directions", here, self.space.kernel_jacobian)
        carried = [c for c in lanes if c.parameter.replaces]
        names = [c.parameter.replaces for c in carried]
        found = self.space.kernel_jacobian(here, own, names)
        out = np.zeros((found.shape[0], max([1, self.space.size, *(1 + (c.lane or 0) for c in lanes)])))
        out[:, : self.space.size] = found[:, : self.space.size]
        for c, column in zip(carried, found[:, self.space.size :].T, strict=True):
            out[:, c.lane] = column
        for c in lanes:
            if is_clock(c.parameter):
                plant, p = self.space.mechanism.plant, self.kernel(target, q)
                out[:, c.lane] = clock_direction(plant, p, self.timing(target, q))
        return out

    def of(self, target: Target) -> list[RecordCoordinate]:
        """Return the record coordinates of a target."""
        return [c for c in self.own if target.name in c.records]

    def write_slopes(self, rows: FloatArray, target: Target, output: int, block: Block, n: int) -> None:
        """Write dy/dq of an output over the last n samples of a block as rows.

        Rows of other records' coordinates are zero.
        """
        moved = self.space.size
        rows[:moved, :n] = block.jacobian[-n:, output, :moved].T
        for j, c in enumerate(self.own, moved):
            rows[j, :n] = c.slope(target.base, block, output, n) if target.name in c.records else 0.0
            if c.lane is not None and is_clock(c.parameter) and target.name in c.records:
                rows[j, :n] += output_slope(self.space.mechanism.plant, output) * block.y[-n:, output]
            # The record's own value uses the lane of the mechanism parameter that it replaces, and that parameter does
            # not act here.
            if c.lane is not None and c.lane < moved and target.name in c.records:
                rows[c.lane, :n] = 0.0

    def block_slopes(self, target: Target, output: int, block: Block, n: int) -> FloatArray:
        """Return dy/dq of an output over the last n samples of a block, (n, size)."""
        rows = np.zeros((self.size, n))
        self.write_slopes(rows, target, output, block, n)
        return rows.T


def coordinates_of(
    space: SearchSpace,
    targets: Sequence[Target],
    priors: Mapping[str, tuple[float, float]],
    shrinkage: Mapping[str, float],
) -> Coordinates:
    """Return the coordinates of a mechanism and of the free parameters of its records."""
    moving = {p.name: p for t in targets for p in t.free_parameters if not (p.replaces or is_of_start(p))}
    owners = {name: tuple(t.name for t in targets if name in (p.name for p in t.free_parameters)) for name in moving}
    lane = space.size if any(_scales_time(t) for t in targets) else None
    instants = [RecordCoordinate(owners[name], p, lane if is_clock(p) else None) for name, p in moving.items()]
    carried = [c for target in targets for c in _lane_coordinates(space, target, kept=lane is not None)]
    return Coordinates(space, (*instants, *carried), priors, tuple(means_of(targets)), shrinkage)


def _mean_slope(mean: Mean, slope: Mapping[str, FloatArray]) -> FloatArray:
    """Return the derivative of a mean's deviation from the mechanism's value, (n,), from those of the values."""
    turn: FloatArray = np.mean([slope[name] for name in mean.own], axis=0) - slope.get(mean.of, 0.0)
    return turn


def _scales_time(target: Target) -> bool:
    """Tell whether a target has a free clock that scales the mechanism's own time, for which a lane is reserved."""
    return target.clock_reference == "recorder" and any(map(is_clock, target.free_parameters))


def _lane_coordinates(space: SearchSpace, target: Target, *, kept: bool) -> Iterator[RecordCoordinate]:
    """Yield a target's own values of the mechanism and start states, each with its lane.

    A value that replaces a mechanism coordinate uses that coordinate's lane, which is idle in this record. Others get a
    further lane, after the one of the clocks if it is `kept` for them.
    """
    # A lane can be shared only with a coordinate that changes nothing else.
    idle = {c.name: j for j, c in enumerate(space.coordinates) if space.stands_alone(c)}
    further = count(space.size + kept)
    for p in (p for p in target.free_parameters if p.replaces or is_of_start(p)):
        lane = idle.get(p.replaces)
        yield RecordCoordinate((target.name,), p, next(further) if lane is None else lane)
