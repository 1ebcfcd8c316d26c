"""Gated growth of horizons: a record counts only as far as the present model follows it.

A small parameter error flips one stick-slip event, and everything after it is meaningless. A fit through such an event
pulls the weakly determined directions away. Each record is therefore used up to its first divergence from the present
model, and this horizon is determined again after every few steps of the solver. The cost is smooth inside the gates,
and better parameters move the next divergence outward until all records are complete.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.computation.journal import Journal
from mechid.identification.output_error.digests import identity
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.search.first_moments import (
    Horizons,
    LiftToAll,
    grow_from_records_at_rest,
    restart_records,
)
from mechid.identification.search.horizons import followed_samples, horizon, horizons_at, least_horizons
from mechid.identification.search.leaps import leap, retreat
from mechid.identification.search.settings import SEARCH
from mechid.identification.search.solve import Solution, solve


@dataclass(frozen=True)
class Growth:
    """Result of gated growth: coordinates, samples of each record that are followed, and whether all are."""

    q: FloatArray
    horizons: Mapping[str, int]
    complete: bool
    rounds: int

    def followed_share(self, problem: Problem) -> float:
        """Return the share of all samples that the model follows."""
        return sum(self.horizons.values()) / sum(t.samples for t in problem.targets)


def grow_horizons(
    problem: Problem,
    q: FloatArray,
    rng: np.random.Generator,
    progress: Callable[[FloatArray, Horizons], None] = lambda q, gates: None,
    *,
    most: float = SEARCH.gate_limit,
    escapes: float = math.inf,
    leaps: int = 0,
    journal: Journal | None = None,
) -> Growth:
    """Grow all horizons from `q` until all records are complete, or until the growth stalls finally.

    Parameters
    ----------
    problem : Problem
    q : (n,)
        Start of the growth.
    rng : Generator
        Source of the escapes' draws.
    progress : callable
        Called with the point and its horizons after each round.
    most : float
        Largest mean square residual of a window that counts as followed, in sigmas squared.
    escapes : float
        Largest number of escapes; the growth ends after an escape that does not help.
    leaps : int
        Number of times that a stalled growth tries a leap, then a retreat, before an escape.
    journal : Journal or None
        Stores the rounds, and supplies those that it already holds.
    """
    if problem.rest_problem is not problem:

        def grow_part(part: Problem, at: FloatArray, lift_to_all: LiftToAll) -> tuple[FloatArray, Horizons]:
            found = grow_horizons(
                part, at, rng, lambda *moved: progress(*lift_to_all(*moved)), most=most, journal=journal
            )
            return found.q, dict(found.horizons)

        q = grow_from_records_at_rest(problem, q, least_horizons(problem), grow_part, partial(_take_rounds, most=most))
    done, own = journal or Journal(), [identity(problem), most]
    least, whole = least_horizons(problem), {t.name: t.samples for t in problem.targets}
    gates = done.step("growth begins", [own, q], partial(_horizons_from_start, problem, q, least, most))
    furthest, stalled = 0, 0
    for rounds in range(1, SEARCH.rounds + 1):
        before = gates
        q, gates, settled = done.step(
            "growth round", [own, q, gates], partial(_take_round, problem, q, gates, least, most)
        )
        progress(q, gates)
        if gates == whole:
            return Growth(q, gates, True, rounds)
        stalled = stalled + 1 if sum(gates.values()) <= furthest else 0
        furthest = max(furthest, sum(gates.values()))
        # A settled solver repeats the same round for ever once the horizons stay too, so no patience is spent on it.
        halted = settled and gates == before
        if leaps > 0 and (halted or stalled):
            leaps -= 1
            past = _pass_stall(done, own, (problem, q, gates, least, most), furthest)
            if past is not None:
                q, gates = past
                progress(q, gates)
                if gates == whole:
                    return Growth(q, gates, True, rounds)
                stalled, furthest = 0, sum(gates.values())
                continue
        if halted or stalled >= SEARCH.patience:
            # Escapes cost the most, hundreds of simulations past the gates, and therefore come last.
            escapes -= 1
            work = partial(_escape, problem, q, gates, least, rng, most)
            escaped = done.step("escape", [own, q, gates], work, rng) if escapes >= 0 else None
            if escaped is None or sum(escaped[1].values()) <= furthest:
                return Growth(q, gates, False, rounds)
            q, gates = escaped
            stalled = 0
    return Growth(q, gates, False, SEARCH.rounds)


def _pass_stall(
    done: Journal, own: list[object], at: tuple[Problem, FloatArray, Horizons, Horizons, float], furthest: int
) -> tuple[FloatArray, Horizons] | None:
    """Try a leap, then a retreat; return the first result that exceeds the furthest reach, or None."""
    for name, move in (("leap", leap), ("retreat", retreat)):
        found = done.step(name, [own, *at[1:3]], partial(move, *at))
        if found is not None and sum(found[1].values()) > furthest:
            return found[0], found[1]
    return None


def _horizons_from_start(problem: Problem, q: FloatArray, least: Horizons, most: float) -> Horizons:
    return {t.name: max(followed_samples(problem, t, q, most=most), least[t.name]) for t in problem.targets}


def _take_round(
    problem: Problem, q: FloatArray, gates: Horizons, least: Horizons, most: float
) -> tuple[FloatArray, Horizons, bool]:
    """Take some solver steps inside the gates; return the point, its horizons, and whether the solver has settled."""
    step = _take_steps(problem, q, gates)
    settled = step.converged or np.array_equal(step.q, q)
    return step.q, horizons_at(problem, step.q, gates, least, most=most), settled


def _take_steps(problem: Problem, q: FloatArray, gates: Mapping[str, int]) -> Solution:
    return solve(problem, q, {name: (0, n) for name, n in gates.items()}, steps=5, tolerance=1e-6)


def _escape(
    problem: Problem, q: FloatArray, gates: Horizons, least: Horizons, rng: np.random.Generator, most: float
) -> tuple[FloatArray, Horizons] | None:
    """Draw from the present posterior, with increasing width, until a point follows the records further.

    Draws are simulated on the unfinished records for some time past their gates. Draws that pass a gate by themselves
    are tried first, both refitted and unchanged. While most of the records is still ahead, the draw of least cost at
    each width is then refitted.
    """
    open_targets = [t for t in problem.targets if gates[t.name] < t.samples]
    initial = _restart_moving_records(problem, q, open_targets, gates, least, most)
    if initial is not None:
        return initial
    root = _posterior_root(problem, q, gates)
    draws = [
        problem.coordinates.clip(q + scale * rng.standard_normal((SEARCH.escape_draws, problem.size)) @ root.T)
        for scale in SEARCH.escape_widths
    ]

    def longer(moved: FloatArray) -> tuple[FloatArray, Horizons] | None:
        found = horizons_at(problem, moved, gates, least, most=most)
        return (moved, found) if sum(found.values()) > sum(gates.values()) else None

    for some in draws:
        gains = [_gain_beyond(problem, open_targets, gates, draw, most) for draw in some]
        for i in [i for i in np.argsort(gains, kind="stable")[::-1][: SEARCH.escape_winners] if gains[i] > 0]:
            found = longer(_refit_draw(problem, some[i], gates, least, most)) or longer(some[i])
            if found:
                return found
    # Draws that pass no gate are refitted only while most of the records is still ahead.
    if 2 * sum(gates.values()) > sum(t.samples for t in problem.targets):
        return None
    for some in draws:
        costs = [_cost_beyond(problem, open_targets, gates, draw) for draw in some]
        i = int(np.argmin(costs))
        found = longer(_refit_draw(problem, some[i], gates, least, most)) if math.isfinite(costs[i]) else None
        if found:
            return found
    return None


def _restart_moving_records(
    problem: Problem, q: FloatArray, targets: list[Target], gates: Horizons, least: Horizons, most: float
) -> tuple[FloatArray, Horizons] | None:
    """Restart the unfinished records that begin in motion from other states; None if no record is followed further."""
    moved = restart_records(problem, q, gates, partial(_take_rounds, most=most), targets=targets)
    if moved is q:
        return None
    found = horizons_at(problem, moved, gates, least, most=most)
    return (moved, found) if sum(found.values()) > sum(gates.values()) else None


def _take_rounds(problem: Problem, q: FloatArray, gates: Horizons, *, most: float) -> tuple[FloatArray, Horizons]:
    """Take rounds of solver steps as long as the horizons grow; return the point and its horizons."""
    for _ in range(SEARCH.start_rounds):
        q = _take_steps(problem, q, gates).q
        further = horizons_at(problem, q, gates, gates, most=most)
        if further == gates:
            break
        gates = further
    return q, gates


def _refit_draw(problem: Problem, q: FloatArray, gates: Horizons, least: Horizons, most: float) -> FloatArray:
    """Refit a draw to as much of the records as it follows, and at least up to the gates."""
    own = horizons_at(problem, q, gates, least, most=most)
    return _take_steps(problem, q, {name: max(gates[name], n) for name, n in own.items()}).q


def _gain_beyond(problem: Problem, targets: list[Target], gates: Horizons, q: FloatArray, most: float) -> int:
    """Return the number of samples past the gates that the model at `q` follows, limited to 80 ms past each gate."""
    gain = 0
    for target in targets:
        gate, past = gates[target.name], int(SEARCH.beyond_s * target.base.sample_rate_hz)
        gain += min(horizon(problem, target.truncate(gate + past), q, gate, 0, most=most), gate + past) - gate
    return gain


def _posterior_root(problem: Problem, q: FloatArray, gates: Horizons) -> FloatArray:
    """Return a square root of the covariance at `q`, (n, n).

    Directions that the data inside the gates do not determine vary over their full range.
    """
    span = problem.coordinates.span
    J = problem.joint(q, {name: (0, n) for name, n in gates.items()}).jacobian * span
    _, s, Vt = np.linalg.svd(np.nan_to_num(J), full_matrices=False)
    # The 1 acts as a prior with one range as its standard deviation, which keeps undetermined directions finite.
    return np.asarray(span[:, None] * Vt.T / np.sqrt(s**2 + 1.0), dtype=np.float64)


def _cost_beyond(problem: Problem, targets: list[Target], gates: Horizons, q: FloatArray) -> float:
    total = 0.0
    for target in targets:
        stop = min(gates[target.name] + int(SEARCH.beyond_s * target.base.sample_rate_hz), target.samples)
        norm = problem.norm(target, q, (0, stop))
        total += norm**2 if math.isfinite(norm) else math.inf
    return total
