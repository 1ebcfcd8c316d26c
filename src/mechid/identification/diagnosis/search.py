"""Which effects the records ask for: added one at a time where the score test asks for them, each kept by real fits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from mechid.identification.computation.progress import Tell
from mechid.identification.diagnosis.candidate import FOLLOWED, Model
from mechid.identification.diagnosis.landscape import landscape_of
from mechid.identification.diagnosis.steps import SHARE, Step, beside, counts, gain, grown, pruned, step
from mechid.identification.diagnosis.with_laws import MOSTLY, in_place_of_imitators, with_a_law, with_hidden
from mechid.identification.disturbance.scores import Score
from mechid.identification.uncertainty.model_error import compare_parts
from mechid.identification.uncertainty.settings import NOISE

SMALL = 0.01
"""Of the chi-square of the effect that explains most, below which another is not named of records followed in part.
Backlash and a detent: beside them, delays of 1 to 6 us were named before this rule (docs/diagnosis.md)."""
FAR = 1.2
"""What is left over the noise with all effects found, from which a model may stand on a wrong branch. The limit
from which a record counts as misfit, too."""
FEW = 4
"""Effects that a mechanism file may well lack at once; a choice, not measured."""
NEARLY_ALL = 0.9
"""Of what a model without an effect leaves, that it has to take to be named where the parts of the records still
disagree on the values: what a block of the library is takes nearly all, whatever is missing beside it; a choice."""
FEW_WEAK = 2
"""Of them that may take less than `MOSTLY`: small ones do, since the noise is not known to the last digit."""


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
        return beside(self.model, [step(self.before)])[0]


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
    before = _at_its_best(before) if start.effects else start
    steps = [step(start, added=name) for name in start.effects]
    model, added = grown(start, tried, say)
    model, removed = pruned(model, say)
    model, hidden = with_hidden(model, tried, say) if model.over_noise <= NOISE.misfit else (model, [])
    model, imitated = in_place_of_imitators(model, say)
    steps = [*steps, *added, *removed, *hidden, *imitated]
    if model.over_noise > FOLLOWED:
        bare = model.keeping(model.disturbances) if model.disturbances and not model.laws else before
        better, law_steps = with_a_law(bare, model, tried, say)
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
    return Found(model, before, tuple(beside(model, steps)), tried, needed, less, like, tuple(refused))


def _at_its_best(model: Model) -> Model:
    return model.fitted(model) if math.isfinite(model.cost) else model


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
    return least if needed[least].chi_square < SMALL * most else ""


def standing_in(model: Model, needed: Mapping[str, Score]) -> list[str]:
    """Return the effects that may stand for something else.

    Where more than noise is left, those that take less than half of what a model without them leaves. Where many
    effects share what there is to explain, so that several take less than half, or some of more than four: all, since
    they imitate it together. Nothing is named for less than the share for which nothing is added.
    """
    weak = [name for name, score in needed.items() if score.share < MOSTLY]
    if len(weak) > FEW_WEAK or (weak and len(needed) > FEW):
        return list(needed)
    return weak if model.over_noise > FOLLOWED else [name for name in weak if needed[name].share < SHARE]


def in_doubt(model: Model, needed: Mapping[str, Score], less: Mapping[str, Model]) -> list[str]:
    """Return the effects that may stand for something else since parts of the records disagree on the values with them.

    With a model that lacks nothing they agree; with one that leaves far more than noise they need not, since it may be
    on a wrong branch. Those stay that take nearly all of what is beyond noise.
    """
    if not needed or not model.over_noise <= FAR or _agrees(model):
        return []
    clear = {name for name in needed if needed[name].share >= NEARLY_ALL and less[name].over_noise > FOLLOWED}
    return [name for name in needed if name not in clear]


def _agrees(model: Model) -> bool:
    return compare_parts(model.problem, model.q, model.setting.windows).consistency.agrees


def _why_refused(share: float) -> str:
    explains = f"explains {100.0 * share:.3g} % of the misfit"
    return (
        f"{explains} only" if share < MOSTLY else f"{explains}, yet parts of the records disagree on the values with it"
    )


def _without_all(model: Model, names: Sequence[str]) -> Model:
    for law in [name for name in names if name in model.laws]:
        model = model.without(law)
    return model.keeping([name for name in model.effects if name not in names])


def _alike(model: Model, less: Model, name: str) -> Iterator[str]:
    """Yield the effects that do as well in place of one, by the score test first and then by a fit."""
    landscape = landscape_of(less)
    if name not in landscape.effects:
        return
    for other in landscape.like(name):
        if other not in model.effects and not model.holds_more(other, name):
            swapped = model.exchanged(name, other)
            if not counts(replace(gain(swapped, model), share=1.0)):
                yield other
