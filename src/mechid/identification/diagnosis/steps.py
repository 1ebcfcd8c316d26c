"""Steps of a diagnosis: adding, exchanging and dropping effects and laws, each decided by a full fit."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.identification.computation.progress import Tell
from mechid.identification.diagnosis.candidate import CandidateModel
from mechid.identification.diagnosis.unexplained_residual import locked_lines
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
from mechid.identification.stages.kernel_precompilation import Layout
from mechid.kernel.compiled import is_compiled
from mechid.plant.law import Law
from mechid.plant.mechanism import Mechanism
from mechid.plant.superset import extensions_at, rivals_of


@dataclass(frozen=True)
class Step:
    """An effect added or removed, and the figures of the resulting model.

    Attributes
    ----------
    added, removed : str
        Name of the effect; the other one is empty.
    cost : float
        In sigmas squared.
    bic : float
        Bayesian criterion at the noise of the final model of the search, so that steps can be compared.
    over_noise : float
        Residual-to-noise ratio of the model.
    free : int
        Number of free parameters of the mechanism, the effects and the records.
    """

    added: str
    removed: str
    cost: float
    bic: float
    over_noise: float
    free: int


def step(model: CandidateModel, *, added: str = "", removed: str = "") -> Step:
    """Return the step that leads to a model; its criterion is unknown until the search has ended."""
    return Step(added, removed, model.cost, math.nan, model.over_noise, model.problem.size)


def compute_criteria(end: CandidateModel, steps: Sequence[Step]) -> list[Step]:
    """Compute the criterion of each step, with the noise and the effective sample count of the final model."""
    penalty = bayesian_penalty(end.effective_samples)
    return [replace(one, bic=end.effective_samples * one.cost / end.cost + one.free * penalty) for one in steps]


def add_effects(model: CandidateModel, tried: dict[str, str], say: Tell) -> tuple[CandidateModel, list[Step]]:
    """Add one likely effect after another as long as fits confirm them; `tried` collects the others."""
    steps: list[Step] = []
    while len(model.effects) < RULES.most:
        better = add_likeliest(model, tried, say)
        if better is None and model.over_noise > RULES.noise_limit and model.is_of_whole_records:
            wider = _add_seen_periods(model)
            better = add_likeliest(wider, tried, say) if wider else None
        if better is None and model.over_noise > RULES.noise_limit:
            better = _exchange_one(model, say)
        if better is None:
            break
        steps += [step(better, removed=name) for name in model.effects if name not in better.effects]
        steps += [step(better, added=name) for name in better.effects if name not in model.effects]
        model = better
    return model, steps


def _add_seen_periods(model: CandidateModel) -> CandidateModel | None:
    """Add candidate terms with the period that the residual shows most over the motion; None where there are none.

    Terms of a kind that the campaign file excludes are not added.
    """
    seen = max((one for one in locked_lines(model) if one.orders), key=lambda one: one.share, default=None)
    if seen is None:
        return None
    kinds = {name.partition(":")[0] for name in model.setting.considered}
    known = {(e.name, str(e.structure)) for e in model.further}
    some = [
        e
        for e in extensions_at(model.base, seen.orders[0], RULES.periods_around)
        if e.name.partition(":")[0] in kinds and (e.name, str(e.structure)) not in known
    ]
    return model.add_candidates(some) if some else None


def _exchange_one(model: CandidateModel, say: Tell) -> CandidateModel | None:
    """Exchange a term for another effect that leaves a clearly smaller residual; None where there is none.

    An effect that was added early may have imitated another one that was not yet visible.
    """
    better = next((other for other in exchanged_models(model, say) if is_confirmed(model, other)), None)
    return better.regrow() if better else None


def exchanged_models(model: CandidateModel, say: Tell) -> Iterator[CandidateModel]:
    """Yield the fitted model with another effect in place of each of its terms, the likeliest exchange first."""
    for name in model.terms:
        less = model.without(name)
        for other in [one for one in likely_effects(less, less.scores()) if one != name][: RULES.tries]:
            say(f"{other} is fitted in place of {name}")
            yield exchange_effect(model, name, other)


def exchange_effect(model: CandidateModel, effect: str, other: str) -> CandidateModel:
    """Exchange an effect for another term or disturbance, and fit.

    The fit starts from the point at which, by the derivatives, the other effect comes nearest to the same output. From
    a point with neither effect, the order of stick-slip events or impacts would have to be found again.
    """
    both = model.add_effect(other)
    both = replace(both, q=transfer_values(model.problem, model.q, both.problem))
    problem, q = both.problem, both.q
    J = problem.joint(q, model.setting.windows).jacobian
    lost = np.array([name in both.parameters[effect] for name in problem.coordinates.names])
    move = np.where(lost, -distance_from_null(problem, q), 0.0)
    if np.all(np.isfinite(J)):
        # The other coordinates compensate for the removed effect as far as first derivatives allow.
        move[~lost] = -np.linalg.lstsq(J[:, ~lost], J[:, lost] @ move[lost], rcond=None)[0]
    there = replace(both, q=problem.coordinates.clip(q + move))
    return there.remove_effect(effect).fit(there)


def drop_effects(model: CandidateModel, say: Tell) -> tuple[CandidateModel, list[Step]]:
    """Drop the effects that a fit does not need: first many at once, then one by one, the least needed first."""
    model, steps = _drop_at_once(model, say)
    order = sorted(model.effects, key=lambda name: model.without(name).cost) if len(model.effects) > 1 else []
    for lost, fewer in drop_unneeded(model, order, say):
        model = fewer
        steps.append(step(model, removed=lost))
    return model, steps


def _drop_at_once(model: CandidateModel, say: Tell) -> tuple[CandidateModel, list[Step]]:
    """Drop all effects that the derivatives call unneeded, if a fit confirms it."""
    kept = model.needed_effects()
    lost = [name for name in (*model.terms, *model.disturbances) if name not in kept]
    if not lost:
        return model, []
    say(f"without {', '.join(lost)}")
    fewer = model.keep_effects(kept).regrow()
    if is_needed(fewer, model):
        return model, []
    return fewer, [step(fewer, removed=name) for name in lost]


WORSE = "leaves more than the effects without it"
VANISHES = "shrinks to nothing in a fit"


def hidden_law_layouts(model: CandidateModel) -> list[Layout]:
    """Return the plants, with their numbers of derivatives, that `add_hidden_laws` needs first and has to compile."""
    others = (model.use_law(law, law.mechanism).problem for law in model.other_laws if law.hides)
    needed = ((other.space.mechanism.plant, other.coordinates.lanes) for other in others)
    return [layout for layout in needed if not is_compiled(*layout)]


def add_hidden_laws(model: CandidateModel, tried: dict[str, str], say: Tell) -> tuple[CandidateModel, list[Step]]:
    """Add laws that may be missing although the residual is at the noise level."""
    steps, asked = list[Step](), set[str]()
    while law := next((one for one in model.other_laws if one.hides and one.name not in asked), None):
        asked.add(law.name)
        score, start = score_law(model, law)
        if not is_significant(score, RULES, RULES.share):
            continue
        say(f"{law.name} is fitted")
        more = model.use_law(law, start).fit(model).regrow()
        if is_confirmed(model, more):
            model, removed = drop_effects(more, say)
            steps += [step(more, added=law.name), *removed]
        else:
            tried[law.name] = f"explains {100.0 * gain(model, more).share:.3g} % of the misfit in a fit"
    return model, steps


def replace_imitators(model: CandidateModel, say: Tell) -> tuple[CandidateModel, list[Step]]:
    """Replace disturbances by the laws that they imitate, where the laws explain as much with fewer parameters.

    A low-pass delays all records alike: per-record delays imitate it down to the noise, with more parameters.
    """

    def fit_laws() -> Iterator[tuple[Law, CandidateModel]]:
        for law in [law for law in model.other_laws if law.imitated_by in model.disturbances]:
            say(f"{law.name} is fitted in place of {law.imitated_by}")
            trial = _try_law(model, law)
            yield law, trial.fit(trial).regrow()

    better = better_law(model, fit_laws())
    if better is None:
        return model, []
    law, other = better
    fewer, removed = drop_effects(other, say)
    return fewer, [step(other, removed=law.imitated_by), step(other, added=law.name), *removed]


def add_law(
    before: CandidateModel, smooth: CandidateModel, tried: dict[str, str], say: Tell
) -> tuple[CandidateModel, list[Step]]:
    """Return the best of a model with terms alone and models with an alternative law.

    Laws are tried together with the found terms, which may be right, and without them, since they may imitate a law.
    """
    best, steps = smooth, list[Step]()
    for rank, (law, trial) in enumerate(_promising_laws(before, smooth, tried, say)):
        hopeless = (
            rank >= RULES.law_tries or gain(before, trial).share < RULES.mostly or best.over_noise <= RULES.noise_limit
        )
        if hopeless and not trial.is_better_than(best):
            tried[law] = WORSE
            continue
        say(f"{law} is fitted with further effects")
        with_law = trial.fit(trial)
        first = [*(step(before, added=name) for name in before.disturbances), step(with_law, added=law)]
        whole, further = add_effects(with_law.regrow(), tried, say)
        whole, removed = drop_effects(whole, say)
        # A play that shrank to nothing fits by the rounding of impacts, not by an effect.
        if law in whole.laws and not has_absent_law(whole) and whole.is_better_than(best):
            best, steps = whole, [*first, *further, *removed]
        else:
            tried[law] = VANISHES if has_absent_law(whole) else WORSE
    return best, steps


def _promising_laws(
    before: CandidateModel, smooth: CandidateModel, tried: dict[str, str], say: Tell
) -> list[tuple[str, CandidateModel]]:
    """Return the laws that a few steps of a fit support, each with the resulting model, the best first."""
    found: list[tuple[str, CandidateModel]] = []
    models = [smooth, before] if smooth.effects != before.effects else [before]
    of_each = [(less, _numbered_laws(less)) for less in models]
    for name, number in [key for key in _numbered_laws(before) if key[0] not in smooth.laws]:
        say(f"{name} is tried")
        most = 0.0
        for less, law in [(less, laws[name, number]) for less, laws in of_each if (name, number) in laws]:
            trial = _try_law(less, law)
            most = max(most, gain(less, trial).share)
            if is_confirmed(less, trial):
                found.append((name, trial))
                break
        else:
            tried[name] = f"explains {100.0 * most:.3g} % of the misfit in a fit"
    return sorted(found, key=lambda pair: pair[1].cost)


def has_absent_law(model: CandidateModel) -> bool:
    """Return whether an alternative law of a model has its size at the lower bound, where the effect is absent."""
    values = model.problem.coordinates.values(model.q)
    mechanism = model.base.with_values({name: values[name] for name in model.law_parameters if name in values})
    written = rivals_of(model.setting.problem.space.mechanism)
    return any(law.name in model.laws and law.is_absent(mechanism) for law in written)


def _numbered_laws(model: CandidateModel) -> dict[tuple[str, int], Law]:
    """Return the laws that a model does not have, by name and number, since a law may have several starts."""
    found: dict[tuple[str, int], Law] = {}
    for law in model.other_laws:
        found[law.name, sum(name == law.name for name, _ in found)] = law
    return found


def _try_law(model: CandidateModel, law: Law) -> CandidateModel:
    """Return the model with a law after a few fit steps, without the disturbance that imitates the law."""
    start = score_law(model, law)[1] if law.tries else law.mechanism
    fewer = tuple(name for name in model.disturbances if name != law.imitated_by)
    return replace(model, disturbances=fewer).use_law(law, start).fit(model, steps=RULES.law_steps)


def score_law(model: CandidateModel, law: Law) -> tuple[Score, Mechanism]:
    """Return the score of a law by a linear fit, and the mechanism with the law at its best point.

    For a law with an amplitude, the linear fit starts at amplitude zero, at each candidate value of its other
    parameters. For any other law it starts at the law's start, which has to be close to no effect.
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


def _linear_fall(model: CandidateModel, law: Law, mechanism: Mechanism) -> tuple[float, float]:
    """Return the fall of the cost in a linear fit from a point with a law, and the law's amplitude there."""
    other = model.use_law(law, mechanism)
    q = transfer_values(model.problem, model.q, other.problem)
    triangle = other.problem.joint(q, model.setting.windows)
    if not np.all(np.isfinite(triangle.jacobian)):
        return -math.inf, 0.0
    # The least-norm solution: at amplitude zero the other parameters of a law have no derivatives.
    move = np.linalg.lstsq(triangle.jacobian, -triangle.fun, rcond=None)[0]
    left = triangle.fun + triangle.jacobian @ move
    there = other.problem.coordinates.values(q + move) if law.null else {}
    return model.cost - float(left @ left), there.get(law.null, 0.0)
