"""Pruning of the terms that growth has added: the mechanism keeps those that its records need.

Growth frees every term of the superset at once, each held small by a prior. The fit that is kept has only the terms
without which the cost rises by more than k ln N, laid out as a mechanism file would declare them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.effects.effect import Beside, terms_beside
from mechid.identification.effects.pruning import Groups, groups_of, least_without, needed_groups
from mechid.identification.effects.scores import by_own_residuals
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.reduction import Triangle
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.gates import horizons_at, least_horizons
from mechid.identification.search.solve import solve
from mechid.identification.stages.settings import STAGES
from mechid.plant.superset import superset_of

Follows = Callable[[Problem, FloatArray], bool]


@dataclass(frozen=True, eq=False)
class Judged:
    """A fit of all terms, with its derivatives: each record at its residual's level and worth."""

    problem: Problem
    q: FloatArray
    triangle: Triangle
    groups: Groups
    worth: float

    @property
    def needed(self) -> frozenset[str]:
        """Terms without which the cost rises by more than k ln N, the others free to make up for it."""
        return frozenset(needed_groups(self.triangle, self.q, self.groups, self.worth))

    def without(self, kept: frozenset[str]) -> tuple[float, FloatArray]:
        """Return the least cost with some terms alone, and the point where it is, as the derivatives have it."""
        cost, step = least_without(self.triangle, self.q, self.groups, self.groups.keys() - kept)
        bounds = self.problem.coordinates
        return cost, np.clip(self.q + step, bounds.lower, bounds.upper)

    def exchanged(self, kept: frozenset[str]) -> Iterator[frozenset[str]]:
        """Yield sets of terms in which one of those kept has another in its place that explains nearly as much."""
        least = self.without(kept)[0]
        found: list[tuple[float, frozenset[str]]] = []
        for name in sorted(kept):
            allowed = STAGES.exchange_margin * (self.without(kept - {name})[0] - least)
            for other in sorted(self.groups.keys() - kept):
                names = kept - {name} | {other}
                more = self.without(names)[0] - least
                if more <= max(allowed, math.log(max(self.worth, math.e))):
                    found.append((more, names))
        yield from (names for _, names in sorted(found, key=lambda each: each[0])[: STAGES.exchanges])


def drop_unneeded_terms(state: SearchState, plain: Problem, follows: Follows | None = None) -> SearchState:
    """Return a state with the added terms that its records need, refitted without small priors.

    A set of terms in which one is exchanged for another that explains as much by its derivatives is fitted too, and the
    better one kept. Where the records are not followed with any such set, all terms are kept, each held small. A law in
    place of another has nothing to drop.

    Parameters
    ----------
    state : SearchState
        With all terms free, each held small; its records are followed to their ends.
    plain : Problem
        The same records and their disturbances, of the mechanism as written.
    follows : callable or None
        Further condition that a fit with fewer terms has to meet.
    """
    if state.beside is None or state.beside.is_law:
        return state
    q = solve(
        state.problem, state.q, state.problem.whole(), steps=STAGES.joint_steps, tolerance=STAGES.near_tolerance
    ).q
    all_terms = judged(state.problem, q, state.beside)
    if all_terms is None:
        return state
    kept = all_terms.needed
    fits = _fits_of([kept, *all_terms.exchanged(kept)] if kept else [], all_terms, state, follows)
    if not fits:
        return state
    best = min(fits, key=lambda fit: fit.criterion)
    aliases = best.aliases(fits)
    for name in sorted(best.names):  # derivatives at the optimum of all terms keep some that a fit does not need
        for fit in _fits_of([best.names - {name}] if len(best.names) > 1 else [], all_terms, state, follows):
            best = min(best, fit, key=lambda each: each.criterion)
    laid_out = _laid_out(state, state.beside, best, plain)
    assert laid_out.beside is not None
    aliases = {name: others for name, others in aliases.items() if name in best.names}
    return replace(laid_out, beside=replace(laid_out.beside, aliases=aliases))


def judged(problem: Problem, q: FloatArray, beside: Beside) -> Judged | None:
    """Return a fit of all terms with what its derivatives tell of each; None where it cannot be simulated."""
    weighted, worth = by_own_residuals(problem, q, problem.whole())
    triangle = weighted.joint(q, weighted.whole())
    if not np.all(np.isfinite(triangle.jacobian)):
        return None
    return Judged(weighted, q, triangle, groups_of(weighted, _by_term(beside.new)), worth)


@dataclass(frozen=True, eq=False)
class Fitted:
    """A fit with some terms free and the others held at nothing, and its Bayesian criterion."""

    names: frozenset[str]
    problem: Problem
    q: FloatArray
    criterion: float

    def aliases(self, others: Sequence[Fitted]) -> dict[str, tuple[str, ...]]:
        """Return the terms that other fits have in place of one of its own, and are no worse with, by that one."""
        alike = [
            o.names for o in others if o.criterion - self.criterion < STAGES.alike and len(self.names - o.names) == 1
        ]
        return {
            n: tuple(sorted(x for names in alike if n not in names for x in names - self.names)) for n in self.names
        }


def _fits_of(
    sets: Sequence[frozenset[str]], all_terms: Judged, state: SearchState, follows: Follows | None
) -> list[Fitted]:
    """Return the fits with sets of terms that follow the records, on the plant of all terms: nothing is compiled."""
    wide = state.beside
    assert wide is not None
    fits = []
    for names in sets:
        held = {name: STAGES.held_share * width for name, width in wide.widths.items() if wide.new[name] not in names}
        problem = replace(state.problem, shrinkage=held)
        whole = problem.whole()
        q = solve(
            problem, all_terms.without(names)[1], whole, steps=STAGES.joint_steps, tolerance=STAGES.rough_tolerance
        ).q
        if _follows_all(problem, q) and (follows is None or follows(problem, q)):
            count = sum(len(all_terms.groups[name]) for name in names)
            criterion = problem.total_norm(q, whole) ** 2 + count * math.log(max(all_terms.worth, math.e))
            fits.append(Fitted(names, problem, q, criterion))
    return fits


def _laid_out(state: SearchState, wide: Beside, fit: Fitted, plain: Problem) -> SearchState:
    """Return a state of the mechanism with the terms of a fit, without small priors, laid out without the others."""
    superset = superset_of(plain.space.mechanism, grown_only=True, only=fit.names)
    assert superset is not None, "terms that were free come from the mechanism's own superset"
    beside = replace(terms_beside(superset, fit.names), widths={})
    problem = beside.problem(plain)
    values = _renamed(fit.problem.coordinates.values(fit.q), wide.new, beside.new)
    return replace(state.of(problem), beside=beside).at(problem.coordinates.point(values))


def _renamed(values: Mapping[str, float], wide: Mapping[str, str], compact: Mapping[str, str]) -> dict[str, float]:
    """Return values by the names of a compact mechanism, in whose lists entries have moved up.

    Parameters
    ----------
    values : mapping of str to float
        By the names of the wide one.
    wide, compact : mapping of str to str
        The term of each free parameter, in the order of the term's parameters.
    """
    here, there = _by_term(compact), _by_term(wide)
    moved = {old: new for term in here for old, new in zip(there[term], here[term], strict=True)}
    return {moved.get(name, name): value for name, value in values.items() if name in moved or name not in wide}


def _by_term(new: Mapping[str, str]) -> dict[str, list[str]]:
    """Return the dotted names of each term's free parameters, from the term of each parameter."""
    found: dict[str, list[str]] = {}
    for name, term in new.items():
        found.setdefault(term, []).append(name)
    return found


def _follows_all(problem: Problem, q: FloatArray) -> bool:
    whole = {t.name: t.samples for t in problem.targets}
    return horizons_at(problem, q, whole, least_horizons(problem)) == whole
