"""Which effects the records ask for: added one at a time where the score test asks for them, each kept by real fits."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from scipy.stats import chi2, false_discovery_control

from mechid.identification.diagnosis.candidate import FOLLOWED, Model
from mechid.identification.diagnosis.landscape import Landscape, landscape_of, needed_effects
from mechid.identification.diagnosis.laws import promise
from mechid.identification.diagnosis.periods import with_periods_seen
from mechid.identification.disturbance.scores import Score
from mechid.identification.uncertainty.noise import MISFIT
from mechid.plant.superset import Law

LEAST = 30.0
"""Chi-square from which an effect counts, whatever its freedom: by chance, one in 2e7 of one degree."""
SHARE = 0.1
"""Of what the records hold beyond noise and effects named so far, that a further effect has to explain."""
FALSE_DISCOVERIES = 0.05
TRIES = 2
"""Effects that are fitted where the likeliest does not keep in a fit what its score promised; laws that are fitted with
what may be beside them."""
MOSTLY = 0.5
"""Share of the misfit that an effect has to take to be named where more than noise is left, or that a law has to take
to be tried with further effects where it alone is not the best."""
FEW = 4
"""Effects that a mechanism file may well lack at once."""
FEW_WEAK = 2
"""Of them that may take less than `MOSTLY`: small ones do, since the noise is not known to the last digit."""
TRIAL = 8
"""Steps in which a law has to show in a fit that it takes a share of what is left."""
MOST = 16
"""Effects of a model."""
WORSE = "leaves more than the effects without it"
Told = Callable[[str], None]


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
        within = self.model.over_noise <= MISFIT and not self.refused
        return 0.0 if within else self.model.misfit / max(self.before.misfit, 1.0)

    @property
    def as_written(self) -> Step:
        """The mechanism as written, before any step."""
        return _beside(self.model, [_step(self.before)])[0]


def searched(before: Model, start: Model, told: Told = lambda words: None) -> Found:
    """Return the effects that the records ask for.

    Parameters
    ----------
    before : Model
        Without any effect.
    start : Model
        Where to begin: with the effects that the fit has already, or `before` itself.
    told : callable
        Told of progress.
    """
    tried: dict[str, str] = {}
    before = _at_its_best(before) if start.effects else start
    steps = [_step(start, added=name) for name in start.effects]
    model, added = _grown(start, tried, told)
    model, removed = _pruned(model, told)
    model, hidden = _with_hidden(model, tried, told) if model.over_noise <= MISFIT else (model, [])
    steps = [*steps, *added, *removed, *hidden]
    if model.over_noise > FOLLOWED:
        bare = model.keeping(model.disturbances) if model.disturbances and not model.laws else before
        better, law_steps = _with_a_law(bare, model, tried, told)
        if better is not model:
            model, steps = better, law_steps
    less, needed = _needed(before, model)
    refused: list[str] = []
    while lost := standing_in(model, needed):
        refused += lost
        tried |= {name: f"explains {100.0 * needed[name].share:.3g} % of the misfit only" for name in lost}
        model = _without_all(model, lost) if len(lost) < len(needed) else before
        steps += [_step(model, removed=name) for name in lost]
        less, needed = _needed(before, model)
    like = {name: tuple(_alike(model, less[name], name)) for name in (*model.terms, *model.disturbances)}
    return Found(model, before, tuple(_beside(model, steps)), tried, needed, less, like, tuple(refused))


def _at_its_best(model: Model) -> Model:
    return model.fitted(model) if math.isfinite(model.cost) else model


def _needed(before: Model, model: Model) -> tuple[dict[str, Model], dict[str, Score]]:
    """Return the model without each of its effects, fitted, and what it explains beyond that."""
    alone = len(model.effects) == 1
    less = {name: before if alone else model.without(name) for name in model.effects}
    return less, {name: gain(without, model) for name, without in less.items()}


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


def _without_all(model: Model, names: Sequence[str]) -> Model:
    for law in [name for name in names if name in model.laws]:
        model = model.without(law)
    return model.keeping([name for name in model.effects if name not in names])


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
    return score.chi_square > LEAST and score.over > 0.0 and score.share >= SHARE


def _grown(model: Model, tried: dict[str, str], told: Told) -> tuple[Model, list[Step]]:
    steps: list[Step] = []
    while len(model.effects) < MOST:
        better = _one_more(model, tried, told)
        if better is None and model.over_noise > FOLLOWED:
            wider = with_periods_seen(model)
            better = _one_more(wider, tried, told) if wider else None
        if better is None:
            break
        steps.append(_step(better, added=better.beyond(model)))
        model = better
    return model, steps


def _one_more(model: Model, tried: dict[str, str], told: Told) -> Model | None:
    """Return the model with the likeliest further effect that a fit confirms."""
    for name in asked(model, landscape_of(model))[:TRIES]:
        if name in tried:
            continue
        told(f"{name} is fitted")
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
    chances = [chi2.sf(s.chi_square, s.dof) for s in scores.values()]
    sure = false_discovery_control(chances) <= FALSE_DISCOVERIES
    likely = {name: s for (name, s), one in zip(scores.items(), sure, strict=True) if one and counts(s)}
    return sorted(likely, key=lambda name: -likely[name].over)


def _pruned(model: Model, told: Told) -> tuple[Model, list[Step]]:
    """Return the model without the effects that a fit does as well without: many at once, then the least needed."""
    model, steps = _pruned_at_once(model, told)
    order = sorted(model.effects, key=lambda name: model.without(name).cost) if len(model.effects) > 1 else []
    while len(order) > 1:
        lost = next((name for name in order if not _is_needed(model, name)), None)
        if lost is None:
            break
        told(f"without {lost}")
        model = model.without(lost)
        order.remove(lost)
        steps.append(_step(model, removed=lost))
    return model, steps


def _is_needed(model: Model, name: str) -> bool:
    """Tell whether a fit without an effect is clearly worse."""
    return counts(replace(gain(model.without(name), model), share=1.0))


def _pruned_at_once(model: Model, told: Told) -> tuple[Model, list[Step]]:
    """Return the model without what its derivatives say is not needed, where a fit says so too."""
    kept = needed_effects(model)
    lost = [name for name in (*model.terms, *model.disturbances) if name not in kept]
    if not lost:
        return model, []
    told(f"without {', '.join(lost)}")
    fewer = model.keeping(kept).regrown()
    if counts(replace(gain(fewer, model), share=1.0)):
        return model, []
    return fewer, [_step(fewer, removed=name) for name in lost]


def _with_hidden(model: Model, tried: dict[str, str], told: Told) -> tuple[Model, list[Step]]:
    """Return the model with the laws that it may lack although it leaves no more than noise."""
    steps: list[Step] = []
    for law in [law for law in model.other_laws if law.hides]:
        score, start = promise(model, law)
        if not counts(score):
            continue
        told(f"{law.name} is fitted")
        more = model.with_law(law, start).regrown()
        if counts(gain(model, more)):
            model, removed = _pruned(more, told)
            steps += [_step(more, added=law.name), *removed]
        else:
            tried[law.name] = f"explains {100.0 * gain(model, more).share:.3g} % of the misfit in a fit"
    return model, steps


def _with_a_law(before: Model, smooth: Model, tried: dict[str, str], told: Told) -> tuple[Model, list[Step]]:
    """Return the best of a model of terms alone and those in which a law stands in place of one of the mechanism's."""
    best, steps = smooth, list[Step]()
    for rank, (law, trial) in enumerate(_promising(before, smooth, tried, told)):
        hopeless = rank >= TRIES or gain(before, trial).share < MOSTLY or best.over_noise <= FOLLOWED
        if hopeless and _bic(trial, best) >= _bic(best, trial):
            tried[law] = WORSE
            continue
        told(f"{law} is fitted with what may be beside it")
        with_law = trial.fitted(trial)
        first = [*(_step(before, added=name) for name in before.disturbances), _step(with_law, added=law)]
        whole, further = _grown(with_law.regrown(), tried, told)
        whole, removed = _pruned(whole, told)
        if law in whole.laws and _bic(whole, best) < _bic(best, whole):
            best, steps = whole, [*first, *further, *removed]
        else:
            tried[law] = WORSE
    return best, steps


def _promising(before: Model, smooth: Model, tried: dict[str, str], told: Told) -> list[tuple[str, Model]]:
    """Return the laws that a few steps of a fit speak for, each with where these lead, the best first."""
    found: list[tuple[str, Model]] = []
    for law in [law for law in before.other_laws if law.name not in smooth.laws]:
        told(f"{law.name} is tried")
        trial = _in_place(before, law)
        score = gain(before, trial)
        if counts(score):
            found.append((law.name, trial))
        else:
            tried[law.name] = f"explains {100.0 * score.share:.3g} % of the misfit in a fit"
    return sorted(found, key=lambda pair: pair[1].cost)


def _in_place(model: Model, law: Law) -> Model:
    """Return the model with a law, less the disturbance that takes its place where it is lacking, after some steps."""
    start = promise(model, law)[1] if law.tries else law.mechanism
    fewer = tuple(name for name in model.disturbances if name != law.imitated_by)
    return replace(model, disturbances=fewer).in_place_of(law, start).fitted(model, steps=TRIAL)


def _bic(model: Model, other: Model) -> float:
    """Return the Bayesian criterion, the noise that of the better of two models."""
    better = min(model, other, key=lambda one: one.cost)
    return better.worth * model.cost / better.cost + model.problem.size * math.log(max(better.worth, math.e))


def _step(model: Model, *, added: str = "", removed: str = "") -> Step:
    return Step(added, removed, model.cost, math.nan, model.over_noise, model.problem.size)


def _beside(end: Model, steps: Sequence[Step]) -> list[Step]:
    """Return steps with the criterion, the noise and the effective samples those of the model where they end."""
    penalty = math.log(max(end.worth, math.e))
    return [replace(step, bic=end.worth * step.cost / end.cost + step.free * penalty) for step in steps]


def _alike(model: Model, less: Model, name: str) -> Iterator[str]:
    """Yield the effects that do as well in place of one, by the score test first and then by a fit."""
    landscape = landscape_of(less)
    if name not in landscape.effects:
        return
    for other in landscape.like(name):
        if other not in model.effects:
            swapped = less.with_effect(other)
            if not counts(replace(gain(swapped, model), share=1.0)):
                yield other
