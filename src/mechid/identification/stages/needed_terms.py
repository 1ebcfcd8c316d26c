"""Pruning of the terms that growth has added: the mechanism keeps those that its records need.

Growth frees every term of the superset at once, each held small by a prior. The fit that is kept has only the terms
without which the cost rises by more than k ln N, laid out compactly as a mechanism file would declare them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.beside.beside import Beside, terms_beside
from mechid.identification.beside.groups import groups_of, needed
from mechid.identification.disturbance.scores import by_own_residuals
from mechid.identification.output_error.problem import Problem
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.gates import floors, horizons_at
from mechid.identification.search.solve import solve
from mechid.plant.superset import superset_of

STEPS = 30
"""Of the fits before and after the pruning, which only have to come near their optimum; a choice, not measured."""
NEAR = 1e-4
"""Relative fall of the cost at which the fit of all terms may stop before they are judged; a choice, not measured."""


def drop_unneeded_terms(
    state: SearchState, plain: Problem, follows: Callable[[Problem, FloatArray], bool] | None = None
) -> SearchState:
    """Return a state with the added terms that its records need, refitted without small priors.

    Where the records are not followed with these alone, the small priors are kept; where they are not followed so
    either, all terms are. A law in place of another has nothing to drop.

    Parameters
    ----------
    state : SearchState
        With all terms free, each held small; its records are followed to their ends.
    plain : Problem
        The same records and their disturbances, of the mechanism as written.
    follows : callable or None
        Further condition that a fit with fewer terms has to meet.
    """
    wide = state.beside
    if wide is None or not wide.widths:
        return state
    problem, windows = state.problem, state.problem.whole()
    solution = solve(problem, state.q, windows, steps=STEPS, tolerance=NEAR)
    if not np.all(np.isfinite(solution.triangle.jacobian)):
        return state
    names = needed_terms(problem, solution.q, wide)
    if not names:
        return state
    compact = compact_terms(plain, names)
    values = renamed(problem.coordinates.values(solution.q), wide.new, compact.new)
    for widths in ({}, compact.widths):
        beside = replace(compact, widths=widths)
        tried = beside.problem(plain)
        found = solve(tried, tried.coordinates.point(values), windows, steps=STEPS, tolerance=1e-6)
        if _follows_all(tried, found.q) and (follows is None or follows(tried, found.q)):
            return replace(state.of(tried), beside=beside).at(found.q)
    return state


def needed_terms(problem: Problem, q: FloatArray, beside: Beside) -> frozenset[str]:
    """Return the terms without which the cost rises by more than k ln N, the others free to make up for it.

    Each record counts with its residual's level and as many samples as the residual's colour leaves.
    """
    weighted, worth = by_own_residuals(problem, q, problem.whole())
    triangle = weighted.joint(q, weighted.whole())
    return frozenset(needed(triangle, q, groups_of(weighted, by_term(beside.new)), worth))


def by_term(new: Mapping[str, str]) -> dict[str, list[str]]:
    """Return the dotted names of each term's free parameters, from the term of each parameter."""
    found: dict[str, list[str]] = {}
    for name, term in new.items():
        found.setdefault(term, []).append(name)
    return found


def compact_terms(plain: Problem, names: frozenset[str]) -> Beside:
    """Return the mechanism of a problem with some terms free, laid out without the others."""
    superset = superset_of(plain.space.mechanism, grown_only=True, only=names)
    assert superset is not None, "terms that were free come from the mechanism's own superset"
    return terms_beside(superset, names)


def renamed(values: Mapping[str, float], wide: Mapping[str, str], compact: Mapping[str, str]) -> dict[str, float]:
    """Return values by the names of a compact mechanism, in whose lists entries have moved up.

    Parameters
    ----------
    values : mapping of str to float
        By the names of the wide one.
    wide, compact : mapping of str to str
        The term of each free parameter, in the order of the term's parameters.
    """
    here, there = by_term(compact), by_term(wide)
    moved = {old: new for term in here for old, new in zip(there[term], here[term], strict=True)}
    return {moved.get(name, name): value for name, value in values.items() if name not in wide or name in moved}


def _follows_all(problem: Problem, q: FloatArray) -> bool:
    whole = {t.name: t.samples for t in problem.targets}
    return horizons_at(problem, q, whole, floors(problem)) == whole
