"""Laws in place of those of a mechanism: what hides in the noise, what a disturbance imitates, what leaves least.

No null value leads to some of them, or only a grid does; where a fit of each begins, and what it promises, stands
here too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mechid.identification.computation.progress import Tell
from mechid.identification.diagnosis.candidate import Model
from mechid.identification.diagnosis.steps import Step, add_effects, drop_effects, step
from mechid.identification.effects.scores import Score
from mechid.identification.effects.selection import better_law, gain, is_confirmed, is_significant, share_of_misfit
from mechid.identification.effects.settings import IN_DIAGNOSIS as RULES
from mechid.identification.output_error.problem import transfer_values
from mechid.plant.mechanism import Mechanism
from mechid.plant.superset import Law

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
