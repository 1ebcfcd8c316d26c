"""Growth with terms added to the mechanism, where it does not follow the records as written.

While the branch is still wrong no single effect that is freed helps; many small freedoms together act as a model of
what is missing, and lead to where each can be told. Terms that have a null value are all free at once, each with a
small prior; a law, which has none, replaces one of the mechanism's and has starts of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign import Campaign
from mechid.identification.effects.campaign_disturbances import possible
from mechid.identification.effects.disturbance import Disturbance, Found, without
from mechid.identification.effects.effect import AddedTerms, add_terms, distance_from_null, substitute_law
from mechid.identification.effects.pruning import groups_of, linearise, needed_groups
from mechid.identification.effects.scores import Score
from mechid.identification.effects.selection import is_significant
from mechid.identification.effects.settings import DURING_FIT
from mechid.identification.output_error.problem import Problem, transfer_values
from mechid.identification.readings.agreement import explains
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.gates import Growth, grow_horizons, unfollowed_records
from mechid.identification.search.multistart import Candidate, best_start
from mechid.identification.search.solve import solve
from mechid.identification.stages.needed_terms import drop_unneeded_terms
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.watch import Watch
from mechid.identification.uncertainty.noise_levels import explains_most
from mechid.plant.superset import Superset, rivals_of, superset_of


@dataclass(frozen=True, eq=False)
class AugmentedModel:
    """A problem with added terms and disturbances, and a growth of it."""

    problem: Problem
    added: AddedTerms
    disturbances: tuple[Disturbance, ...]
    growth: Growth

    def at(self, growth: Growth) -> AugmentedModel:
        """Return it with another growth."""
        return replace(self, growth=growth)


def _ungrown(
    problem: Problem, q: FloatArray, added: AddedTerms, disturbances: tuple[Disturbance, ...] = ()
) -> AugmentedModel:
    """Return an augmented model before its growth."""
    return AugmentedModel(problem, added, disturbances, Growth(q, {}, False, 0))


def grow_with_terms(
    watch: Watch, state: SearchState, campaign: Campaign, q: FloatArray, seed: int, fitted: AugmentedModel | None = None
) -> tuple[SearchState, Growth] | None:
    """Return the growth with added terms from a start; None where that does not follow all records either.

    `fitted` is where all terms have been fitted at once at a raised noise level: growth then begins there.
    """
    wide, superset = _augment(state.problem, campaign, q, near=fitted is not None)
    if wide is None:
        return None
    if fitted is not None:
        wide = wide.at(replace(wide.growth, q=fitted.growth.q))
    wide = _grow_augmented(watch, wide, superset, seed)
    return _settle(watch, state, wide, seed) if wide.growth.complete else None


def fit_with_terms(raised: SearchState, campaign: Campaign, q: FloatArray) -> AugmentedModel | None:
    """Return all terms fitted at once to whole records, at a raised noise level at which `q` follows them."""
    wide, _ = _augment(raised.problem, campaign, q, near=True)
    if wide is None:
        return None
    solution = solve(wide.problem, wide.growth.q, wide.problem.whole(), steps=STAGES.joint_steps, tolerance=1e-6)
    whole = {t.name: t.samples for t in wide.problem.targets}
    return wide.at(Growth(solution.q, whole, not unfollowed_records(wide.problem, solution.q), 0))


def accept_at_raised_noise(
    watch: Watch, raised: SearchState, growth: Growth, fitted: AugmentedModel | None
) -> tuple[SearchState, Growth] | None:
    """Return the state at a raised noise level, with added terms where these are needed.

    None where most of a record is not explained there.
    """
    if fitted is None or not fitted.growth.complete or not explains_most(fitted.problem, fitted.growth.q):
        return None
    if not _needs_terms(fitted):
        alone = watch.note(raised.at(growth.q, growth.horizons))
        return (alone, growth) if explains_most(raised.problem, growth.q) else None
    found, problem, q = needed_disturbances(fitted)
    state = replace(raised.of(problem), found=(*raised.found, *found), added=fitted.added)
    plain = AddedTerms(raised.problem.space.mechanism).problem(raised.problem, [one.disturbance for one in found])
    state = drop_unneeded_terms(state.at(q, fitted.growth.horizons), plain, explains_most)
    return watch.note(state), replace(fitted.growth, q=state.q)


def _needs_terms(fitted: AugmentedModel) -> bool:
    """Tell whether any term is needed, each channel at its own residual's level: a raised level hides that."""
    problem = fitted.problem
    all_terms = linearise(problem, fitted.growth.q, problem.whole(), fitted.added.names_by_term)
    return all_terms is None or bool(all_terms.needed)


def _augment(
    plain: Problem, campaign: Campaign, q: FloatArray, *, near: bool = False
) -> tuple[AugmentedModel | None, Superset | None]:
    """Return a problem with all terms and disturbances added, from a start of the one without; and the terms.

    A start that is near leaves hum alone of a record, which shows little of it otherwise.
    """
    superset = superset_of(campaign.mechanism, grown_only=True) if campaign.options.terms else None
    disturbances = possible(plain, campaign, q if near else None)
    if superset is None and not disturbances:
        return None, None
    names = [t.name for t in superset.terms] if superset else []
    added = add_terms(superset, names) if superset else AddedTerms(campaign.mechanism)
    problem = added.problem(plain, disturbances)
    return _ungrown(problem, transfer_values(plain, q, problem), added, disturbances), superset


def _grow_augmented(watch: Watch, wide: AugmentedModel, superset: Superset | None, seed: int) -> AugmentedModel:
    """Grow with all effects; where that stalls, with those not needed inside the gates held closer to their null."""
    whole, wide = wide.problem, wide.at(_grow(watch, wide.problem, wide.growth.q, seed))
    narrower = None if wide.growth.complete else _hold_unneeded_closer(wide, superset)
    if narrower is None:
        return wide
    growth = _grow(watch, narrower.problem, narrower.growth.q, seed)
    return narrower.at(growth) if growth.reached(whole) > wide.growth.reached(whole) else wide


def _grow(watch: Watch, problem: Problem, q: FloatArray, seed: int) -> Growth:
    total = sum(t.samples for t in problem.targets)

    def on_progress(_q: FloatArray, gates: Mapping[str, int]) -> None:
        share = 100.0 * sum(gates.values()) / total
        watch.tell("added terms", f"{share:.1f} % of all samples followed")

    return grow_horizons(
        problem, q, np.random.default_rng((seed, 0, 7)), on_progress, escapes=STAGES.term_escapes, journal=watch.journal
    )


def _groups(wide: AugmentedModel, superset: Superset | None) -> dict[str, tuple[str, ...]]:
    terms = {t.name: tuple(t.widths) for t in superset.terms} if superset else {}
    return terms | {one.name: tuple(p.name for p in one.parameters) for one in wide.disturbances}


def _hold_unneeded_closer(wide: AugmentedModel, superset: Superset | None) -> AugmentedModel | None:
    """Return the problem with what is not needed inside the gates held closer to none; None where all is needed."""
    windows = {name: (0, n) for name, n in wide.growth.horizons.items()}
    solution = solve(wide.problem, wide.growth.q, windows, steps=STAGES.joint_steps, tolerance=1e-6)
    if not np.all(np.isfinite(solution.triangle.jacobian)):
        return None
    groups = groups_of(wide.problem, _groups(wide, superset))
    away = distance_from_null(wide.problem, solution.q)
    kept = needed_groups(solution.triangle, away, groups, sum(wide.growth.horizons.values()))
    if len(kept) == len(groups):
        return None
    terms = superset.terms if superset else ()
    closer = {n: w / STAGES.narrower for t in terms if t.name not in kept for n, w in t.widths.items()}
    added = replace(wide.added, widths={**wide.added.widths, **closer})
    lost = [one for one in wide.disturbances if one.name not in kept]
    q = solution.q - np.where([name in closer for name in wide.problem.coordinates.names], away, 0.0)
    problem, q = without(replace(wide.problem, shrinkage=added.widths), q, lost)
    rest = tuple(one for one in wide.disturbances if one.name in kept)
    return AugmentedModel(problem, added, rest, replace(wide.growth, q=q))


def _settle(watch: Watch, state: SearchState, wide: AugmentedModel, seed: int) -> tuple[SearchState, Growth] | None:
    """Return the state that follows all records, without the disturbances that are not needed.

    Where the mechanism as written follows them from here, it is without terms too. Terms that leave more than it does
    explain nothing: it is grown from here, and None returned where that does not follow all records.
    """
    found, problem, q = needed_disturbances(wide)
    whole = {t.name: t.samples for t in problem.targets}
    own = [one.disturbance for one in found]
    plain = AddedTerms(state.problem.space.mechanism).problem(state.problem, own)
    values = problem.coordinates.values(q)
    alone = solve(plain, plain.coordinates.point(values), plain.whole(), steps=STAGES.joint_steps, tolerance=1e-6).q
    at = replace(state, found=(*state.found, *found))
    follows = not unfollowed_records(plain, alone)
    if not follows and plain.total_norm(alone, plain.whole()) < problem.total_norm(q, problem.whole()):
        growth = _grow(watch, plain, alone, seed)
        if not growth.complete:
            return None
        follows, alone = True, growth.q
    if follows:
        return watch.note(at.of(plain).at(alone, whole)), Growth(alone, whole, True, wide.growth.rounds)
    at = drop_unneeded_terms(replace(at.of(problem), added=wide.added).at(q, whole), plain)
    return watch.note(at), Growth(at.q, whole, True, wide.growth.rounds)


def needed_disturbances(wide: AugmentedModel) -> tuple[tuple[Found, ...], Problem, FloatArray]:
    """Return the disturbances that the joint optimum needs, the problem without the others, and its point."""
    if not wide.disturbances:
        return (), wide.problem, wide.growth.q
    solution = solve(wide.problem, wide.growth.q, wide.problem.whole(), steps=STAGES.joint_steps, tolerance=1e-6)
    if not np.all(np.isfinite(solution.triangle.jacobian)):
        return tuple(Found(one, 0.0, 0.0) for one in wide.disturbances), wide.problem, wide.growth.q
    named = {one.name: tuple(p.name for p in one.parameters) for one in wide.disturbances}
    samples = sum(t.samples for t in wide.problem.targets)
    groups = groups_of(wide.problem, named)
    rises = needed_groups(solution.triangle, distance_from_null(wide.problem, solution.q), groups, samples)
    # Lines have no coordinates, so that `needed_groups` does not see them; a fall by chance must not name any.
    for one in (one for one in wide.disturbances if not one.parameters):
        rise = _rise_without_lines(wide.problem, solution.q, one)
        if is_significant(Score(rise, one.dof, 1.0, samples), DURING_FIT):
            rises[one.name] = rise
    lost = [one for one in wide.disturbances if one.name not in rises]
    total = sum(rises.values())
    found = tuple(
        Found(one, rises[one.name], rises[one.name] / total) for one in wide.disturbances if one.name in rises
    )
    return found, *without(wide.problem, solution.q, lost)


def _rise_without_lines(problem: Problem, q: FloatArray, lines: Disturbance) -> float:
    """Return the rise of the cost without lines that are projected out."""
    with_them = problem.total_norm(q, problem.whole())
    other, here = without(problem, q, [lines])
    return other.total_norm(here, other.whole()) ** 2 - with_them**2


def grow_other_laws(
    watch: Watch, state: SearchState, campaign: Campaign, seed: int
) -> tuple[SearchState, Growth] | None:
    """Return the growth of the first alternative law that follows all records; None where none does.

    Each has a multi-start of its own: with another law of friction the best start is another one. One that explains the
    first moments is grown at once, the others by what they leave of them.
    """
    left: list[tuple[AddedTerms, Candidate]] = []
    for added, best in _law_starts(watch, state, campaign, seed):
        if explains(added.problem(state.problem), best):
            found = _grow_law(watch, state, added, best, seed)
            if found is not None:
                return found
        else:
            left.append((added, best))
    nearest = sorted(left, key=lambda each: each[1].cost)[: STAGES.alternatives]
    grown = (_grow_law(watch, state, added, best, seed) for added, best in nearest)
    return next((found for found in grown if found is not None), None)


def _grow_law(
    watch: Watch, state: SearchState, added: AddedTerms, best: Candidate, seed: int
) -> tuple[SearchState, Growth] | None:
    watch.tell("other laws", f"{', '.join(added.terms)} from its best start")
    wide = _grow_augmented(watch, _ungrown(added.problem(state.problem), best.q, added), None, seed)
    return _settle(watch, state, wide, seed) if wide.growth.complete else None


def _law_starts(
    watch: Watch, state: SearchState, campaign: Campaign, seed: int
) -> Iterator[tuple[AddedTerms, Candidate]]:
    """Yield each law that may stand in place of one chosen, with its best start."""
    for law in rivals_of(campaign.mechanism, grown_only=True) if campaign.options.terms else ():
        added = substitute_law(campaign.mechanism, law)
        problem = added.problem(state.problem)
        watch.tell("other laws", law.name)
        best = best_start(problem, seed, watch.journal)
        if best is not None:
            yield added, best
