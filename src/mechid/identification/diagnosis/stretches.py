"""Effects found as far as the records are followed: growth that asks what is missing where it stalls.

Where a mechanism lacks two effects at once, or a law, a fit of whole records ends on a wrong branch of stick and slip,
and what it leaves is that of the branch. The first moments have none: there the score test, and a few steps of a fit
with each law, name what is missing; with it the growth goes on to where the next effect shows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial

import numpy as np

from mechid.identification.computation.progress import Tell
from mechid.identification.diagnosis.candidate import Model
from mechid.identification.diagnosis.steps import add_effects, add_law, drop_effects, exchanged_models
from mechid.identification.effects.selection import add_likeliest
from mechid.identification.effects.settings import IN_DIAGNOSIS as RULES
from mechid.identification.search.gates import Growth, grow_horizons
from mechid.identification.search.horizons import followed_samples, least_horizons
from mechid.identification.search.multistart import best_start
from mechid.identification.uncertainty.noise_levels import noise_levels
from mechid.plant.superset import rivals_of


def in_stretches(before: Model, say: Tell) -> Model | None:
    """Return a model with the effects found on the way to the records' ends, or as far as it follows them.

    None where no model follows enough of the records for effects to be told apart.

    Parameters
    ----------
    before : Model
        The mechanism as written; its values do not count, since a wrong branch may have drawn them away.
    say : callable
        Called with each report of progress.
    """
    begun = _from_best_start(before)
    if begun is None:
        return None
    model, growth = _followed(begun, before, RULES.first_escapes)
    laws = cache(partial(_alternative_laws, before, say))  # their starts take long, and do not depend on the round
    for _ in range(RULES.rounds):
        percent = 100.0 * growth.followed_share(model.problem)
        say(f"{percent:.1f} % of the records followed with {', '.join(model.effects) or 'nothing added'}")
        if growth.complete:
            return model.fitted(model)
        attempts = (_followed(*each) for each in _attempts(model.within(growth.horizons), before, laws, say))
        further = next((each for each in attempts if _leads_further(*each, model, growth)), None)
        if further is None:
            break
        model, growth = further
    part = model.within(growth.horizons)
    return part.fitted(part) if growth.followed_share(model.problem) > RULES.enough and model.effects else None


def _leads_further(model: Model, growth: Growth, other: Model, known: Growth) -> bool:
    """Tell whether a model follows the records further than another does, of which it is known, at the same levels."""
    same = noise_levels(model.problem) == noise_levels(other.problem)
    before = known.followed_share(other.problem) if same else reach(other.at_levels(model.problem))
    return growth.complete or growth.followed_share(model.problem) > RULES.further * before


def reach(model: Model) -> float:
    """Return the share of all samples that a model follows where it is."""
    problem = model.problem
    least = least_horizons(problem)
    reached = sum(max(followed_samples(problem, t, model.q), least[t.name]) for t in problem.targets)
    return reached / sum(t.samples for t in problem.targets)


def _alternative_laws(before: Model, say: Tell) -> list[Model]:
    """Return models with one law each, at the best of its own starts; the likeliest by the first moments first."""
    found = []
    laws = {law.name: law for law in rivals_of(before.base, grown_only=True)}  # a law's sizes have one box
    for law in [law for name, law in laws.items() if name in before.setting.considered]:
        say(f"starts with {law.name}")
        begun = _from_best_start(before.in_place_of(law, law.mechanism))
        found += [begun] if begun else []
    return sorted(found, key=lambda one: one.cost)


def _from_best_start(before: Model) -> Model | None:
    """Return a model at the best of all starts, with the cost that it has there; None where none can be simulated."""
    problem = before.problem
    anchored = problem.rest_problem
    best = best_start(anchored, 0)
    return replace(before, q=problem.point_from(anchored, best.q), cost=best.cost) if best else None


def _followed(model: Model, before: Model, escapes: int) -> tuple[Model, Growth]:
    """Return a model where it follows the whole records furthest, from where it is, and how far that is.

    With noise levels lowered to what it leaves of them: what was followed at higher ones may be lost, and found anew.
    """
    whole = replace(model, setting=replace(model.setting, windows=before.setting.windows))
    for _ in range(RULES.lowered):
        growth = grow_horizons(whole.problem, whole.q, np.random.default_rng(0), escapes=escapes)
        whole = replace(whole, q=growth.q)
        quieter = whole.within(growth.horizons).lowered()
        if quieter.setting.problem is whole.setting.problem:
            break
        whole = replace(whole, setting=replace(quieter.setting, windows=before.setting.windows))
    return whole, growth


def _attempts(
    model: Model, before: Model, laws: Callable[[], list[Model]], say: Tell
) -> Iterator[tuple[Model, Model, int]]:
    """Yield what may follow the records further, as `_followed` wants it: with one term after another, then with laws.

    Each term may be the last one that is missing: further ones would explain what a branch that it leads away from
    has left. Where a model leaves no more than noise terms are exchanged: those that explain a stretch alike do not
    follow the records equally far. Laws come behind terms, since each is a kernel and a fit of its own, first from
    where the model is, then from starts of their own. The model itself is grown more patiently behind the first law.
    """
    here, tried = model.fitted(model), dict[str, str]()
    more = here
    while (better := add_likeliest(more, tried, say)) is not None:
        more = better
        yield more, before, 0
    more, _ = drop_effects(add_effects(more, tried, say)[0], say)
    if {*more.effects} != {*here.effects}:
        yield more, before, RULES.first_escapes
    if more.over_noise <= RULES.followed:
        yield from ((other, before, RULES.first_escapes) for other in exchanged_models(more, say))
    if model.laws:  # a second one is rarer than a branch
        yield more, before, RULES.patient_escapes
    with_law, _ = add_law(here, more, tried, say)
    if with_law is not more:
        yield with_law, before, RULES.first_escapes
    if model.laws:
        return
    if model.share < RULES.enough:
        yield from ((law, before, 0) for law in laws())
    yield more, before, RULES.patient_escapes
