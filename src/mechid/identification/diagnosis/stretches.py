"""Effects found as far as the records are followed: growth that asks what is missing where it stalls.

Where a mechanism lacks two effects at once, or a law, a fit of whole records ends on a wrong branch of stick and slip,
and what it leaves is that of the branch. The first moments have none: there the score test, and a few steps of a fit
with each law, name what is missing; with it the growth goes on to where the next effect shows.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mechid.identification.computation.progress import Tell
from mechid.identification.diagnosis.candidate import FOLLOWED, Model
from mechid.identification.diagnosis.steps import exchanges, grown, pruned
from mechid.identification.diagnosis.with_laws import with_a_law
from mechid.identification.search.gates import Growth, floors, followed, grow
from mechid.identification.search.multistart import candidates, multistart

ESCAPES = 1
"""Of a growth before anything is asked for: what is missing stops it again."""
PATIENT = 8
"""Of a growth of a model that leaves no more than noise as far as it follows: then it is a branch that stops it; a
choice, not measured."""
ROUNDS = 12
"""Of growth and a further term at most. A choice, not measured."""
QUIETER = 4
"""Times that noise levels are lowered by one growth at most. Levels of benches with backlash stood 1.2 to 2 times
too high (docs/diagnosis.md)."""
ENOUGH = 0.3
"""Share of the records from which on effects are named: in less of them many imitate one another; a choice, not
measured."""
FURTHER = 1.001
"""Times as much of the records as before, from which a round has led further; a choice, not measured."""


def in_stretches(before: Model, told: Tell) -> Model | None:
    """Return a model with the effects found on the way to the records' ends, or as far as it follows them.

    None where no model follows enough of the records for effects to be told apart.

    Parameters
    ----------
    before : Model
        The mechanism as written; its values do not count, since a wrong branch may have drawn them away.
    told : callable
        Called with each report of progress.
    """
    begun = _from_best_start(before)
    if begun is None:
        return None
    model, growth = _followed(begun, before, ESCAPES)
    for _ in range(ROUNDS):
        told(f"{_percent(model, growth)} of the records followed with {', '.join(model.effects) or 'nothing beside'}")
        if growth.complete:
            return model.fitted(model)
        attempts = (_followed(*each) for each in _attempts(model.within(growth.horizons), before, told))
        further = next((each for each in attempts if _leads_further(*each, model)), None)
        if further is None:
            break
        model, growth = further
    part = model.within(growth.horizons)
    return part.fitted(part) if growth.reached(model.problem) > ENOUGH and model.effects else None


def _percent(model: Model, growth: Growth) -> str:
    return f"{100.0 * growth.reached(model.problem):.1f} %"


def _leads_further(model: Model, growth: Growth, other: Model) -> bool:
    """Tell whether a model follows the records further than another does at the same noise levels."""
    return growth.reached(model.problem) > FURTHER * reach(other.at_levels(model.problem))


def reach(model: Model) -> float:
    """Return the share of all samples that a model follows where it is."""
    problem = model.problem
    least = floors(problem)
    reached = sum(max(followed(problem, t, model.q), least[t.name]) for t in problem.targets)
    return reached / sum(t.samples for t in problem.targets)


def _from_best_start(before: Model) -> Model | None:
    """Return the mechanism as written at the best of all starts by the first moments; None where none is simulated."""
    problem = before.problem
    anchored = problem.anchored
    starts = multistart(anchored, 0, problem.workers)
    best = next(candidates(anchored, starts, problem.workers), None)
    return replace(before, q=problem.lifted(anchored, best.q, problem.start)) if best else None


def _followed(model: Model, before: Model, escapes: int) -> tuple[Model, Growth]:
    """Return a model where it follows the whole records furthest, from where it is, and how far that is.

    With noise levels lowered to what it leaves of them: what was followed at higher ones may be lost, and found anew.
    """
    whole = replace(model, setting=replace(model.setting, windows=before.setting.windows))
    for _ in range(QUIETER):
        growth = grow(whole.problem, whole.q, np.random.default_rng(0), escapes=escapes)
        whole = replace(whole, q=growth.q)
        quieter = whole.within(growth.horizons).lowered()
        if quieter.setting.problem is whole.setting.problem:
            break
        whole = replace(whole, setting=replace(quieter.setting, windows=before.setting.windows))
    return whole, growth


def _attempts(model: Model, before: Model, told: Tell) -> Iterator[tuple[Model, Model, int]]:
    """Yield what may follow the records further, as `_followed` wants it: with terms, then with laws.

    Laws come last, since each is a kernel and a fit of its own. A model that leaves no more than noise lacks nothing;
    but terms that explain a stretch alike do not follow the records equally far.
    """
    here, tried = model.fitted(model), dict[str, str]()
    more = here
    if here.over_noise > FOLLOWED:
        more, _ = pruned(grown(here, tried, told)[0], told)
        if {*more.effects} != {*here.effects}:
            yield more, before, ESCAPES
    if more.over_noise > FOLLOWED:
        yield with_a_law(here, more, tried, told)[0], before, ESCAPES
    else:
        yield from ((other, before, ESCAPES) for other in exchanges(more, told))
    yield more, before, PATIENT
