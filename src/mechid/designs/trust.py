"""Validity of a record's derivatives: draws around a mechanism, simulated again.

A long record of many stick/slips can be full of information on paper, and yet a stick/slip that falls the other way
within a standard error makes its likelihood jump: a fit then ends at a cliff, and its errors are local only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from mechid.arrays import FloatArray
from mechid.designs.criterion import sizes
from mechid.designs.planned import PlannedRecord
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
    """Return the share of draws, (records,), in which a record's cost is not the quadratic that J^T J says.

    Without noise the cost of a draw d away is d^T J^T J d; it departs where it differs by more than a sigma squared.

    Parameters
    ----------
    space : SearchSpace
    records : sequence of PlannedRecord
    points : (s, n)
        Mechanisms, of which the first 8 are looked at.
    information : (s, records, n, n)
    reference : (s, n, n)
        Information whose inverse the draws are from: that of a whole test.
    seed : int
    workers : int
        Threads.
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
    return float(np.mean([_departing(problem, q, drawn[s], information[s]) for s, q in enumerate(points)]))


def _root(information: FloatArray, size: FloatArray) -> FloatArray:
    """Return a root of the inverse; no axis of it is longer than `DESIGN.farthest`, what is not known stays near by."""
    values, vectors = np.linalg.eigh(information * np.outer(size, size))
    lengths = np.minimum(1.0 / np.sqrt(np.maximum(values, 1e-300)), DESIGN.farthest)
    return np.asarray(size[:, None] * vectors * lengths, dtype=np.float64)


def _departing(problem: Problem, q: FloatArray, draws: FloatArray, information: FloatArray) -> float:
    """Return the share of draws at which the cost of the torque at `q` is not what the information on `q` promises."""
    (target,) = problem.targets
    (torque,) = problem.model.predict(target, q, target.samples)
    there = replace(target, channels=(replace(target.leading, measured=torque),))
    costs = np.square(problem.norms_at(there, list(draws), (0, target.samples)))
    promised = np.einsum("di,ij,dj->d", draws - q, information, draws - q)
    return float(np.mean(~(np.abs(costs - promised) <= ERRORS.cost_departure)))
