"""Steps of a diagnosis: effects added to a model, exchanged and dropped, each by real fits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.identification.computation.progress import Tell
from mechid.identification.diagnosis.candidate import Model
from mechid.identification.diagnosis.locked import locked
from mechid.identification.effects.effect import distance_from_null
from mechid.identification.effects.scores import bayesian_penalty
from mechid.identification.effects.selection import (
    add_likeliest,
    drop_unneeded,
    is_confirmed,
    is_needed,
    likely_effects,
)
from mechid.identification.effects.settings import IN_DIAGNOSIS as RULES
from mechid.identification.output_error.problem import transfer_values
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
