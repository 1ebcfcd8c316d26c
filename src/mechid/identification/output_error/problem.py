"""The output-error problem: records against the model, reduced to triangles window by window."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from mechid.campaign.campaign import mechanism_name
from mechid.identification.computation.parallel import mapped
from mechid.identification.output_error.reduction import Triangle, absorb, combined, finished, of_rows
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.identification.output_error.weighted_rows import WeightedRows
from mechid.parameter import Parameter
from mechid.simulation.simulator import Block, Run, Simulator

FloatArray = NDArray[np.float64]
Result = TypeVar("Result")
ON_BOUND = 1e-6
"""Share of its range within which a coordinate counts as on its bound."""


Windows = Mapping[str, tuple[int, int]]
"""First and last-plus-one sample used of each record, by name."""


@dataclass(frozen=True, eq=False)
class Problem:
    """All targets and the search space. Coordinates: the mechanism's, free time offsets, records' own test stands.

    `priors` holds (value, standard deviation) by dotted name, in the file's units; those of parameters that the
    space does not move say nothing. `substeps` is the number of integration steps per sample, `workers` of
    threads over records.
    """

    space: SearchSpace
    targets: tuple[Target, ...]
    priors: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    substeps: int = 1
    workers: int = 1

    @cached_property
    def delayed_targets(self) -> tuple[str, ...]:
        """Names of the targets whose time offset is free, in the order of their coordinates."""
        return tuple(t.name for t in self.targets if t.time_offset_bounds)

    @cached_property
    def own(self) -> tuple[tuple[str, Parameter], ...]:
        """Target and parameter behind each coordinate of a test stand of its own."""
        return tuple((t.name, q) for t in self.targets for q in t.moved)

    @cached_property
    def lower(self) -> FloatArray:
        """Lower bounds of all coordinates."""
        delays = [b[0] for t in self.targets if (b := t.time_offset_bounds)]
        return np.concatenate([self.space.lower, delays, [q.min for _, q in self.own]])

    @cached_property
    def upper(self) -> FloatArray:
        """Upper bounds of all coordinates."""
        delays = [b[1] for t in self.targets if (b := t.time_offset_bounds)]
        return np.concatenate([self.space.upper, delays, [q.max for _, q in self.own]])

    @cached_property
    def start(self) -> FloatArray:
        """The values of the file in search coordinates."""
        delays = [t.time_offset_s for t in self.targets if t.time_offset_bounds]
        return np.concatenate([self.space.start, delays, [q.value for _, q in self.own]])

    def point(self, values: Mapping[str, float]) -> FloatArray:
        """Return the coordinates, (n,), of values by dotted name; what is not among them keeps that of the file."""
        mechanism = self.space.mechanism.parameters
        here = self.space.from_values({**{name: p.value for name, p in mechanism.items()}, **values})
        return np.concatenate([here, self.records_point(values)])

    def records_point(self, values: Mapping[str, float]) -> FloatArray:
        """Return the coordinates that belong to single records, by dotted name; others keep that of the file."""
        first = self.space.size
        pairs = zip(self.names[first:], self.start[first:].tolist(), strict=True)
        return np.array([values.get(name, start) for name, start in pairs])

    def values(self, q: FloatArray) -> dict[str, float]:
        """Return the file's values of all that is free, by dotted name, at `q`."""
        mechanism = self.space.at(q[: self.space.size])  # angles are wrapped there
        own = {p.name: mechanism.value(p.name) for p in mechanism.free}
        return own | dict(zip(self.names[self.space.size :], q[self.space.size :].tolist(), strict=True))

    @property
    def names(self) -> tuple[str, ...]:
        """Dotted name behind every coordinate; both parts of a detent have that of its amplitude."""
        delays = (f"record.{name}.time_offset_s" for name in self.delayed_targets)
        return (*(c.name for c in self.space.coordinates), *delays, *(q.name for _, q in self.own))

    def in_polar(self, amplitudes: frozenset[str], q: FloatArray) -> tuple[Problem, FloatArray]:
        """Return the problem, and its point, with some detents searched by amplitude and phase."""
        space = SearchSpace(self.space.mechanism, self.space.polar | amplitudes)
        values = {p.name: p.value for p in self.space.at(q[: self.space.size]).parameters.values()}
        return replace(self, space=space), np.concatenate([space.from_values(values), q[self.space.size :]])

    def on_bound(self, q: FloatArray) -> NDArray[np.bool_]:
        """Return which coordinates stand on a bound of the file, (n,); that of a detent's disc is its radius."""
        span = self.upper - self.lower
        on = (q - self.lower < ON_BOUND * span) | (self.upper - q < ON_BOUND * span)
        for j, c in enumerate(self.space.coordinates):
            if c.kind == "excess":
                static = self.space.mechanism.parameters[c.name]
                value, gap = self.space.values(q[: self.space.size])[c.name], ON_BOUND * static.max
                on[j] |= value >= static.max - gap or 0.0 < static.min >= value - gap
            elif c.kind == "cosine":
                on[j] = on[j + 1] = math.hypot(q[j], q[j + 1]) > (1.0 - ON_BOUND) * c.upper
            elif self.space.is_turning(c):
                on[j] = False
        return np.asarray(on, dtype=np.bool_)

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return self.space.size + len(self.delayed_targets) + len(self.own)

    def only(self, names: Sequence[str]) -> Problem:
        """Return the problem with some targets alone; coordinates of other time offsets are dropped."""
        return replace(self, targets=tuple(t for t in self.targets if t.name in names))

    def output(self, quantity: str) -> int:
        """Return which of the plant's outputs a quantity is."""
        return self._outputs[quantity]

    @cached_property
    def _outputs(self) -> dict[str, int]:
        return {quantity: j for j, quantity in enumerate(self.space.mechanism.plant.outputs)}

    def with_sigmas(self, sigmas: Mapping[str, float]) -> Problem:
        """Return the problem with other noise levels of the leading channels, by record."""
        return replace(
            self,
            targets=tuple(
                replace(t, channels=(replace(t.leading, sigma=sigmas.get(t.name, t.leading.sigma)), *t.channels[1:]))
                for t in self.targets
            ),
        )

    def whole(self) -> dict[str, tuple[int, int]]:
        """Return windows that cover all records."""
        return {t.name: (0, t.samples) for t in self.targets}

    def time_offset(self, target: Target, q: FloatArray) -> float:
        """Return the time offset of a target at `q`, s."""
        if target.name not in self.delayed_targets:
            return target.time_offset_s
        return float(q[self.space.size + self.delayed_targets.index(target.name)])

    def own_values(self, target: Target, q: FloatArray) -> dict[str, float]:
        """Return the values of the test stand that are a target's own at `q`, by the mechanism's names."""
        values = {p.name: p.value for p in target.stand}
        first = self.size - len(self.own)
        values |= {p.name: float(x) for (name, p), x in zip(self.own, q[first:], strict=True) if name == target.name}
        return {mechanism_name(name): value for name, value in values.items()}

    def run(
        self,
        target: Target,
        q: FloatArray,
        stop: int,
        *,
        jacobian: bool = False,
        events: int = 0,
        block: int | None = None,
    ) -> Run:
        """Begin the simulation of the first `stop` samples of a target at `q`; it logs so many switches."""
        here, own = q[: self.space.size], self.own_values(target, q) if target.stand else None
        p = self.space.kernel(here, own)
        directions = None
        if jacobian:  # a time offset that is free alone needs sensitivities too
            directions = self.space.kernel_jacobian(here, own, [mechanism_name(m.name) for m in target.moved])
            directions = directions if directions.size else np.zeros((p.size, 1))
        return self._simulator(target).run(
            p, time_offset_s=self.time_offset(target, q), substeps=self.substeps, directions=directions, samples=stop,
            events=events, block=block,
        )  # fmt: skip

    def _simulator(self, target: Target) -> Simulator:
        if target.name not in self._simulators:
            self._simulators[target.name] = Simulator(
                self.space.mechanism.plant,
                target.command,
                target.base,
                capacity=self.space.size + max((len(t.moved) for t in self.targets), default=0),
                known_edges=target.excitation,
            )
        return self._simulators[target.name]

    @cached_property
    def _simulators(self) -> dict[str, Simulator]:
        """One a target: what it prepares for its runs serves all of them."""
        return {}

    def predict(self, target: Target, q: FloatArray, stop: int) -> tuple[FloatArray, ...]:
        """Return what the model gives of each channel over the first `stop` samples, (stop,); NaN where it failed."""
        y = tuple(np.empty(min(stop, target.samples)) for _ in target.channels)
        outputs = [self.output(quantity) for quantity in target.quantities]
        for block in self.run(target, q, stop).blocks():
            for values, j in zip(y, outputs, strict=True):
                values[block.start : block.stop] = block.y[:, j]
        return y

    def misfit(self, target: Target, q: FloatArray, window: tuple[int, int]) -> tuple[FloatArray, ...]:
        """Return measured minus model of each channel over a window, (n,); NaN where the simulation failed."""
        return tuple(
            np.subtract(channel.measured[window[0] : window[1]], y[window[0] :], out=y[window[0] :])
            for channel, y in zip(target.channels, self.predict(target, q, window[1]), strict=True)
        )

    def norm(self, target: Target, q: FloatArray, window: tuple[int, int]) -> float:
        """Return ||r|| of a target in a window, projected, in sigmas; inf where the simulation failed."""
        triangles, succeeded = self.reduced(target, q, window, jacobian=False)
        if not succeeded:
            return np.inf
        norms = [
            finished(R, channel.linear, window[1] - window[0]).norm
            for channel, R in zip(target.channels, triangles, strict=True)
        ]
        return norms[0] if len(norms) == 1 else float(np.linalg.norm(norms))

    def triangle(self, target: Target, q: FloatArray, window: tuple[int, int]) -> Triangle:
        """Return the reduced problem of a target in a window, of all its channels together; the last one is kept."""
        key = (target, q.tobytes(), window)
        if target.name not in self._last or self._last[target.name][0] != key:
            self._last[target.name] = key, self._triangle(target, q, window)
        return self._last[target.name][1]

    @cached_property
    def _last(self) -> dict[str, tuple[tuple[Target, bytes, tuple[int, int]], Triangle]]:
        """Where each target was last reduced, and what came of it: an end is looked at from several sides."""
        return {}

    def _triangle(self, target: Target, q: FloatArray, window: tuple[int, int]) -> Triangle:
        each = self.channel_triangles(target, q, window)
        if each is None:
            lost = np.full((1 + self.size, self.size), np.nan)
            return Triangle(np.inf, lost, (window[1] - window[0]) * len(target.channels))
        return each[0] if len(each) == 1 else combined(each)

    def channel_triangles(self, target: Target, q: FloatArray, window: tuple[int, int]) -> list[Triangle] | None:
        """Return the reduced problem of each channel of a target in a window; None where the simulation failed."""
        triangles, succeeded = self.reduced(target, q, window, jacobian=True)
        if not succeeded:
            return None
        n = window[1] - window[0]
        return [finished(R, c.linear, n) for c, R in zip(target.channels, triangles, strict=True)]

    def reduced(
        self, target: Target, q: FloatArray, window: tuple[int, int], *, jacobian: bool
    ) -> tuple[list[FloatArray], bool]:
        """Return each channel's triangle of [Phi r J] (or [Phi r]) in sigmas, and whether the simulation succeeded."""
        blocks = WeightedRows(self, target, q, window, jacobian=jacobian)
        triangles = [np.zeros((width, width)) for width in blocks.widths]
        for k, rows, n in blocks:
            absorb(triangles[k], rows, n)
        for R, channel in zip(triangles, target.channels, strict=True):
            R[:, channel.linear :] /= channel.scale
        return triangles, blocks.succeeded

    def write_jacobian(self, rows: FloatArray, target: Target, channel: TargetChannel, block: Block, n: int) -> None:
        """Write dy/dq of a channel over the last n samples of a block as rows; the delay of another record has none."""
        moved, j = self.space.size, self.output(channel.quantity)
        rows[:moved, :n] = block.jacobian[-n:, j, :moved].T
        for i, name in enumerate(self.delayed_targets):
            rows[moved + i, :n] = -block.rate[-n:, j] if name == target.name else 0.0
        lane, first = moved, moved + len(self.delayed_targets)
        for i, (name, _) in enumerate(self.own):
            rows[first + i, :n] = block.jacobian[-n:, j, lane] if name == target.name else 0.0
            lane += name == target.name

    def jacobian_block(self, target: Target, channel: TargetChannel, block: Block, n: int) -> FloatArray:
        """Return dy/dq of a channel over the last n samples of a block, (n, size)."""
        rows = np.zeros((self.size, n))
        self.write_jacobian(rows, target, channel, block, n)
        return rows.T

    @staticmethod
    def linear_rows(rows: FloatArray, linear: int, window: tuple[int, int], first: int, n: int) -> None:
        """Write what is projected out, offset and drift over the window from -1 to 1, as rows."""
        if linear > 0:
            rows[0, :n] = 1.0
        if linear > 1:
            middle, half = 0.5 * sum(window), max(0.5 * (window[1] - window[0]), 1.0)
            rows[1, :n] = (np.arange(first, first + n) - middle) / half

    def norms(self, q: FloatArray, windows: Windows) -> list[float]:
        """Return ||r|| of every target, in parallel over records."""
        return self._over_targets(self.norm, q, windows)

    def total_norm(self, q: FloatArray, windows: Windows) -> float:
        """Return the norm of all residuals and of what the priors say, in sigmas."""
        away, _ = self.prior_rows(q)
        return float(np.linalg.norm([*self.norms(q, windows), *away]))

    def prior_rows(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return how far each prior is from its value, (k,) in sigmas, and its derivative, (k, n)."""
        if not self.priors:
            return np.zeros(0), np.zeros((0, self.size))
        here = q[: self.space.size]
        names, slopes = self.space.value_jacobian(here)
        values = self.space.values(here)
        rows = [(i, name, *self.priors[name]) for i, name in enumerate(names) if name in self.priors]
        own = [(j, *self.priors[name]) for j, name in enumerate(self.names) if j >= here.size and name in self.priors]
        away, J = np.zeros(len(rows) + len(own)), np.zeros((len(rows) + len(own), self.size))
        for k, (j, value, sigma) in enumerate(own, len(rows)):
            away[k], J[k, j] = (q[j] - value) / sigma, 1.0 / sigma
        for k, (i, name, value, sigma) in enumerate(rows):
            off = values[name] - value
            if self.space.mechanism.parameters[name].is_periodic:
                off = (off + 180.0) % 360.0 - 180.0
            away[k], J[k, : self.space.size] = off / sigma, slopes[i] / sigma
        return away, J

    def triangles(self, q: FloatArray, windows: Windows) -> list[Triangle]:
        """Return the reduced problem of every target, in parallel over records."""
        return self._over_targets(self.triangle, q, windows)

    def joint(self, q: FloatArray, windows: Windows) -> Triangle:
        """Return the reduced problem of all targets together, and of the priors."""
        return combined([*self.triangles(q, windows), *self.prior_triangles(q)])

    def prior_triangles(self, q: FloatArray) -> list[Triangle]:
        """Return what the priors add to a joint problem: one triangle, or none where there is no prior."""
        away, J = self.prior_rows(q)
        return [of_rows(away, J)] if away.size else []

    def _over_targets(
        self, what: Callable[[Target, FloatArray, tuple[int, int]], Result], q: FloatArray, windows: Windows
    ) -> list[Result]:
        """Work on every target that has a window, the longest first, and return in their own order."""
        used = [t for t in self.targets if t.name in windows]
        order = sorted(range(len(used)), key=lambda i: -windows[used[i].name][1])
        done = mapped(lambda i: what(used[i], q, windows[used[i].name]), order, self.workers)
        return [result for _, result in sorted(zip(order, done, strict=True), key=lambda pair: pair[0])]
