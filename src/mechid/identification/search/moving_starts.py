"""Records that begin in motion and are not followed, begun anew: each by its own start alone, the mechanism held."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.search.run_up import gone_on, run_up
from mechid.identification.search.settings import SEARCH

Horizons = dict[str, int]
Rounds = Callable[[Problem, FloatArray, Horizons], tuple[FloatArray, Horizons]]
"""Where growth from a point and its horizons leads, and the horizons there."""


Lifted = Callable[[FloatArray, Horizons], tuple[FloatArray, Horizons]]
"""From a point of a part of the records, and horizons there, to all of them."""


def after_those_at_rest(
    problem: Problem,
    q: FloatArray,
    least: Horizons,
    grow_part: Callable[[Problem, FloatArray, Lifted], tuple[FloatArray, Horizons]],
    rounds: Rounds,
) -> FloatArray:
    """Return where the records that begin at rest lead, and from there each that begins in motion by its start alone.

    A start that is free explains the first moments with nearly any mechanism: in a short gate both go astray together.

    Parameters
    ----------
    problem : Problem
    q : (n,)
    least : dict of str to int
        Least horizon of each record, samples.
    grow_part : callable
        Grows the horizons of a part of the records from a point of it.
    rounds : callable
        As of `begun_anew`.
    """
    part = problem.anchored
    names = [t.name for t in part.targets]
    own = part.coordinates.records_point(problem.coordinates.values(q))

    def lifted(moved: FloatArray, gates: Horizons) -> tuple[FloatArray, Horizons]:
        return problem.lifted(part, moved, q), {**least, **gates}

    found = grow_part(part, np.concatenate([part.coordinates.of_mechanism(q), own]), lifted)
    moving = [t for t in problem.targets if t.name not in names]
    return begun_anew(problem, *lifted(*found), rounds, targets=moving)


def begun_anew(
    problem: Problem, q: FloatArray, gates: Horizons, rounds: Rounds, *, targets: Sequence[Target]
) -> FloatArray:
    """Return a point at which records are followed further by another start of theirs; the same one where none is.

    Parameters
    ----------
    problem : Problem
    q : (n,)
    gates : dict of str to int
        How far each is followed, samples.
    rounds : callable
        Grows the horizon of one of them with nothing but its start free.
    targets : sequence of Target
        Those that are not followed to their ends, in the order in which they are tried.
    """
    for target in targets:
        for point in (gone_on(problem, q, target), run_up(problem, q, targets=[target], tries=SEARCH.run_up_tries)):
            if point is None or np.array_equal(point, q):
                continue
            moved, reached = _by_its_start(problem, target, point, gates[target.name], rounds)
            if reached > gates[target.name]:
                q = moved
                break
    return q


def _by_its_start(problem: Problem, target: Target, q: FloatArray, gate: int, rounds: Rounds) -> tuple[FloatArray, int]:
    """Return a point after the horizon of one record has grown with nothing but its start free, and that horizon."""
    alone = problem.only([target.name]).with_mechanism_held(q)
    own = [n for n, name in enumerate(problem.coordinates.names) if name in alone.coordinates.own_names]
    at, gates = rounds(alone, q[own], {target.name: gate})
    moved = q.copy()
    moved[own] = at
    return moved, gates[target.name]
