"""Steps of a diagnosis: effects and laws added, exchanged and dropped, each by real fits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.identification.computation.progress import Tell
from mechid.identification.diagnosis.candidate import Model
from mechid.identification.diagnosis.unexplained import locked
from mechid.identification.effects.effect import distance_from_null
from mechid.identification.effects.scores import Score, bayesian_penalty
from mechid.identification.effects.selection import (
    add_likeliest,
    better_law,
    drop_unneeded,
    gain,
    is_confirmed,
    is_needed,
    is_significant,
    likely_effects,
    share_of_misfit,
)
from mechid.identification.effects.settings import IN_DIAGNOSIS as RULES
from mechid.identification.output_error.problem import transfer_values
from mechid.plant.law import Law
from mechid.plant.mechanism import Mechanism
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


def step(model: Model, *, added: str = "", removed: str = "") -> Step:
    """Return the step that leads to a model; its criterion is not known before the search has ended."""
    return Step(added, removed, model.cost, math.nan, model.over_noise, model.problem.size)


def with_criteria(end: Model, steps: Sequence[Step]) -> list[Step]:
    """Return steps with the criterion, the noise and the effective samples those of the model where they end."""
    penalty = bayesian_penalty(end.effective_samples)
    return [replace(one, bic=end.effective_samples * one.cost / end.cost + one.free * penalty) for one in steps]


def add_effects(model: Model, tried: dict[str, str], say: Tell) -> tuple[Model, list[Step]]:
    """Return the model with one likely effect after another, as long as fits confirm them; `tried` gets the others."""
    steps: list[Step] = []
    while len(model.effects) < RULES.most:
        better = add_likeliest(model, tried, say)
        if better is None and model.over_noise > RULES.followed and model.is_of_whole_records:
            wider = _with_seen_periods(model)
            better = add_likeliest(wider, tried, say) if wider else None
        if better is None and model.over_noise > RULES.followed:
            better = _with_an_exchange(model, say)
        if better is None:
            break
        steps += [step(better, removed=name) for name in model.effects if name not in better.effects]
        steps += [step(better, added=name) for name in better.effects if name not in model.effects]
        model = better
    return model, steps


def _with_seen_periods(model: Model) -> Model | None:
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
        for e in extensions_at(model.base, seen.orders[0], RULES.periods_around)
        if e.name.partition(":")[0] in kinds and (e.name, str(e.structure)) not in known
    ]
    return model.with_further(some) if some else None


def _with_an_exchange(model: Model, say: Tell) -> Model | None:
    """Return the model with another effect in place of a term, where that leaves clearly less; None where none does.

    What came first may have imitated another effect, as far as that was to be seen then.
    """
    better = next((other for other in exchanged_models(model, say) if is_confirmed(model, other)), None)
    return better.regrown() if better else None


def exchanged_models(model: Model, say: Tell) -> Iterator[Model]:
    """Yield the model with another effect in place of each of its terms, fitted, the likeliest of each first."""
    for name in model.terms:
        less = model.without(name)
        for other in [one for one in likely_effects(less, less.scores()) if one != name][: RULES.tries]:
            say(f"{other} is fitted in place of {name}")
            yield exchange_effect(model, name, other)


def exchange_effect(model: Model, effect: str, other: str) -> Model:
    """Return a model with another term or disturbance in place of one, fitted.

    The fit begins where the derivatives say that the other explains most nearly the same: from a point with
    neither, what one step of a stick/slip or an impact hides would have to be found again.
    """
    both = model.put_in(other)
    both = replace(both, q=transfer_values(model.problem, model.q, both.problem))
    problem, q = both.problem, both.q
    J = problem.joint(q, model.setting.windows).jacobian
    lost = np.array([name in both.parameters[effect] for name in problem.coordinates.names])
    move = np.where(lost, -distance_from_null(problem, q), 0.0)
    if np.all(np.isfinite(J)):
        move[~lost] = -np.linalg.lstsq(J[:, ~lost], J[:, lost] @ move[lost], rcond=None)[0]
    there = replace(both, q=problem.coordinates.clip(q + move))
    return there.take_out(effect).fitted(there)


def drop_effects(model: Model, say: Tell) -> tuple[Model, list[Step]]:
    """Return the model without the effects that a fit does as well without: many at once, then the least needed."""
    model, steps = _drop_at_once(model, say)
    order = sorted(model.effects, key=lambda name: model.without(name).cost) if len(model.effects) > 1 else []
    for lost, fewer in drop_unneeded(model, order, say):
        model = fewer
        steps.append(step(model, removed=lost))
    return model, steps


def _drop_at_once(model: Model, say: Tell) -> tuple[Model, list[Step]]:
    """Return the model without what its derivatives say is not needed, where a fit says so too."""
    kept = model.needed_effects()
    lost = [name for name in (*model.terms, *model.disturbances) if name not in kept]
    if not lost:
        return model, []
    say(f"without {', '.join(lost)}")
    fewer = model.keeping(kept).regrown()
    if is_needed(fewer, model):
        return model, []
    return fewer, [step(fewer, removed=name) for name in lost]


WORSE = "leaves more than the effects without it"


def add_hidden_laws(model: Model, tried: dict[str, str], say: Tell) -> tuple[Model, list[Step]]:
    """Return the model with the laws that it may lack although it leaves no more than noise."""
    steps, asked = list[Step](), set[str]()
    while law := next((one for one in model.other_laws if one.hides and one.name not in asked), None):
        asked.add(law.name)
        score, start = promise_of_law(model, law)
        if not is_significant(score, RULES, RULES.share):
            continue
        say(f"{law.name} is fitted")
        more = model.in_place_of(law, start).fitted(model).regrown()
        if is_confirmed(model, more):
            model, removed = drop_effects(more, say)
            steps += [step(more, added=law.name), *removed]
        else:
            tried[law.name] = f"explains {100.0 * gain(model, more).share:.3g} % of the misfit in a fit"
    return model, steps


def replace_imitators(model: Model, say: Tell) -> tuple[Model, list[Step]]:
    """Return the model with laws in place of the disturbances that imitate them, where they do as well for less.

    A low-pass delays all records alike: the delays of the records imitate it down to the noise, with more parameters.
    """

    def fitted() -> Iterator[tuple[Law, Model]]:
        for law in [law for law in model.other_laws if law.imitated_by in model.disturbances]:
            say(f"{law.name} is fitted in place of {law.imitated_by}")
            trial = _after_some_steps_with(model, law)
            yield law, trial.fitted(trial).regrown()

    better = better_law(model, fitted())
    if better is None:
        return model, []
    law, other = better
    fewer, removed = drop_effects(other, say)
    return fewer, [step(other, removed=law.imitated_by), step(other, added=law.name), *removed]


def add_law(before: Model, smooth: Model, tried: dict[str, str], say: Tell) -> tuple[Model, list[Step]]:
    """Return the best of a model of terms alone and those in which a law stands in place of one of the mechanism's.

    Laws are tried beside the terms that have been found, which may be right, and without them: they may imitate a law.
    """
    best, steps = smooth, list[Step]()
    for rank, (law, trial) in enumerate(_promising(before, smooth, tried, say)):
        hopeless = (
            rank >= RULES.law_tries or gain(before, trial).share < RULES.mostly or best.over_noise <= RULES.followed
        )
        if hopeless and not trial.is_better_than(best):
            tried[law] = WORSE
            continue
        say(f"{law} is fitted with what may be beside it")
        with_law = trial.fitted(trial)
        first = [*(step(before, added=name) for name in before.disturbances), step(with_law, added=law)]
        whole, further = add_effects(with_law.regrown(), tried, say)
        whole, removed = drop_effects(whole, say)
        if law in whole.laws and whole.is_better_than(best):
            best, steps = whole, [*first, *further, *removed]
        else:
            tried[law] = WORSE
    return best, steps


def _promising(before: Model, smooth: Model, tried: dict[str, str], say: Tell) -> list[tuple[str, Model]]:
    """Return the laws that a few steps of a fit speak for, each with where these lead, the best first."""
    found: list[tuple[str, Model]] = []
    models = [smooth, before] if smooth.effects != before.effects else [before]
    of_each = [(less, _numbered_laws(less)) for less in models]
    for name, number in [key for key in _numbered_laws(before) if key[0] not in smooth.laws]:
        say(f"{name} is tried")
        most = 0.0
        for less, law in [(less, laws[name, number]) for less, laws in of_each if (name, number) in laws]:
            trial = _after_some_steps_with(less, law)
            most = max(most, gain(less, trial).share)
            if is_confirmed(less, trial):
                found.append((name, trial))
                break
        else:
            tried[name] = f"explains {100.0 * most:.3g} % of the misfit in a fit"
    return sorted(found, key=lambda pair: pair[1].cost)


def _numbered_laws(model: Model) -> dict[tuple[str, int], Law]:
    """Return the laws that a model has not, by name and number: one may have several starts."""
    found: dict[tuple[str, int], Law] = {}
    for law in model.other_laws:
        found[law.name, sum(name == law.name for name, _ in found)] = law
    return found


def _after_some_steps_with(model: Model, law: Law) -> Model:
    """Return the model with a law, less the disturbance that takes its place where it is lacking, after some steps."""
    start = promise_of_law(model, law)[1] if law.tries else law.mechanism
    fewer = tuple(name for name in model.disturbances if name != law.imitated_by)
    return replace(model, disturbances=fewer).in_place_of(law, start).fitted(model, steps=RULES.law_steps)


def promise_of_law(model: Model, law: Law) -> tuple[Score, Mechanism]:
    """Return what a linear fit says that a law would explain, and the mechanism with it at which it says so.

    Of a law that has an amplitude the fit begins where that is zero, at the best of the values that its other
    parameters may have; of another one at its start, which has to be near enough to nothing.
    """
    best, at = -math.inf, law.mechanism
    for mechanism in map(law.at_null, law.tries or ({},)) if law.null else (law.mechanism,):
        fall, amplitude = _linear_fall(model, law, mechanism)
        if fall > best:
            best, at = fall, law.at(mechanism, amplitude)
    fall = max(best, 0.0)
    return Score(
        model.effective_samples * fall / model.cost, len(law.own), share_of_misfit(model, fall), model.effective_samples
    ), at


def _linear_fall(model: Model, law: Law, mechanism: Mechanism) -> tuple[float, float]:
    """Return by how much the cost falls in a linear fit from a point with a law, and its amplitude there."""
    other = model.in_place_of(law, mechanism)
    q = transfer_values(model.problem, model.q, other.problem)
    triangle = other.problem.joint(q, model.setting.windows)
    if not np.all(np.isfinite(triangle.jacobian)):
        return -math.inf, 0.0
    move = np.linalg.lstsq(triangle.jacobian, -triangle.fun, rcond=None)[0]
    left = triangle.fun + triangle.jacobian @ move
    there = other.problem.coordinates.values(q + move) if law.null else {}
    return model.cost - float(left @ left), there.get(law.null, 0.0)
