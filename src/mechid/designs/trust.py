"""Check of a record's derivatives by simulation at draws around a mechanism.

A long record with many stick-slip events can be highly informative in theory. If an event changes within a standard
error, however, its likelihood jumps: a fit then ends at the jump, and its standard errors are valid only locally.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from mechid.arrays import FloatArray
from mechid.designs.criterion import sizes
from mechid.designs.planned_record import PlannedRecord
from mechid.designs.settings import DESIGN
from mechid.identification.computation.parallel import map_tasks
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.uncertainty.settings import ERRORS


def departing_share(
    space: SearchSpace,
    records: Sequence[PlannedRecord],
    points: FloatArray,
    information: FloatArray,
    reference: FloatArray,
    *,
    seed: int = 0,
    workers: int = 1,
) -> FloatArray:
    """Return the share of draws, (records,), in which a record's cost departs from the quadratic of J^T J.

    Without noise the cost at a distance d is d^T J^T J d; a draw departs if the cost differs by more than one squared
    standard deviation of the noise.

    Parameters
    ----------
    space : SearchSpace
    records : sequence of PlannedRecord
    points : (s, n)
        Mechanisms, of which the first `DESIGN.mechanisms` are used.
    information : (s, records, n, n)
    reference : (s, n, n)
        The draws have its inverse as covariance: the information of a whole test.
    seed : int
    workers : int
        Number of threads.
    """
    looked = points[: DESIGN.mechanisms]
    rng = np.random.default_rng((seed, 3))
    size = sizes(space, points)
    steps = np.array(
        [_root(m, size) @ rng.standard_normal((space.size, DESIGN.draws)) for m in reference[: len(looked)]]
    )
    drawn = np.clip(looked[:, None] + steps.transpose(0, 2, 1), space.lower, space.upper)
    tasks = [(record, information[: len(looked), k]) for k, record in enumerate(records)]
    return np.array(map_tasks(partial(_share, space, looked, drawn), tasks, workers))


def _share(space: SearchSpace, points: FloatArray, drawn: FloatArray, task: tuple[PlannedRecord, FloatArray]) -> float:
    """Return the share of draws in which a record departs from its information, (points, n, n)."""
    record, information = task
    problem = Problem(space, (record.target().with_fixed_parameters,))
    return float(np.mean([_departing_at(problem, q, drawn[s], information[s]) for s, q in enumerate(points)]))


def _root(information: FloatArray, size: FloatArray) -> FloatArray:
    """Return a root of the inverse with no axis longer than `DESIGN.farthest`, so that all draws stay local."""
    values, vectors = np.linalg.eigh(information * np.outer(size, size))
    lengths = np.minimum(1.0 / np.sqrt(np.maximum(values, 1e-300)), DESIGN.farthest)
    return np.asarray(size[:, None] * vectors * lengths, dtype=np.float64)


def _departing_at(problem: Problem, q: FloatArray, draws: FloatArray, information: FloatArray) -> float:
    """Return the share of draws at which the cost of the torque at `q` departs from the quadratic."""
    (target,) = problem.targets
    (torque,) = problem.model.predict(target, q, target.samples)
    there = replace(target, channels=(replace(target.leading, measured=torque),))
    costs = np.square(problem.norms_at(there, list(draws), (0, target.samples)))
    promised = np.einsum("di,ij,dj->d", draws - q, information, draws - q)
    # Negated, so that a failed simulation, whose cost is NaN, counts as departing.
    return float(np.mean(~(np.abs(costs - promised) <= ERRORS.cost_departure)))
