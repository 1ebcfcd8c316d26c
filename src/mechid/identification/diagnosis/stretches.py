"""Effects found as far as the records are followed: growth that asks what is missing where it stalls.

Where a mechanism lacks two effects at once, or a law, a fit of whole records ends on a wrong branch of stick and slip,
and what it leaves is that of the branch. The first moments have none: there the score test, and a few steps of a fit
with each law, name what is missing; with it the growth goes on to where the next effect shows.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mechid.identification.diagnosis.candidate import FOLLOWED, Model
from mechid.identification.diagnosis.steps import Told, grown, pruned
from mechid.identification.diagnosis.with_laws import with_a_law
from mechid.identification.search.gates import Growth, grow
from mechid.identification.search.multistart import candidates, multistart

ESCAPES = 1
"""Of a growth before anything is asked for: what is missing stops it again."""
PATIENT = 8
"""Of a growth of a model that leaves no more than noise as far as it follows: then it is a branch that stops it."""
ROUNDS = 12
FURTHER = 1.001
"""Times as much of the records as before, from which a round has led further."""


def in_stretches(before: Model, told: Told) -> Model | None:
    """Return a model that follows all records, with the effects found on the way; None where none does.

    Parameters
    ----------
    before : Model
        The mechanism as written; its values do not count, since a wrong branch may have drawn them away.
    told : callable
        Told of progress.
    """
    begun = _from_best_start(before)
    if begun is None:
        return None
    model, growth = _followed(begun, before, ESCAPES)
    for _ in range(ROUNDS):
        reached = growth.reached(model.problem)
        told(f"{100.0 * reached:.1f} % of the records followed with {', '.join(model.effects) or 'nothing beside'}")
        if growth.complete:
            return model.fitted(model)
        asked = _with_what_is_missing(model.within(growth.horizons), told)
        same = {*asked.effects} == {*model.effects}
        model, growth = _followed(asked, before, PATIENT if same else ESCAPES)
        if same and growth.reached(model.problem) <= FURTHER * reached:
            return None
    return None


def _from_best_start(before: Model) -> Model | None:
    """Return the mechanism as written at the best of all starts by the first moments; None where none is simulated."""
    problem = before.problem
    anchored = problem.anchored
    starts = multistart(anchored, 0, problem.workers)
    best = next(candidates(anchored, starts, problem.workers), None)
    return replace(before, q=problem.lifted(anchored, best.q, problem.start)) if best else None


def _followed(model: Model, before: Model, escapes: int) -> tuple[Model, Growth]:
    """Return a model where it follows the whole records furthest, from where it is, and how far that is."""
    whole = replace(model, setting=replace(model.setting, windows=before.setting.windows))
    growth = grow(whole.problem, whole.q, np.random.default_rng(0), escapes=escapes)
    return replace(whole, q=growth.q), growth


def _with_what_is_missing(model: Model, told: Told) -> Model:
    """Return the model fitted, with the effects that its windows ask for if it leaves more than noise in them."""
    model = model.fitted(model)
    if model.over_noise <= FOLLOWED:
        return model
    tried: dict[str, str] = {}
    more, _ = pruned(grown(model, tried, told)[0], told)
    return more if more.over_noise <= FOLLOWED else with_a_law(model, more, tried, told)[0]
