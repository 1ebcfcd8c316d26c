"""Fisher information of each record at each of several mechanisms, from exact Jacobians."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import count

import numpy as np
from scipy.stats import norm

from mechid.arrays import FloatArray
from mechid.designs.planned_record import PlannedRecord
from mechid.identification.computation.parallel import map_tasks
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.search.box import sample_box


def informations(
    space: SearchSpace,
    records: Sequence[PlannedRecord],
    points: FloatArray,
    workers: int = 1,
    on_record: Callable[[int, int], None] = lambda done, total: None,
) -> FloatArray:
    """Return the information of each record at each point, (points, records, n, n), in search coordinates.

    Offset, drift and a free time offset of a record are projected out. The information is zero where the simulation
    fails.

    Parameters
    ----------
    space : SearchSpace
    records : sequence of PlannedRecord
    points : (points, n)
        Search coordinates.
    workers : int
        Number of threads.
    on_record : callable
        Called with the number of records done and the total.
    """
    number = count(1)

    def report_progress(done: Sequence[object]) -> None:
        for _ in done:
            on_record(next(number), len(records))

    # Longest first: the last worker to finish then has a short record.
    order = sorted(range(len(records)), key=lambda k: -records[k].base.samples)
    found = map_tasks(
        partial(_record_information, space, points), [records[k] for k in order], workers, report_progress
    )
    out = np.zeros((len(points), len(records), space.size, space.size))
    out[:, order] = np.moveaxis(np.array(found).reshape(len(order), len(points), space.size, space.size), 0, 1)
    return out


def _record_information(space: SearchSpace, points: FloatArray, record: PlannedRecord) -> FloatArray:
    """Return the information of a record at each point, (points, n, n)."""
    problem = Problem(space, (record.target(),))
    own = problem.start[space.size :]
    with np.errstate(all="ignore"):
        return np.array([_information(problem, np.concatenate([q, own])) for q in points])


def _information(problem: Problem, q: FloatArray) -> FloatArray:
    """Return J^T J of a problem of one record, its free time offset eliminated, (n, n); zero where it failed."""
    size = problem.space.size
    (triangle,) = problem.triangles(q, problem.whole_windows())
    if not np.all(np.isfinite(triangle.jacobian)):
        return np.zeros((size, size))
    return without_offsets(triangle.jacobian, size)


def without_offsets(J: FloatArray, size: int) -> FloatArray:
    """Return the information on the first `size` coordinates, (size, size), with the remaining ones eliminated.

    `J`, (m, n), holds derivatives in standard deviations of the noise; free time offsets follow the mechanism's
    coordinates.
    """
    # The QR decomposition of zero columns has arbitrary unit vectors, which would remove information.
    if J.shape[1] > size and np.any(J[:, size:]):
        across, _ = np.linalg.qr(J[:, size:])
        J = J - across @ (across.T @ J)
    return np.asarray(J[:, :size].T @ J[:, :size], dtype=np.float64)


def prior_points(space: SearchSpace, count: int, seed: int) -> FloatArray:
    """Return mechanisms drawn from the prior of the file, (count, n) in search coordinates; its own values first.

    As for the starts of the search, each parameter varies within the usual error of catalogues, inside its bounds; one
    with a prior `sigma` is drawn from that.
    """
    # A Sobol sequence is balanced at powers of two.
    power = 1 << max(count - 1, 0).bit_length()
    points = sample_box(space, power, seed)[:count]
    rng = np.random.default_rng((seed, 1))
    for j, c in enumerate(space.coordinates):
        p = space.mechanism.parameters[c.name]
        if p.sigma and c.kind in ("log", "linear"):
            # Quantiles from 1 to 99 % keep every draw within 2.33 standard deviations.
            values = p.value + p.sigma * norm.ppf(rng.uniform(0.01, 0.99, len(points) - 1))
            values = np.clip(values, p.min, p.max)
            points[1:, j] = np.log(values) if c.kind == "log" else values
    return points


def range_information(space: SearchSpace) -> FloatArray:
    """Return the information of the file's bounds and priors, (n, n); a bound is treated as a uniform distribution.

    It is negligible against a record, but keeps a direction without any information from having an infinite error.
    """
    # A large width in place of an infinite one keeps the information positive definite.
    width = np.where(np.isfinite(space.upper - space.lower), space.upper - space.lower, 1e6)
    # The variance of a uniform distribution is its squared width over 12.
    known = np.diag(12.0 / width**2)
    names, slopes = space.value_jacobian(space.start)
    for name, row in zip(names, slopes, strict=True):
        if sigma := space.mechanism.parameters[name].sigma:
            known += np.outer(row, row) / sigma**2
    return known
