"""A value of the mechanism file that is wrong by more than catalogues are: looked for far beyond it, told, never taken.

With an inertia in g cm2 for kg m2, or with bounds without the true value, no start explains even the first moments of
the records. Then each such value is looked for by itself, a thousand times further either way. The one that is wrong
explains them from there; the others, which make up for it, do not.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

from mechid.identification.computation.journal import Journal
from mechid.identification.computation.parallel import mapped
from mechid.identification.contradiction.agreement import explains
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.search.multistart import Candidate, multistart, refine
from mechid.identification.search.settings import SEARCH
from mechid.parameter import Parameter, Status

FURTHER = 1e3
"""Times the value, either way, up to which it is looked for: units are wrong by a hundred or a thousand."""
UNDECIDED = 10.0
"""Times as much as the best value leaves of the first moments, up to which another one is told of beside it. The others
left some 50 times as much at least in the two campaigns of docs/identification.md that were looked at."""


@dataclass(frozen=True)
class WrongValue:
    """A parameter whose value in the file, or whose bounds, no start explains, and the value with which one does."""

    parameter: Parameter
    found: float
    cost: float

    @property
    def words(self) -> str:
        """A sentence on where it is found, and what the file has."""
        q, unit = self.parameter, self.parameter.declaration.unit
        declared = f"between {q.min:.4g} and {q.max:.4g}" if q.is_free else f"{q.value:.4g}"
        return (
            f"With the values and bounds of the mechanism file no start explains the first "
            f"{SEARCH.first_window_s * 1e3:g} ms of the records; "
            f"with {q.name} at about {self.found:.3g} {unit} ({declared} in the file) one does."
        )


def wrong_values(
    problem: Problem, seed: int, tell: Callable[[str], None], journal: Journal | None = None
) -> list[WrongValue]:
    """Return the values of the mechanism file that stand in the way, the likeliest first; mostly none or one.

    Parameters
    ----------
    problem : Problem
        Of which no start within the file's bounds explains the first moments.
    seed : int
    tell : callable
        Called with the name of each parameter that is looked at.
    journal : Journal or None
        Of the starts, where a run is to be resumed.
    """
    found: list[WrongValue] = []
    for parameter in filter(_may_be_wrong, problem.space.mechanism.parameters.values()):
        tell(parameter.name)
        other = _looking_for(problem, parameter)
        starts = multistart(other, seed, other.workers, journal=journal)[: SEARCH.batch]
        refined = mapped(partial(refine, other, steps=SEARCH.robust_steps), starts, other.workers)
        best = min(refined, key=lambda c: c.cost, default=Candidate(other.start, math.inf))
        value = other.space.values(other.coordinates.of_mechanism(best.q))[parameter.name]
        if explains(other, best) and _is_beyond(parameter, value):
            found.append(WrongValue(parameter, value, best.cost))
    least = min((one.cost for one in found), default=math.inf)
    return sorted((one for one in found if one.cost <= UNDECIDED * least), key=lambda one: one.cost)


def _may_be_wrong(q: Parameter) -> bool:
    """Tell whether a parameter has a unit to be wrong in, and a size to be off by a factor."""
    d = q.declaration
    plain = not (d.structural or q.tied_to or (d.typical and q.is_free))
    return plain and d.unit not in ("1", "deg", "rad") and q.value > 0.0 and d.lower >= 0.0


def _looking_for(problem: Problem, q: Parameter) -> Problem:
    """Return the problem in which a parameter lies anywhere in a wide range about its value, evenly by factors."""
    d = q.declaration
    wide = replace(
        q,
        declaration=replace(d, spread=FURTHER, typical=None),
        min=max(q.value / FURTHER, d.lower),
        max=min(q.value * FURTHER, d.upper),
        status=Status.FREE,
    )
    priors = {name: prior for name, prior in problem.priors.items() if name != q.name}
    space = SearchSpace(problem.space.mechanism.with_parameters({q.name: wide}))
    return replace(problem, space=space, priors=priors)


def _is_beyond(q: Parameter, value: float) -> bool:
    """Tell whether a value is beyond what the file allows, or beyond what catalogues err by."""
    if q.is_free:
        return not q.min <= value <= q.max
    return abs(math.log(value / q.value)) > math.log(q.declaration.spread)
