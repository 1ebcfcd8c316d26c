"""Laws in place of those of a mechanism: what hides in the noise, what a disturbance imitates, what leaves least.

No null value leads to some of them, or only a grid does; where a fit of each begins, and what it promises, stands
here too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mechid.identification.beside.beside import lifted
from mechid.identification.computation.progress import Tell
from mechid.identification.diagnosis.candidate import Model
from mechid.identification.diagnosis.steps import Step, counts, gain, grown, pruned, step
from mechid.identification.disturbance.scores import Score
from mechid.identification.effects.rules import IN_DIAGNOSIS
from mechid.plant.mechanism import Mechanism
from mechid.plant.superset import Law

WORSE = "leaves more than the effects without it"


def with_hidden(model: Model, tried: dict[str, str], say: Tell) -> tuple[Model, list[Step]]:
    """Return the model with the laws that it may lack although it leaves no more than noise."""
    steps, asked = list[Step](), set[str]()
    while law := next((one for one in model.other_laws if one.hides and one.name not in asked), None):
        asked.add(law.name)
        score, start = _promise(model, law)
        if not counts(score):
            continue
        say(f"{law.name} is fitted")
        more = model.with_law(law, start).regrown()
        if counts(gain(model, more)):
            model, removed = pruned(more, say)
            steps += [step(more, added=law.name), *removed]
        else:
            tried[law.name] = f"explains {100.0 * gain(model, more).share:.3g} % of the misfit in a fit"
    return model, steps


def in_place_of_imitators(model: Model, say: Tell) -> tuple[Model, list[Step]]:
    """Return the model with laws in place of the disturbances that imitate them, where they do as well for less.

    A low-pass delays all records alike: the delays of the records imitate it down to the noise, with more parameters.
    """
    fitted: list[tuple[Law, Model]] = []
    for law in [law for law in model.other_laws if law.imitated_by in model.disturbances]:
        say(f"{law.name} is fitted in place of {law.imitated_by}")
        trial = _in_place(model, law)
        fitted.append((law, trial.fitted(trial).regrown()))
    if not fitted:
        return model, []
    law, other = min(fitted, key=lambda pair: pair[1].cost)
    if _bic(other, model) >= _bic(model, other):
        return model, []
    fewer, removed = pruned(other, say)
    return fewer, [step(other, removed=law.imitated_by), step(other, added=law.name), *removed]


def with_a_law(before: Model, smooth: Model, tried: dict[str, str], say: Tell) -> tuple[Model, list[Step]]:
    """Return the best of a model of terms alone and those in which a law stands in place of one of the mechanism's.

    Laws are tried beside the terms that have been found, which may be right, and without them: they may imitate a law.
    """
    best, steps = smooth, list[Step]()
    for rank, (law, trial) in enumerate(_promising(before, smooth, tried, say)):
        hopeless = (
            rank >= IN_DIAGNOSIS.law_tries
            or gain(before, trial).share < IN_DIAGNOSIS.mostly
            or best.over_noise <= IN_DIAGNOSIS.followed
        )
        if hopeless and _bic(trial, best) >= _bic(best, trial):
            tried[law] = WORSE
            continue
        say(f"{law} is fitted with what may be beside it")
        with_law = trial.fitted(trial)
        first = [*(step(before, added=name) for name in before.disturbances), step(with_law, added=law)]
        whole, further = grown(with_law.regrown(), tried, say)
        whole, removed = pruned(whole, say)
        if law in whole.laws and _bic(whole, best) < _bic(best, whole):
            best, steps = whole, [*first, *further, *removed]
        else:
            tried[law] = WORSE
    return best, steps


def _promising(before: Model, smooth: Model, tried: dict[str, str], say: Tell) -> list[tuple[str, Model]]:
    """Return the laws that a few steps of a fit speak for, each with where these lead, the best first."""
    found: list[tuple[str, Model]] = []
    models = [smooth, before] if smooth.effects != before.effects else [before]
    of_each = [(less, _numbered(less)) for less in models]
    for name, number in [key for key in _numbered(before) if key[0] not in smooth.laws]:
        say(f"{name} is tried")
        most = 0.0
        for less, law in [(less, laws[name, number]) for less, laws in of_each if (name, number) in laws]:
            trial = _in_place(less, law)
            score = gain(less, trial)
            most = max(most, score.share)
            if counts(score):
                found.append((name, trial))
                break
        else:
            tried[name] = f"explains {100.0 * most:.3g} % of the misfit in a fit"
    return sorted(found, key=lambda pair: pair[1].cost)


def _numbered(model: Model) -> dict[tuple[str, int], Law]:
    """Return the laws that a model has not, by name and number: one may have several starts."""
    found: dict[tuple[str, int], Law] = {}
    for law in model.other_laws:
        found[law.name, sum(name == law.name for name, _ in found)] = law
    return found


def _in_place(model: Model, law: Law) -> Model:
    """Return the model with a law, less the disturbance that takes its place where it is lacking, after some steps."""
    start = _promise(model, law)[1] if law.tries else law.mechanism
    fewer = tuple(name for name in model.disturbances if name != law.imitated_by)
    return replace(model, disturbances=fewer).in_place_of(law, start).fitted(model, steps=IN_DIAGNOSIS.law_steps)


def _bic(model: Model, other: Model) -> float:
    """Return the Bayesian criterion, the noise that of the better of two models."""
    better = min(model, other, key=lambda one: one.cost)
    return better.worth * model.cost / better.cost + model.problem.size * math.log(max(better.worth, math.e))


def _promise(model: Model, law: Law) -> tuple[Score, Mechanism]:
    """Return what a linear fit says that a law would explain, and the mechanism with it at which it says so.

    Of a law that has an amplitude the fit begins where that is zero, at the best of the values that its other
    parameters may have; of another one at its start, which has to be near enough to nothing.
    """
    best, at = -math.inf, law.mechanism
    for mechanism in _points(law):
        fall, amplitude = _fall(model, law, mechanism)
        if fall > best:
            best, at = fall, _at(law, mechanism, amplitude)
    fall = max(best, 0.0)
    return Score(model.worth * fall / model.cost, len(law.own), fall / max(model.misfit, fall, 1.0), model.worth), at


def _points(law: Law) -> Iterator[Mechanism]:
    yield from (law.at_null(values) for values in law.tries or ({},)) if law.null else (law.mechanism,)


def _fall(model: Model, law: Law, mechanism: Mechanism) -> tuple[float, float]:
    """Return by how much the cost falls in a linear fit from a point with a law, and its amplitude there."""
    other = model.in_place_of(law, mechanism)
    q = lifted(model.problem, model.q, other.problem)
    triangle = other.problem.joint(q, model.setting.windows)
    if not np.all(np.isfinite(triangle.jacobian)):
        return -math.inf, 0.0
    move = np.linalg.lstsq(triangle.jacobian, -triangle.fun, rcond=None)[0]
    left = triangle.fun + triangle.jacobian @ move
    there = other.problem.coordinates.values(q + move) if law.null else {}
    return model.cost - float(left @ left), there.get(law.null, 0.0)


def _at(law: Law, mechanism: Mechanism, amplitude: float) -> Mechanism:
    """Return the law's mechanism with the other values of a point and an amplitude, as far as its bounds let it."""
    if not law.null:
        return mechanism
    known = law.mechanism.parameters
    others = {name: mechanism.value(name) for name in law.own if name != law.null}
    within = min(max(amplitude, known[law.null].min), known[law.null].max)
    return law.mechanism.with_values({**others, law.null: within})
