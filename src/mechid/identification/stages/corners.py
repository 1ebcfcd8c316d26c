"""Singular corners: where one parameter has come to its least, no record sees another one any longer.

Static friction that a fit has brought down to Coulomb friction leaves the speed over which the one falls to the other
without effect, so that no derivative leads back. The fit then begins again from beside the corner.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.identifiability.verdict import seen_coordinates
from mechid.identification.output_error.problem import Problem
from mechid.identification.search.settings import SEARCH
from mechid.identification.search.solve import Solution
from mechid.identification.stages.settings import STAGES


def out_of_corner(problem: Problem, stopped: Solution, solved: Callable[[FloatArray], Solution]) -> Solution:
    """Return the best of what a fit comes to that stopped in a corner, and of others begun beside it.

    `solved` fits from a point. Where `stopped` is in no corner, that is the answer, and nothing is fitted.
    """
    best = stopped
    for q in _beside(problem, stopped):
        found = solved(q)
        if found.triangle.cost < best.triangle.cost - SEARCH.notable_fall:
            best = found
    return best


def _beside(problem: Problem, stopped: Solution) -> Iterator[FloatArray]:
    """Yield the points beside each corner that a solution is in."""
    space, q = problem.space, stopped.q
    at, values = problem.coordinates.of_mechanism(q), problem.space.values(problem.coordinates.of_mechanism(q))
    seen = seen_coordinates(problem, stopped.triangle)
    unseen = [c.name for c, sees in zip(space.coordinates, seen, strict=False) if not sees and space.stands_alone(c)]
    for c, excess in zip(space.coordinates, at, strict=True):
        hidden = [name for name in unseen if _table(name) == _table(c.name)]
        if c.kind != "excess" or excess > STAGES.corner_share * abs(values[c.below]) or not hidden:
            continue
        known = space.mechanism.parameters
        lowered = {c.below: STAGES.lowered * values[c.name]} if known[c.below].is_free else {}
        for factor in STAGES.spread:
            moved = {name: factor * known[name].value for name in hidden}
            begun = space.from_values({n: p.value for n, p in known.items()} | values | lowered | moved)
            yield np.concatenate([begun, problem.coordinates.of_records(q)])


def _table(name: str) -> str:
    return name.rpartition(".")[0]
