"""Search for missing effects during growth, over the part of the records that the model follows.

Where a mechanism lacks two effects at once, or a law, a fit of whole records ends on a wrong branch of stick and slip,
and its residual is that of the branch. The first moments have no such branch. There the score test, and a few steps of
a fit with each law, identify the missing effect; with it the growth continues to where the next effect shows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial

import numpy as np

from mechid.identification.computation.progress import Tell
from mechid.identification.diagnosis.candidate import CandidateModel
from mechid.identification.diagnosis.steps import add_effects, add_law, drop_effects, exchanged_models
from mechid.identification.effects.selection import add_likeliest
from mechid.identification.effects.settings import IN_DIAGNOSIS as RULES
from mechid.identification.search.gates import Growth, grow_horizons
from mechid.identification.search.horizons import followed_samples, least_horizons
from mechid.identification.search.multistart import best_start
from mechid.identification.uncertainty.noise_levels import noise_levels
from mechid.plant.superset import rivals_of


def search_by_growth(before: CandidateModel, say: Tell) -> CandidateModel | None:
    """Search for effects while growing to the records' ends, or as far as a model follows them.

    Returns None where no model follows enough of the records to separate effects.

    Parameters
    ----------
    before : CandidateModel
        The mechanism as written; its values are ignored, since they may belong to a wrong branch.
    say : callable
        Called with each report of progress.
    """
    initial = _move_to_best_start(before)
    if initial is None:
        return None
    model, growth = _grow_model(initial, before, RULES.first_escapes)
    # The starts are slow and do not depend on the round.
    laws = cache(partial(_alternative_laws, before, say))
    for _ in range(RULES.rounds):
        percent = 100.0 * growth.followed_share(model.problem)
        say(f"{percent:.1f} % of the records followed with {', '.join(model.effects) or 'nothing added'}")
        if growth.complete:
            return model.fit(model)
        attempts = (
            _grow_model(*each) for each in _attempts(model.restrict_windows(growth.horizons), before, laws, say)
        )
        further = next((each for each in attempts if _leads_further(*each, model, growth)), None)
        if further is None:
            break
        model, growth = further
    part = model.restrict_windows(growth.horizons)
    return part.fit(part) if growth.followed_share(model.problem) > RULES.enough and model.effects else None


def _leads_further(model: CandidateModel, growth: Growth, other: CandidateModel, known: Growth) -> bool:
    """Tell whether a model follows the records further than another one of known growth, at the same noise levels."""
    # A lower level ends growth earlier: shares are comparable only at the same levels.
    same = noise_levels(model.problem) == noise_levels(other.problem)
    before = known.followed_share(other.problem) if same else followed_share(other.at_levels(model.problem))
    return growth.complete or growth.followed_share(model.problem) > RULES.further * before


def followed_share(model: CandidateModel) -> float:
    """Return the share of all samples that a model follows at its point."""
    problem = model.problem
    least = least_horizons(problem)
    reached = sum(max(followed_samples(problem, t, model.q), least[t.name]) for t in problem.targets)
    return reached / sum(t.samples for t in problem.targets)


def _alternative_laws(before: CandidateModel, say: Tell) -> list[CandidateModel]:
    """Return models with one alternative law each, at its best start, in the order of the cost of first moments."""
    found = []
    laws = {law.name: law for law in rivals_of(before.base, grown_only=True)}  # a law's sizes have one box
    for law in [law for name, law in laws.items() if name in before.setting.considered]:
        say(f"starts with {law.name}")
        initial = _move_to_best_start(before.use_law(law, law.mechanism))
        found += [initial] if initial else []
    return sorted(found, key=lambda one: one.cost)


def _move_to_best_start(before: CandidateModel) -> CandidateModel | None:
    """Return a model at the best of all starts, with its cost there; None where no start can be simulated."""
    problem = before.problem
    anchored = problem.rest_problem
    best = best_start(anchored, 0)
    return replace(before, q=problem.point_from(anchored, best.q), cost=best.cost) if best else None


def _grow_model(model: CandidateModel, before: CandidateModel, escapes: int) -> tuple[CandidateModel, Growth]:
    """Grow a model over the whole records from its point; return the model there and its growth.

    Noise levels are lowered to the residual. A stretch that was followed at higher levels may then be lost, and the
    growth runs again.
    """
    whole = replace(model, setting=replace(model.setting, windows=before.setting.windows))
    for _ in range(RULES.lowered):
        growth = grow_horizons(whole.problem, whole.q, np.random.default_rng(0), escapes=escapes)
        whole = replace(whole, q=growth.q)
        quieter = whole.restrict_windows(growth.horizons).lower_levels()
        if quieter.setting.problem is whole.setting.problem:
            break
        whole = replace(whole, setting=replace(quieter.setting, windows=before.setting.windows))
    return whole, growth


def _attempts(
    model: CandidateModel, before: CandidateModel, laws: Callable[[], list[CandidateModel]], say: Tell
) -> Iterator[tuple[CandidateModel, CandidateModel, int]]:
    """Yield models that may follow the records further, as arguments of `_grow_model`: with terms, then with laws.

    Terms are added one by one. Each one may be the last missing one, and a further one would only explain the residual
    of a wrong branch. Where the residual is at the noise level, terms are exchanged, since terms that explain a stretch
    equally well do not follow the records equally far. Laws come after terms, since each needs a kernel and a fit of
    its own: first from the model's point, then from their own starts. The model itself is grown with more escapes
    after the first law.
    """
    here, tried = model.fit(model), dict[str, str]()
    more = here
    while (better := add_likeliest(more, tried, say)) is not None:
        more = better
        yield more, before, 0
    more, _ = drop_effects(add_effects(more, tried, say)[0], say)
    if {*more.effects} != {*here.effects}:
        yield more, before, RULES.first_escapes
    if more.over_noise <= RULES.noise_limit:
        yield from ((other, before, RULES.first_escapes) for other in exchanged_models(more, say))
    # A second missing law is rarer than a wrong branch.
    if model.laws:
        yield more, before, RULES.patient_escapes
    with_law, _ = add_law(here, more, tried, say)
    if with_law is not more:
        yield with_law, before, RULES.first_escapes
    if model.laws:
        return
    if model.share < RULES.enough:
        yield from ((law, before, 0) for law in laws())
    yield more, before, RULES.patient_escapes
