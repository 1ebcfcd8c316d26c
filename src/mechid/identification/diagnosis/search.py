"""Which effects the records ask for: added one at a time where the score test asks for them, each kept by real fits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from mechid.identification.computation.progress import Tell
from mechid.identification.diagnosis.candidate import Model
from mechid.identification.diagnosis.steps import (
    Step,
    add_effects,
    add_hidden_laws,
    add_law,
    drop_effects,
    exchange_effect,
    replace_imitators,
    step,
    with_criteria,
)
from mechid.identification.effects.scores import Score
from mechid.identification.effects.selection import gain, is_needed
from mechid.identification.effects.settings import IN_DIAGNOSIS as RULES
from mechid.identification.uncertainty.model_error import compare_parts
from mechid.identification.uncertainty.settings import NOISE


@dataclass(frozen=True, eq=False)
class Found:
    """Where the search has ended.

    Attributes
    ----------
    model : Model
        With all effects that are needed.
    before : Model
        The mechanism as written, or what the fit had instead, without any of them.
    steps : tuple of Step
    tried : mapping of str to str
        Effects that were fitted and not kept, with why.
    needed : mapping of str to Score
        What the fit loses without each effect.
    less : mapping of str to Model
        The model without each effect.
    like : mapping of str to tuple of str
        Effects that explain the same as well, by that which is named.
    refused : tuple of str
        Effects that were found and are not named, since they may stand for something else.
    """

    model: Model
    before: Model
    steps: tuple[Step, ...]
    tried: Mapping[str, str]
    needed: Mapping[str, Score]
    less: Mapping[str, Model]
    like: Mapping[str, tuple[str, ...]]
    refused: tuple[str, ...] = ()

    @property
    def left(self) -> float:
        """Share of the misfit of the mechanism as written that is left; 0 where what is left is within the noise."""
        within = self.model.over_noise <= NOISE.misfit and not self.refused
        return 0.0 if within else self.model.misfit / max(self.before.misfit, 1.0)

    @property
    def as_written(self) -> Step:
        """The mechanism as written, before any step."""
        return with_criteria(self.model, [step(self.before)])[0]


def searched(before: Model, start: Model, say: Tell = lambda words: None) -> Found:
    """Return the effects that the records ask for.

    Parameters
    ----------
    before : Model
        Without any effect.
    start : Model
        Where to begin: with the effects that the fit has already, or `before` itself.
    say : callable
        Called with each report of progress.
    """
    tried: dict[str, str] = {}
    if not start.effects:
        before = start
    elif math.isfinite(before.cost):
        before = before.fitted(before)
    steps = [step(start, added=name) for name in start.effects]
    model, added = add_effects(start, tried, say)
    model, removed = drop_effects(model, say)
    model, hidden = add_hidden_laws(model, tried, say) if model.over_noise <= NOISE.misfit else (model, [])
    model, imitated = replace_imitators(model, say)
    steps = [*steps, *added, *removed, *hidden, *imitated]
    if model.over_noise > RULES.followed:
        bare = model.keeping(model.disturbances) if model.disturbances and not model.laws else before
        better, law_steps = add_law(bare, model, tried, say)
        if better is not model:
            model, steps = better, law_steps
    less, needed = _needed(before, model)
    while small := small_in_part(model, needed):
        tried[small] = "explains less than a hundredth of what another effect does, where the records are followed"
        model = model.without(small)
        steps.append(step(model, removed=small))
        less, needed = _needed(before, model)
    refused: list[str] = []
    while lost := standing_in(model, needed) or in_doubt(model, needed, less):
        refused += lost
        tried |= {name: _why_refused(needed[name].share) for name in lost}
        model = _without_all(model, lost) if len(lost) < len(needed) else before
        steps += [step(model, removed=name) for name in lost]
        less, needed = _needed(before, model)
    like = {name: tuple(_alike(model, less[name], name)) for name in (*model.terms, *model.disturbances)}
    return Found(model, before, tuple(with_criteria(model, steps)), tried, needed, less, like, tuple(refused))


def _needed(before: Model, model: Model) -> tuple[dict[str, Model], dict[str, Score]]:
    """Return the model without each of its effects, fitted, and what it explains beyond that."""
    alone = len(model.effects) == 1
    less = {name: before if alone else model.without(name) for name in model.effects}
    return less, {name: gain(without, model) for name, without in less.items()}


def small_in_part(model: Model, needed: Mapping[str, Score]) -> str:
    """Return the least effect that is not worth its name where records are followed in part; empty where there is none.

    Where a model loses a record the windows hold the beginning of that, which small effects imitate.
    """
    if model.is_of_whole_records or not needed:
        return ""
    least = min(needed, key=lambda name: needed[name].chi_square)
    most = max(score.chi_square for score in needed.values())
    return least if needed[least].chi_square < RULES.small * most else ""


def standing_in(model: Model, needed: Mapping[str, Score]) -> list[str]:
    """Return the effects that may stand for something else.

    Where more than noise is left, those that take less than half of what a model without them leaves. Where many
    effects share what there is to explain, so that several take less than half, or some of more than four: all, since
    they imitate it together. Nothing is named for less than the share for which nothing is added.
    """
    weak = [name for name, score in needed.items() if score.share < RULES.mostly]
    if len(weak) > RULES.few_weak or (weak and len(needed) > RULES.few):
        return list(needed)
    return weak if model.over_noise > RULES.followed else [name for name in weak if needed[name].share < RULES.share]


def in_doubt(model: Model, needed: Mapping[str, Score], less: Mapping[str, Model]) -> list[str]:
    """Return the effects that may stand for something else since parts of the records disagree on the values with them.

    With a model that lacks nothing they agree; with one that leaves far more than noise they need not, since it may be
    on a wrong branch. Those stay that take nearly all of what is beyond noise.
    """
    if not needed or not model.over_noise <= RULES.far or _agrees(model):
        return []
    clear = {
        name for name in needed if needed[name].share >= RULES.nearly_all and less[name].over_noise > RULES.followed
    }
    return [name for name in needed if name not in clear]


def _agrees(model: Model) -> bool:
    return compare_parts(model.problem, model.q, model.setting.windows).consistency.agrees


def _why_refused(share: float) -> str:
    explains = f"explains {100.0 * share:.3g} % of the misfit"
    return (
        f"{explains} only"
        if share < RULES.mostly
        else f"{explains}, yet parts of the records disagree on the values with it"
    )


def _without_all(model: Model, names: Sequence[str]) -> Model:
    for law in [name for name in names if name in model.laws]:
        model = model.without(law)
    return model.keeping([name for name in model.effects if name not in names])


def _alike(model: Model, less: Model, name: str) -> Iterator[str]:
    """Yield the effects that do as well in place of one, by the score test first and then by a fit."""
    landscape = less.landscape()
    if name not in landscape.effects:
        return
    for other in landscape.equivalent_effects(name):
        if other not in model.effects and not _holds_more(model, other, name):
            swapped = exchange_effect(model, name, other)
            if not is_needed(swapped, model):
                yield other


def _holds_more(model: Model, effect: str, other: str) -> bool:
    """Tell whether one disturbance is another with more that is free: a clock of each record, and one of all."""
    known = {one.name: one for one in model.setting.disturbances}
    if effect not in known or other not in known:
        return False
    return known[effect].overlaps(known[other]) and known[effect].dof > known[other].dof
