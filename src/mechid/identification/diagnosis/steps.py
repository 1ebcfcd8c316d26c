"""Effects added to a model and taken away, one at a time, each by real fits; what a model gains by one."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from scipy.special import chdtrc

from mechid.identification.computation.progress import Tell
from mechid.identification.diagnosis.candidate import Model
from mechid.identification.diagnosis.landscape import Landscape, landscape_of, needed_effects
from mechid.identification.diagnosis.locked import locked
from mechid.identification.disturbance.scores import Score
from mechid.identification.effects.rules import IN_DIAGNOSIS
from mechid.plant.superset import extensions_at


@dataclass(frozen=True)
class Step:
    """An effect added or removed, and what the model is after that.

    Attributes
    ----------
    added, removed : str
        Empty where it is not that.
    cost : float
        In sigmas squared.
    bic : float
        The Bayesian criterion, the noise that of the model in which the search ended, so that steps can be compared.
    over_noise : float
        RMS of what the model leaves over that of the noise.
    free : int
        What it moves: parameters of the mechanism, of the effects and of the records.
    """

    added: str
    removed: str
    cost: float
    bic: float
    over_noise: float
    free: int


def gain(less: Model, more: Model) -> Score:
    """Return what a model explains beyond another, each record's samples counted for what they are worth."""
    fall = max(less.cost - more.cost, 0.0)
    freedom = max(more.problem.size - less.problem.size, 1)
    return Score(more.worth * fall / more.cost, freedom, of_misfit(less, fall), more.worth)


def of_misfit(model: Model, fall: float) -> float:
    """Return the share of what a model leaves beyond noise that a fall of the cost is; noise may hide some of it."""
    return fall / max(model.misfit, fall, 1.0)


def counts(score: Score) -> bool:
    """Tell whether what an effect explains is more than chance and than what its freedom costs."""
    return score.chi_square > IN_DIAGNOSIS.least_chi_square and score.over > 0.0 and score.share >= IN_DIAGNOSIS.share


def step(model: Model, *, added: str = "", removed: str = "") -> Step:
    """Return the step that leads to a model; its criterion is not known before the search has ended."""
    return Step(added, removed, model.cost, math.nan, model.over_noise, model.problem.size)


def beside(end: Model, steps: Sequence[Step]) -> list[Step]:
    """Return steps with the criterion, the noise and the effective samples those of the model where they end."""
    penalty = math.log(max(end.worth, math.e))
    return [replace(one, bic=end.worth * one.cost / end.cost + one.free * penalty) for one in steps]


def grown(model: Model, tried: dict[str, str], say: Tell) -> tuple[Model, list[Step]]:
    """Return the model with one likely effect after another, as long as fits confirm them; `tried` gets the others."""
    steps: list[Step] = []
    while len(model.effects) < IN_DIAGNOSIS.most:
        better = one_more(model, tried, say)
        if better is None and model.over_noise > IN_DIAGNOSIS.followed and model.is_of_whole_records:
            wider = _with_periods_seen(model)
            better = one_more(wider, tried, say) if wider else None
        if better is None and model.over_noise > IN_DIAGNOSIS.followed:
            better = _exchanged(model, say)
        if better is None:
            break
        lost = model.beyond(better)
        steps += [step(better, removed=lost)] if lost else []
        steps.append(step(better, added=better.beyond(model)))
        model = better
    return model, steps


def _with_periods_seen(model: Model) -> Model | None:
    """Return a model, where it is, with further terms of the period that goes most with the motion; None without one.

    One whose kind is not looked for at all, as the campaign file has it, is none.
    """
    seen = max((one for one in locked(model) if one.orders), key=lambda one: one.share, default=None)
    if seen is None:
        return None
    kinds = {name.partition(":")[0] for name in model.setting.considered}
    known = {(e.name, str(e.structure)) for e in model.further}
    some = [
        e
        for e in extensions_at(model.base, seen.orders[0], IN_DIAGNOSIS.periods_around)
        if e.name.partition(":")[0] in kinds and (e.name, str(e.structure)) not in known
    ]
    return model.with_further(some) if some else None


def _exchanged(model: Model, say: Tell) -> Model | None:
    """Return the model with another effect in place of a term, where that leaves clearly less; None where none does.

    What came first may have imitated another effect, as far as that was to be seen then.
    """
    better = next((other for other in exchanges(model, say) if counts(gain(model, other))), None)
    return better.regrown() if better else None


def exchanges(model: Model, say: Tell) -> Iterator[Model]:
    """Yield the model with another effect in place of each of its terms, fitted, the likeliest of each first."""
    for name in model.terms:
        less = model.without(name)
        for other in [one for one in asked(less, landscape_of(less)) if one != name][: IN_DIAGNOSIS.tries]:
            say(f"{other} is fitted in place of {name}")
            yield model.exchanged(name, other)


def one_more(model: Model, tried: dict[str, str], say: Tell) -> Model | None:
    """Return the model with the likeliest further effect that a fit confirms."""
    for name in asked(model, landscape_of(model))[: IN_DIAGNOSIS.tries]:
        if name in tried:
            continue
        say(f"{name} is fitted")
        more = model.with_effect(name).regrown()
        score = gain(model, more)
        if counts(score):
            return more
        tried[name] = f"explains {100.0 * score.share:.3g} % of the misfit in a fit"
    return None


def asked(model: Model, landscape: Landscape) -> list[str]:
    """Return the effects that the score test asks for, the likeliest first."""
    scores = {name: replace(s, share=of_misfit(model, s.share * model.cost)) for name, s in landscape.scores().items()}
    if not scores:
        return []
    from scipy.stats import false_discovery_control  # takes 0.4 s to load, which only fits that miss something pay

    chances = [chdtrc(s.dof, s.chi_square) for s in scores.values()]
    sure = false_discovery_control(chances) <= IN_DIAGNOSIS.false_discoveries
    likely = {name: s for (name, s), one in zip(scores.items(), sure, strict=True) if one and counts(s)}
    return sorted(likely, key=lambda name: -likely[name].over)


def pruned(model: Model, say: Tell) -> tuple[Model, list[Step]]:
    """Return the model without the effects that a fit does as well without: many at once, then the least needed."""
    model, steps = _pruned_at_once(model, say)
    order = sorted(model.effects, key=lambda name: model.without(name).cost) if len(model.effects) > 1 else []
    while len(order) > 1:
        lost = next((name for name in order if not _is_needed(model, name)), None)
        if lost is None:
            break
        say(f"without {lost}")
        model = model.without(lost)
        order.remove(lost)
        steps.append(step(model, removed=lost))
    return model, steps


def _is_needed(model: Model, name: str) -> bool:
    """Tell whether a fit without an effect is clearly worse."""
    return counts(replace(gain(model.without(name), model), share=1.0))


def _pruned_at_once(model: Model, say: Tell) -> tuple[Model, list[Step]]:
    """Return the model without what its derivatives say is not needed, where a fit says so too."""
    kept = needed_effects(model)
    lost = [name for name in (*model.terms, *model.disturbances) if name not in kept]
    if not lost:
        return model, []
    say(f"without {', '.join(lost)}")
    fewer = model.keeping(kept).regrown()
    if counts(replace(gain(fewer, model), share=1.0)):
        return model, []
    return fewer, [step(fewer, removed=name) for name in lost]
