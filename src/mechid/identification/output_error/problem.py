"""Output-error problem: coordinates, records and weights, joined over records and priors."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.computation.parallel import in_threads, is_on_one_core
from mechid.identification.output_error.coordinates import Coordinates, coordinates_of
from mechid.identification.output_error.misfit import Model, Window
from mechid.identification.output_error.reduction import (
    Triangle,
    TriangleCache,
    combine_triangles,
    norms,
    triangle_of_rows,
)
from mechid.identification.output_error.settings import PROBLEM
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import Target

Result = TypeVar("Result")
Windows = Mapping[str, Window]
"""First and last-plus-one sample used of each record, by name."""


@dataclass(frozen=True, eq=False)
class Problem:
    """Targets to be matched and the coordinates that are varied to match them.

    Attributes
    ----------
    space : SearchSpace
    targets : tuple of Target
        With the free parameters of each record and the weights of its channels.
    priors : mapping of str to (float, float)
        Value and standard deviation by dotted name, in the file's units; entries of fixed parameters are ignored.
    shrinkage : mapping of str to float
        Standard deviation about 0 of coordinates that should be small, by dotted name, in the coordinates' scale.
    substeps : int
        Integration steps per sample.
    capacity : int
        Least number of derivative lanes of the kernel: problems of one plant share a kernel.
    workers : int
        Threads over records.
    latest : TriangleCache
        The only state that it keeps.
    """

    space: SearchSpace
    targets: tuple[Target, ...]
    priors: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    shrinkage: Mapping[str, float] = field(default_factory=dict)
    substeps: int = 1
    capacity: int = 0
    workers: int = 1
    latest: TriangleCache = field(init=False, repr=False, default_factory=TriangleCache)

    @cached_property
    def coordinates(self) -> Coordinates:
        """All coordinates, their owners, and the maps from and to the file's values."""
        found = coordinates_of(self.space, self.targets, self.priors, self.shrinkage)
        return replace(found, capacity=self.capacity)

    @cached_property
    def model(self) -> Model:
        """Model of the mechanism at any point of the coordinates."""
        return Model(self.coordinates, self.substeps)

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return self.coordinates.size

    @property
    def start(self) -> FloatArray:
        """Values of the file in search coordinates, (n,)."""
        return self.coordinates.start

    def whole_windows(self) -> dict[str, Window]:
        """Return windows that cover all records."""
        return {t.name: (0, t.samples) for t in self.targets}

    def restrict_to(self, names: Sequence[str]) -> Problem:
        """Return the problem with some targets only; coordinates of other records are dropped."""
        return replace(self, targets=tuple(t for t in self.targets if t.name in names))

    @property
    def rest_problem(self) -> Problem:
        """Problem of the records that do not begin in motion.

        The problem itself if there are no such records, or if all are.
        """
        names = [t.name for t in self.targets if not t.begins_in_motion]
        return self.restrict_to(names) if 0 < len(names) < len(self.targets) else self

    def point_from(self, other: Problem, q: FloatArray, at: FloatArray | None = None) -> FloatArray:
        """Return a point, (n,), from that of a problem of the same mechanism with other records.

        Parameters of records that the other problem does not have are taken from `at`, by default from their start.
        """
        rest = self.coordinates.records_values(self.start if at is None else at)
        records = self.coordinates.records_point({**rest, **other.coordinates.records_values(q)})
        return np.concatenate([other.coordinates.of_mechanism(q), records])

    def fix_mechanism(self, q: FloatArray) -> Problem:
        """Return the problem with the mechanism fixed at `q`; only the record parameters stay free."""
        return replace(self, space=SearchSpace(self.space.at(self.coordinates.of_mechanism(q)).with_free(())))

    def with_sigmas(self, sigmas: Mapping[str, float]) -> Problem:
        """Return the problem with other noise levels of the leading channels, by record."""
        return replace(
            self,
            targets=tuple(
                replace(t, channels=(replace(t.leading, sigma=sigmas.get(t.name, t.leading.sigma)), *t.channels[1:]))
                for t in self.targets
            ),
        )

    def to_polar(self, amplitudes: frozenset[str], q: FloatArray) -> tuple[Problem, FloatArray]:
        """Return the problem, and its point, with some detents searched by amplitude and phase."""
        at = self.coordinates
        space = SearchSpace(self.space.mechanism, self.space.polar | amplitudes)
        values = {p.name: p.value for p in self.space.at(at.of_mechanism(q)).parameters.values()}
        return replace(self, space=space), np.concatenate([space.from_values(values), at.of_records(q)])

    def norm(self, target: Target, q: FloatArray, window: Window) -> float:
        """Return ||r|| of a target in a window, projected, in sigmas; inf if the simulation failed."""
        return self.norms_at(target, [q], window)[0]

    def norms_at(self, target: Target, points: Sequence[FloatArray], window: Window) -> list[float]:
        """Return ||r|| of a target at several points, simulated in batches."""
        return norms(self.model, target, points, window)

    def triangle(self, target: Target, q: FloatArray, window: Window, threads: int = 1) -> Triangle:
        """Return the reduced problem of a target in a window, for all its channels; the latest one is cached."""
        return self.latest.of(replace(self.model, threads=threads), target, q, window)

    def norms(self, q: FloatArray, windows: Windows) -> list[float]:
        """Return ||r|| of every target, in parallel over records."""
        return self._over_targets(self.norm, q, windows)

    def triangles(self, q: FloatArray, windows: Windows) -> list[Triangle]:
        """Return the reduced problem of every target, in parallel over records, and a long one itself on threads."""
        threads = self._threads_by_record(windows)
        return self._over_targets(lambda t, at, window: self.triangle(t, at, window, threads[t.name]), q, windows)

    def total_norm(self, q: FloatArray, windows: Windows) -> float:
        """Return the norm of all residuals and priors, in sigmas."""
        away, _ = self.coordinates.prior_rows(q)
        return float(np.linalg.norm([*self.norms(q, windows), *away]))

    def joint(self, q: FloatArray, windows: Windows) -> Triangle:
        """Return the reduced problem of all targets and of the priors."""
        return combine_triangles([*self.triangles(q, windows), *self.prior_triangles(q)])

    def prior_triangles(self, q: FloatArray) -> list[Triangle]:
        """Return the contribution of the priors to a joint problem: one triangle, or none without priors."""
        away, J = self.coordinates.prior_rows(q)
        return [triangle_of_rows(away, J)] if away.size else []

    def _threads_by_record(self, windows: Windows) -> dict[str, int]:
        """Return the number of threads that share the directions of each record: its share of all samples."""
        samples = {name: stop for name, (_, stop) in windows.items()}
        if self.workers == 1 or is_on_one_core():
            return dict.fromkeys(samples, 1)
        each = max(sum(samples.values()) / self.workers, PROBLEM.fewest_to_divide)
        return {name: max(round(n / each), 1) for name, n in samples.items()}

    def _over_targets(
        self, reduce: Callable[[Target, FloatArray, Window], Result], q: FloatArray, windows: Windows
    ) -> list[Result]:
        """Apply a function to every target that has a window, the longest first; return results in target order."""
        used = [t for t in self.targets if t.name in windows]
        # The longest record first, so that no thread is left with it at the end.
        order = sorted(range(len(used)), key=lambda i: -windows[used[i].name][1])
        done = in_threads(lambda i: reduce(used[i], q, windows[used[i].name]), order, self.workers)
        return [result for _, result in sorted(zip(order, done, strict=True), key=lambda pair: pair[0])]


def enough_substeps(problem: Problem, q: FloatArray, windows: Windows) -> int:
    """Return the steps per sample, up to 8 times the problem's, that give every record the promised accuracy at `q`.

    Halving the step reduces the error sixteenfold, so the difference from the halved step is the error. The promise is
    an RMS error of 1e-5 of the RMS of each channel.
    """
    used = [t for t in problem.targets if t.name in windows]
    for _ in range(PROBLEM.most_doublings):
        # The halved step is also the next candidate, so no third run is needed for the error.
        halved = replace(problem, substeps=2 * problem.substeps)
        if all(_relative_error(problem, halved, t, q, windows[t.name][1]) <= PROBLEM.promised_accuracy for t in used):
            break
        problem = halved
    return problem.substeps


def _relative_error(coarse: Problem, fine: Problem, target: Target, q: FloatArray, stop: int) -> float:
    """Return the RMS difference of two runs relative to the RMS of the finer one, for the worst channel."""
    outputs = [coarse.model.output(quantity) for quantity in target.quantities]
    error, size = np.zeros(len(outputs)), np.zeros(len(outputs))
    runs = (problem.model.shared_run(target, q, stop) for problem in (coarse, fine))
    blocks = zip(*(run.blocks() for run in runs), strict=True)
    for rough, exact in blocks:
        for k, j in enumerate(outputs):
            error[k] += np.sum((rough.y[:, j] - exact.y[:, j]) ** 2)
            size[k] += np.sum(exact.y[:, j] ** 2)
    return math.sqrt(float(np.max(error / np.maximum(size, 1e-300))))


def transfer_coordinates(problem: Problem, q: FloatArray, other: Problem) -> FloatArray:
    """Return a point in a problem of the same mechanism whose records have other parameters.

    The coordinates of the mechanism are kept exactly, which `transfer_values` cannot do: a logarithm, or a pair of
    amplitude and phase, changes in its last digits on the way through the file's values. A new parameter of a record
    starts at the mechanism's value if it replaces a free one, otherwise at its own start.
    """
    records = {**_values_to_replace(problem, q, other), **problem.coordinates.records_values(q)}
    return np.concatenate([problem.coordinates.of_mechanism(q), other.coordinates.records_point(records)])


def transfer_values(
    problem: Problem, q: FloatArray, other: Problem, values: Mapping[str, float] | None = None
) -> FloatArray:
    """Return a point in a problem of the same records whose mechanism and records may have other parameters.

    The values are the file's values at `q`, or `values` by the names of the other problem. A new parameter starts at
    its start, such as the null value of a term; a new record parameter starts as in `transfer_coordinates`.
    """
    values = problem.coordinates.values(q) if values is None else values
    return other.coordinates.point({**_values_to_replace(problem, q, other), **values})


def _values_to_replace(problem: Problem, q: FloatArray, other: Problem) -> dict[str, float]:
    """Return the mechanism's values for record parameters that replace them in another problem."""
    values = problem.space.values(problem.coordinates.of_mechanism(q))
    replaced = ((c.parameter.name, c.parameter.replaces) for c in other.coordinates.own)
    return {name: values[of] for name, of in replaced if of in values}
