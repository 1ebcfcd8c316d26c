"""Pruning of the terms that growth has added to those that the records need.

Growth frees every term of the superset at once, each with a small prior. The final fit has only those terms without
which the cost rises by more than k ln N, laid out as a mechanism file would declare them.

Unlike `effects.selection.drop_unneeded`, which uses an F test, it compares fits by their cost at the problem's noise
levels. Only fits that follow all records to their ends are candidates.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from mechid.arrays import FloatArray
from mechid.identification.effects.effect import AddedTerms, lay_out, rename_values
from mechid.identification.effects.pruning import Linearisation, linearise
from mechid.identification.effects.scores import bayesian_penalty
from mechid.identification.output_error.problem import Problem
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.horizons import unfollowed_records
from mechid.identification.search.solve import solve
from mechid.identification.stages.settings import STAGES

Follows = Callable[[Problem, FloatArray], bool]


def exchanges(all_terms: Linearisation, kept: frozenset[str]) -> Iterator[frozenset[str]]:
    """Yield sets of terms in which one kept term is replaced by another that explains nearly as much."""
    least = all_terms.fit_only(kept)[0]
    found: list[tuple[float, frozenset[str]]] = []
    for name in sorted(kept):
        allowed = STAGES.exchange_margin * (all_terms.fit_only(kept - {name})[0] - least)
        for other in sorted(all_terms.groups.keys() - kept):
            names = kept - {name} | {other}
            more = all_terms.fit_only(names)[0] - least
            if more <= max(allowed, bayesian_penalty(all_terms.effective_samples)):
                found.append((more, names))
    yield from (names for _, names in sorted(found, key=lambda each: each[0])[: STAGES.exchanges])


def drop_unneeded_terms(state: SearchState, plain: Problem, follows: Follows | None = None) -> SearchState:
    """Return a state with the added terms that its records need, refitted without small priors.

    Sets in which one term is exchanged for another that explains as much by its derivatives are fitted too, and the
    best fit is kept. If no such set follows the records, all terms are kept with their small priors. A law in place of
    another has nothing to drop.

    Parameters
    ----------
    state : SearchState
        State with all terms free, each with a small prior; its records are followed to their ends.
    plain : Problem
        Problem of the same records and disturbances, with the mechanism as written.
    follows : callable or None
        Further condition on a fit with fewer terms.
    """
    if state.added is None or not state.added.terms:
        return state
    q = solve(
        state.problem, state.q, state.problem.whole_windows(), steps=STAGES.joint_steps, tolerance=STAGES.near_tolerance
    ).q
    all_terms = linearise(state.problem, q, state.problem.whole_windows(), state.added.names_by_term)
    if all_terms is None:
        return state
    kept = all_terms.needed_effects
    fits = _fit_selections([kept, *exchanges(all_terms, kept)] if kept else [], all_terms, state, follows)
    if not fits:
        return state
    best = min(fits, key=lambda fit: fit.criterion)
    aliases = best.aliases(fits)
    # The derivatives at the optimum of all terms may keep some unneeded ones.
    for name in sorted(best.names):
        for fit in _fit_selections([best.names - {name}] if len(best.names) > 1 else [], all_terms, state, follows):
            best = min(best, fit, key=lambda each: each.criterion)
    aliases = {name: others for name, others in aliases.items() if name in best.names}
    return _lay_out_selection(state, state.added, best, plain, aliases)


@dataclass(frozen=True, eq=False)
class TermSelection:
    """Fit with some terms free and the others held at their null value, and its Bayesian criterion."""

    names: frozenset[str]
    problem: Problem
    q: FloatArray
    criterion: float

    def aliases(self, others: Sequence[TermSelection]) -> dict[str, tuple[str, ...]]:
        """Return, for each term, those that replace it in other fits that are no worse."""
        alike = [
            o.names for o in others if o.criterion - self.criterion < STAGES.alike and len(self.names - o.names) == 1
        ]
        return {
            n: tuple(sorted(x for names in alike if n not in names for x in names - self.names)) for n in self.names
        }


def _fit_selections(
    sets: Sequence[frozenset[str]], all_terms: Linearisation, state: SearchState, follows: Follows | None
) -> list[TermSelection]:
    """Return the fits with sets of terms that follow the records, on the plant of all terms: nothing is compiled."""
    wide = state.added
    assert wide is not None
    fits = []
    for names in sets:
        # A narrow prior at zero replaces removing the coordinate, which keeps the compiled plant.
        held = {name: STAGES.held_share * width for name, width in wide.widths.items() if wide.new[name] not in names}
        problem = replace(state.problem, shrinkage=held)
        whole = problem.whole_windows()
        q = solve(
            problem, all_terms.fit_only(names)[1], whole, steps=STAGES.joint_steps, tolerance=STAGES.rough_tolerance
        ).q
        # A lower cost is worth nothing if a record is left early.
        if not unfollowed_records(problem, q) and (follows is None or follows(problem, q)):
            count = sum(len(all_terms.groups[name]) for name in names)
            criterion = problem.total_norm(q, whole) ** 2 + count * bayesian_penalty(all_terms.effective_samples)
            fits.append(TermSelection(names, problem, q, criterion))
    return fits


def _lay_out_selection(
    state: SearchState, wide: AddedTerms, fit: TermSelection, plain: Problem, aliases: Mapping[str, tuple[str, ...]]
) -> SearchState:
    """Return a state of the mechanism with only the terms of a fit, without small priors."""
    law = {name: of for name, of in wide.new.items() if of == wide.law}
    base = AddedTerms(plain.space.mechanism, new=law, law=wide.law)
    added = replace(lay_out(base, fit.names), aliases=aliases)
    problem = added.problem(plain)
    values = rename_values(fit.problem.coordinates.values(fit.q), wide, added)
    return replace(state.with_problem(problem), added=added).at(problem.coordinates.point(values))


def lay_out_state(state: SearchState, plain: Problem) -> SearchState:
    """Return a state with the same added terms and values, and no place for other terms."""
    if state.added is None or not state.added.terms:
        return state
    fit = TermSelection(frozenset(state.added.terms), state.problem, state.q, math.nan)
    return _lay_out_selection(state, state.added, fit, plain, {})
