"""Search for missing effects: the score test proposes them one at a time, and full fits decide on each."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from mechid.identification.computation.progress import Tell
from mechid.identification.diagnosis.candidate import CandidateModel
from mechid.identification.diagnosis.steps import (
    Step,
    add_effects,
    add_hidden_laws,
    add_law,
    compute_criteria,
    drop_effects,
    exchange_effect,
    replace_imitators,
    step,
)
from mechid.identification.effects.scores import Score
from mechid.identification.effects.selection import gain, is_needed
from mechid.identification.effects.settings import IN_DIAGNOSIS as RULES
from mechid.identification.uncertainty.model_error import compare_parts
from mechid.identification.uncertainty.settings import NOISE


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Result of the search.

    Attributes
    ----------
    model : CandidateModel
        CandidateModel with all effects that are needed.
    before : CandidateModel
        The mechanism as written, or its replacement in the fit, without these effects.
    steps : tuple of Step
    tried : mapping of str to str
        Effects that were fitted and not kept, with the reason.
    needed : mapping of str to Score
        Loss of the fit without each effect.
    less : mapping of str to CandidateModel
        The model without each effect.
    like : mapping of str to tuple of str
        Effects that explain the records equally well, by the reported effect.
    refused : tuple of str
        Effects that were found but are not reported, since they may compensate for another one.
    """

    model: CandidateModel
    before: CandidateModel
    steps: tuple[Step, ...]
    tried: Mapping[str, str]
    needed: Mapping[str, Score]
    less: Mapping[str, CandidateModel]
    like: Mapping[str, tuple[str, ...]]
    refused: tuple[str, ...] = ()

    @property
    def remaining_share(self) -> float:
        """Remaining share of the misfit of the mechanism as written; 0 where the residual is within the noise."""
        within = self.model.over_noise <= NOISE.misfit and not self.refused
        return 0.0 if within else self.model.misfit / max(self.before.misfit, 1.0)

    @property
    def as_written(self) -> Step:
        """The mechanism as written, before any step."""
        return compute_criteria(self.model, [step(self.before)])[0]


def search_effects(before: CandidateModel, start: CandidateModel, say: Tell = lambda words: None) -> SearchResult:
    """Search for the effects that the data support.

    Parameters
    ----------
    before : CandidateModel
        CandidateModel without any effect.
    start : CandidateModel
        CandidateModel with the effects that the fit has already, or `before` itself.
    say : callable
        Called with each report of progress.
    """
    tried: dict[str, str] = {}
    if not start.effects:
        before = start
    elif math.isfinite(before.cost):
        # Gains are measured against the mechanism as written at its own optimum.
        before = before.fit(before)
    steps = [step(start, added=name) for name in start.effects]
    model, added = add_effects(start, tried, say)
    model, removed = drop_effects(model, say)
    model, hidden = add_hidden_laws(model, tried, say) if model.over_noise <= NOISE.misfit else (model, [])
    model, imitated = replace_imitators(model, say)
    steps = [*steps, *added, *removed, *hidden, *imitated]
    # A law in place of the mechanism's own needs fits of its own: it is tried only where terms leave a misfit.
    if model.over_noise > RULES.noise_limit:
        bare = model.keep_effects(model.disturbances) if model.disturbances and not model.laws else before
        better, law_steps = add_law(bare, model, tried, say)
        if better is not model:
            model, steps = better, law_steps
    less, needed = _gain_of_each(before, model)
    # Without one effect the others explain other shares, so each pass judges them anew.
    while small := negligible_effect(model, needed):
        tried[small] = "explains less than a hundredth of another effect's share, over the followed part of the records"
        model = model.without(small)
        steps.append(step(model, removed=small))
        less, needed = _gain_of_each(before, model)
    refused: list[str] = []
    # Removing effects changes the gain of the others, so both tests run again.
    while lost := compensating_effects(model, needed) or doubtful_effects(model, needed, less):
        refused += lost
        tried |= {name: _why_refused(needed[name].share) for name in lost}
        model = _without_all(model, lost) if len(lost) < len(needed) else before
        steps += [step(model, removed=name) for name in lost]
        less, needed = _gain_of_each(before, model)
    like = {name: tuple(_equivalent_effects(model, less[name], name)) for name in (*model.terms, *model.disturbances)}
    return SearchResult(model, before, tuple(compute_criteria(model, steps)), tried, needed, less, like, tuple(refused))


def _gain_of_each(before: CandidateModel, model: CandidateModel) -> tuple[dict[str, CandidateModel], dict[str, Score]]:
    """Return the fitted model without each of its effects, and the gain by each effect."""
    alone = len(model.effects) == 1
    less = {name: before if alone else model.without(name) for name in model.effects}
    return less, {name: gain(without, model) for name, without in less.items()}


def negligible_effect(model: CandidateModel, needed: Mapping[str, Score]) -> str:
    """Return a negligible effect of a model that follows the records in part; empty where there is none.

    Where a model loses a record, the window contains the beginning of the departure, which small effects imitate.
    """
    if model.is_of_whole_records or not needed:
        return ""
    least = min(needed, key=lambda name: needed[name].chi_square)
    most = max(score.chi_square for score in needed.values())
    return least if needed[least].chi_square < RULES.small * most else ""


def compensating_effects(model: CandidateModel, needed: Mapping[str, Score]) -> list[str]:
    """Return the effects that may compensate for another, unknown one.

    Where more than noise is left, these are the effects that explain less than half of the misfit without them. Where
    several effects explain less than half, or any effect among more than four does, all of them may imitate another
    effect together. No effect is reported below the share that is required to add one.
    """
    weak = [name for name, score in needed.items() if score.share < RULES.mostly]
    if len(weak) > RULES.few_weak or (weak and len(needed) > RULES.few):
        return list(needed)
    return weak if model.over_noise > RULES.noise_limit else [name for name in weak if needed[name].share < RULES.share]


def doubtful_effects(
    model: CandidateModel, needed: Mapping[str, Score], less: Mapping[str, CandidateModel]
) -> list[str]:
    """Return the doubtful effects: parts of the records disagree on the values with them.

    With a complete model the parts agree. With one that leaves far more than noise they need not, since it may be on a
    wrong branch. Effects that explain nearly all of the misfit are not doubtful.
    """
    if not needed or not model.over_noise <= RULES.far or _agrees(model):
        return []
    clear = {
        name for name in needed if needed[name].share >= RULES.nearly_all and less[name].over_noise > RULES.noise_limit
    }
    return [name for name in needed if name not in clear]


def _agrees(model: CandidateModel) -> bool:
    return compare_parts(model.problem, model.q, model.setting.windows).consistency.agrees


def _why_refused(share: float) -> str:
    explains = f"explains {100.0 * share:.3g} % of the misfit"
    return (
        f"{explains} only"
        if share < RULES.mostly
        else f"{explains}, but parts of the records disagree on the values with it"
    )


def _without_all(model: CandidateModel, names: Sequence[str]) -> CandidateModel:
    for law in [name for name in names if name in model.laws]:
        model = model.without(law)
    return model.keep_effects([name for name in model.effects if name not in names])


def _equivalent_effects(model: CandidateModel, less: CandidateModel, name: str) -> Iterator[str]:
    """Yield the effects that explain the records equally well in place of one, by the score test and then by a fit."""
    landscape = less.landscape
    if name not in landscape.effects:
        return
    for other in landscape.equivalent_effects(name):
        if other not in model.effects and not _holds_more(model, other, name):
            swapped = exchange_effect(model, name, other)
            if not is_needed(swapped, model):
                yield other


def _holds_more(model: CandidateModel, effect: str, other: str) -> bool:
    """Tell whether a disturbance contains another one, as a clock for each record contains one clock for all."""
    known = {one.name: one for one in model.setting.disturbances}
    if effect not in known or other not in known:
        return False
    return known[effect].overlaps(known[other]) and known[effect].dof > known[other].dof
