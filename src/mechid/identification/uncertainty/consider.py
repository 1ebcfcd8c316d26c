"""What the uncertainty of parameters held for a dependence adds to the covariance of the others.

Consider covariance: an error c of a held parameter moves the estimate by -P J^T J_c c, with P the covariance of the
estimated ones, J their derivatives and J_c that of the held one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.result.search_state import Frozen
from mechid.parameter import Status


def consider_covariance(
    problem: Problem, q: FloatArray, windows: Windows, held: Sequence[Frozen], names: Sequence[str], white: FloatArray
) -> FloatArray:
    """Return what the held parameters' sigmas add, (k, k), in the file's coordinates and units.

    Parameters
    ----------
    problem : Problem
        In which they are held.
    q : (n,)
    windows : mapping of record to (first, stop)
    held : sequence of Frozen
        Those without sigma add nothing.
    names : sequence of str, (k,)
        The estimated parameters.
    white : (k, k)
        Their covariance, in the file's coordinates and units.
    """
    total = np.zeros_like(white)
    for parameter in held:
        if parameter.sigma:
            moved = _moved_by(problem, q, windows, parameter.name, names, white) * parameter.sigma
            total += np.outer(moved, moved)
    return total


def _moved_by(
    problem: Problem, q: FloatArray, windows: Windows, held: str, names: Sequence[str], white: FloatArray
) -> FloatArray:
    """Return how far the estimates move for each unit of the held parameter, (k,)."""
    mechanism = problem.space.at(q[: problem.space.size])
    pairs = {name: p.amplitude for p in mechanism.plant.polar_pairs for name in (p.amplitude, p.phase)}
    polar = problem.space.polar | ({pairs[held]} if held in pairs else frozenset())
    freed = replace(mechanism.parameters[held], status=Status.FREE)
    wider = replace(problem, space=SearchSpace(mechanism.with_parameters({held: freed}), polar))
    here = np.concatenate([wider.space.start, q[problem.space.size :]])
    every, slopes = wider.coordinates.value_slopes(here)
    by_file = wider.joint(here, windows).jacobian @ np.linalg.pinv(slopes)
    J, J_c = by_file[:, [every.index(n) for n in names]], by_file[:, every.index(held)]
    return np.asarray(-white @ (J.T @ J_c), dtype=np.float64)
