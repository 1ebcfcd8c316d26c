"""Growth with additional effects: grown, pruned, and settled once all records are followed.

Growth with few free parameters succeeds where one with many stalls. Effects that the followed samples do not need are
therefore dropped before a growth, and freed again where it stalls. At the end only the needed effects are kept.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign import Campaign
from mechid.identification.effects.augmented import AugmentedModel
from mechid.identification.effects.disturbance import Disturbance, FoundDisturbance, missing_tables, remove_disturbances
from mechid.identification.effects.effect import AddedTerms, distance_from_null, lay_out, rename_values
from mechid.identification.effects.pruning import groups_of, linearise, needed_groups
from mechid.identification.effects.scores import Score, bayesian_penalty
from mechid.identification.effects.selection import is_significant
from mechid.identification.effects.settings import DURING_FIT, IN_DIAGNOSIS
from mechid.identification.output_error.problem import Problem, Windows, transfer_values
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.gates import Growth, grow_horizons
from mechid.identification.search.horizons import least_horizons, unfollowed_records
from mechid.identification.search.solve import solve
from mechid.identification.stages.families import TERMS_AND_RECORDS, Families, Family
from mechid.identification.stages.first_look import effect_words
from mechid.identification.stages.needed_terms import drop_unneeded_terms, lay_out_state
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.watch import Watch
from mechid.identification.uncertainty.noise_levels import explains_most
from mechid.simulation.work import WorkSpentError


@dataclass(frozen=True, eq=False)
class GrownModel:
    """Model with effects free, and its growth."""

    model: AugmentedModel
    growth: Growth

    @property
    def problem(self) -> Problem:
        """The model's problem."""
        return self.model.problem

    @property
    def q(self) -> FloatArray:
        """End of its growth, (n,)."""
        return self.growth.q

    @property
    def share(self) -> float:
        """Share of all samples that are followed."""
        return self.growth.followed_share(self.problem)

    @property
    def windows(self) -> Windows:
        """Followed part of each record."""
        return {name: (0, n) for name, n in self.growth.horizons.items()}


def grow_model(
    watch: Watch, model: AugmentedModel, q: FloatArray, seed: int, *, escapes: int = STAGES.term_escapes, leaps: int = 0
) -> GrownModel:
    """Grow a model with effects free from a point of it; if the budget is spent, return the growth up to then."""
    tell, rng = tell_growth(watch, model), np.random.default_rng((seed, 0, 7))
    furthest = Growth(q, least_horizons(model.problem), False, 0)

    def on_progress(at: FloatArray, gates: Mapping[str, int]) -> None:
        nonlocal furthest
        if sum(gates.values()) >= sum(furthest.horizons.values()):
            furthest = Growth(at, dict(gates), False, furthest.rounds + 1)
        tell(at, gates)

    with suppress(WorkSpentError):
        furthest = grow_horizons(
            model.problem, q, rng, on_progress, escapes=escapes, leaps=leaps, journal=watch.journal
        )
    return GrownModel(model, furthest)


def tell_growth(watch: Watch, model: AugmentedModel) -> Callable[[FloatArray, Mapping[str, int]], None]:
    """Return a function that reports the growth of a model."""
    total = sum(t.samples for t in model.problem.targets)

    def on_progress(_q: FloatArray, gates: Mapping[str, int]) -> None:
        watch.tell(
            "added effects", f"{model.name}: {100.0 * sum(gates.values()) / total:.1f} % of all samples followed"
        )

    return on_progress


def free_family_at_stall(watch: Watch, families: Families, reached: GrownModel, family: Family) -> GrownModel:
    """Free a family of effects where a growth has stalled, without those not needed there.

    The model returned has not been grown yet: its horizons are those reached before.
    """
    wide = families.model(family, reached.model)
    q = wide.point_of(reached.model, reached.q)
    q = solve(wide.problem, q, reached.windows, steps=STAGES.freed_steps, tolerance=STAGES.rough_tolerance).q
    needed = wide.needed_effects(q, reached.windows)
    if needed is None:
        return GrownModel(wide, replace(reached.growth, q=q))
    watch.tell("added effects", f"needed so far: {effect_words(needed)}")
    less = wide.keep_effects(families.plain, needed, ", ".join(needed) or "as written")
    less = less.widen_priors(families.plain, less.point_of(wide, q), STAGES.at_edge, STAGES.wider)
    initial = less.point_of(wide, q)
    moved = solve(less.problem, initial, reached.windows, steps=STAGES.freed_steps, tolerance=STAGES.rough_tolerance).q
    return GrownModel(less, replace(reached.growth, q=moved))


def settle(watch: Watch, state: SearchState, reached: GrownModel, seed: int) -> tuple[SearchState, Growth] | None:
    """Return the state that follows all records with only the needed effects.

    The mechanism as written is used if it follows them from here. If the terms leave more than the mechanism as
    written, they explain nothing, and the latter is grown from here. None is returned if that growth does not follow
    all records, or if more terms remain than a file may plausibly lack.
    """
    found, problem, q = select_needed_disturbances(reached)
    whole = {t.name: t.samples for t in problem.targets}
    own = [one.disturbance for one in found]
    base = lay_out(reached.model.base, (), missing_tables(reached.model.base.mechanism, own))
    plain = base.problem(state.problem, own)
    alone = _fit_without_terms(reached.model, problem, q, plain)
    at = replace(state, found=(*state.found, *found))
    if base.mechanism is not state.problem.space.mechanism:
        at = replace(at, added=base)
    follows = not unfollowed_records(plain, alone) and not _needs_terms(reached.model, problem, q)
    if not follows and plain.total_norm(alone, plain.whole_windows()) < problem.total_norm(q, problem.whole_windows()):
        model = AugmentedModel("without terms", plain, base, tuple(own), None, base)
        growth = grow_model(watch, model, alone, seed).growth
        if not growth.complete:
            return None
        follows, alone = True, growth.q
    rounds = reached.growth.rounds
    if follows:
        return watch.note(at.with_problem(plain).at(alone, whole)), Growth(alone, whole, True, rounds)
    at = drop_unneeded_terms(replace(at.with_problem(problem), added=reached.model.added).at(q, whole), plain)
    if at.added is not None and len(at.added.terms) > IN_DIAGNOSIS.few:
        return None  # so many terms imitate a missing effect, such as a value outside its bounds
    at = _drop_idle_law(at, state.problem, own)
    return watch.note(at), Growth(at.q, whole, True, rounds)


def _drop_idle_law(state: SearchState, written: Problem, own: Sequence[Disturbance]) -> SearchState:
    """Return a state with the law as written in place of an added one, if the terms alone explain the misfit.

    Parameters
    ----------
    state : SearchState
        State with all records followed.
    written : Problem
        Problem of the mechanism as written.
    own : sequence of Disturbance
        Disturbances of the state's records.
    """
    added = state.added
    if added is None or not added.law or not added.terms:
        return state
    mechanism = written.space.mechanism
    fewer = replace(lay_out(AddedTerms(mechanism), added.terms, missing_tables(mechanism, own)), aliases=added.aliases)
    problem = fewer.problem(written, own)
    values = rename_values(state.problem.coordinates.values(state.q), added, fewer)
    initial, whole = problem.coordinates.clip(problem.coordinates.point(values)), problem.whole_windows()
    q = solve(problem, initial, whole, steps=STAGES.joint_steps, tolerance=STAGES.rough_tolerance).q
    penalty = bayesian_penalty(sum(t.samples for t in problem.targets)) * (state.problem.size - problem.size)
    with_law = state.problem.total_norm(state.q, whole) ** 2
    if unfollowed_records(problem, q) or problem.total_norm(q, whole) ** 2 > with_law + penalty:
        return state
    return replace(state.with_problem(problem), added=fewer).at(q)


def unfinished_state(state: SearchState, reached: GrownModel) -> SearchState:
    """Return the state of a growth that has not reached the ends of all records, with its effects."""
    model, windows = reached.model, reached.windows
    rises = model.needed_effects(reached.q, windows) or {}
    total = max(sum(rises.values()), 1e-300)
    found = tuple(
        FoundDisturbance(one, rises.get(one.name, 0.0), rises.get(one.name, 0.0) / total) for one in model.disturbances
    )
    base = lay_out(model.base, (), missing_tables(model.base.mechanism, model.disturbances))
    at = replace(state.with_problem(reached.problem), added=model.added, found=(*state.found, *found))
    at = lay_out_state(at.at(reached.q, reached.growth.horizons), base.problem(state.problem, model.disturbances))
    if model.added.terms or base.mechanism is state.problem.space.mechanism:
        return at if model.added.names else replace(at, added=None)
    plain = base.problem(state.problem, model.disturbances)
    return replace(at.with_problem(plain), added=base).at(
        plain.coordinates.point(reached.problem.coordinates.values(reached.q))
    )


def _fit_without_terms(model: AugmentedModel, problem: Problem, q: FloatArray, plain: Problem) -> FloatArray:
    """Fit without a model's terms from its optimum.

    The other parameters are first moved as the derivatives predict.
    """
    terms = model.added.names_by_term
    at = linearise(problem, q, problem.whole_windows(), terms) if terms else None
    starts = [q] if at is None else [at.fit_only(())[1], q]
    for start in starts:
        initial = plain.coordinates.clip(plain.coordinates.point(problem.coordinates.values(start)))
        found = solve(plain, initial, plain.whole_windows(), steps=STAGES.joint_steps, tolerance=1e-6).q
        if not unfollowed_records(plain, found):
            break
    return found


def select_needed_disturbances(reached: GrownModel) -> tuple[tuple[FoundDisturbance, ...], Problem, FloatArray]:
    """Return the disturbances that the joint optimum needs, the problem without the others, and its point."""
    some, problem = reached.model.disturbances, reached.problem
    if not some:
        return (), problem, reached.q
    solution = solve(problem, reached.q, problem.whole_windows(), steps=STAGES.joint_steps, tolerance=1e-6)
    if not np.all(np.isfinite(solution.triangle.jacobian)):
        return tuple(FoundDisturbance(one, 0.0, 0.0) for one in some), problem, reached.q
    named = {one.name: tuple(p.name for p in one.parameters) for one in some}
    samples = sum(t.samples for t in problem.targets)
    groups = groups_of(problem, named)
    rises = needed_groups(solution.triangle, distance_from_null(problem, solution.q), groups, samples)
    # Lines have no coordinates, so `needed_groups` cannot judge them; a fall by chance must not select any.
    for one in (one for one in some if not one.parameters):
        rise = _rise_without_lines(problem, solution.q, one)
        if is_significant(Score(rise, one.dof, 1.0, samples), DURING_FIT):
            rises[one.name] = rise
    lost = [one for one in some if one.name not in rises]
    total = sum(rises.values())
    found = tuple(FoundDisturbance(one, rises[one.name], rises[one.name] / total) for one in some if one.name in rises)
    return found, *remove_disturbances(problem, solution.q, lost)


def _rise_without_lines(problem: Problem, q: FloatArray, lines: Disturbance) -> float:
    """Return the rise of the cost if projected lines are removed."""
    with_them = problem.total_norm(q, problem.whole_windows())
    other, here = remove_disturbances(problem, q, [lines])
    return other.total_norm(here, other.whole_windows()) ** 2 - with_them**2


def fit_with_terms(raised: SearchState, campaign: Campaign, q: FloatArray) -> GrownModel | None:
    """Return all terms fitted at once to whole records, at a raised noise level at which `q` follows them."""
    families = Families(raised.problem, campaign)
    model = families.model(TERMS_AND_RECORDS, near=q)
    if model.problem.size == raised.problem.size:
        return None
    initial = transfer_values(raised.problem, q, model.problem)
    solution = solve(model.problem, initial, model.problem.whole_windows(), steps=STAGES.joint_steps, tolerance=1e-6)
    whole = {t.name: t.samples for t in model.problem.targets}
    return GrownModel(model, Growth(solution.q, whole, not unfollowed_records(model.problem, solution.q), 0))


def accept_at_raised_noise(
    watch: Watch, raised: SearchState, growth: Growth, fitted: GrownModel | None
) -> tuple[SearchState, Growth] | None:
    """Return the state at a raised noise level, with added terms if they are needed.

    None if most of a record is not explained there.
    """
    if fitted is None or not fitted.growth.complete or not explains_most(fitted.problem, fitted.q):
        return None
    if not _needs_terms(fitted.model, fitted.problem, fitted.q):
        alone = watch.note(raised.at(growth.q, growth.horizons))
        return (alone, growth) if explains_most(raised.problem, growth.q) else None
    found, problem, q = select_needed_disturbances(fitted)
    own = tuple(one.disturbance for one in found)
    state = replace(raised.with_problem(problem), found=(*raised.found, *found), added=fitted.model.added)
    written = AddedTerms(raised.problem.space.mechanism)
    plain = lay_out(written, (), missing_tables(written.mechanism, own)).problem(raised.problem, own)
    state = drop_unneeded_terms(state.at(q, fitted.growth.horizons), plain, explains_most)
    return watch.note(state), replace(fitted.growth, q=state.q)


def _needs_terms(model: AugmentedModel, problem: Problem, q: FloatArray) -> bool:
    """Tell whether any term is needed, with each channel at its own residual's level.

    A raised level would hide the need.
    """
    if not model.added.terms:
        return False
    all_terms = linearise(problem, q, problem.whole_windows(), model.added.names_by_term)
    return all_terms is None or bool(all_terms.needed_effects)
