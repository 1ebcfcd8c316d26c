"""Joint fit of all records: with escapes from singular corners and cliffs, and confirmed with finer steps.

If a fit has reduced static friction to Coulomb friction, the speed of the transition between them has no effect, and no
derivative leads back. The fit then restarts from points next to this corner.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.output_error.digests import identity
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.reduction import Triangle
from mechid.identification.result.grade import FitOutcome
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.gates import Growth, grow_horizons
from mechid.identification.search.horizons import chance_limit, unfollowed_records
from mechid.identification.search.settings import SEARCH
from mechid.identification.search.solve import Solution, predicted_reduction, search_cliff, solve
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.watch import Watch
from mechid.identification.uncertainty.noise import set_residual_levels
from mechid.identification.uncertainty.verdict import seen_coordinates


def is_on_file_bound(problem: Problem, q: FloatArray) -> bool:
    """Tell whether any coordinate lies on a bound of the mechanism file or of a record.

    A parameter at the limit set by another one, as static friction at Coulomb friction, does not count: a law of
    friction may be missing.
    """
    kinds = [c.kind for c in problem.coordinates.space.coordinates]
    kinds += [""] * (problem.size - len(kinds))
    return any(held and kind != "excess" for held, kind in zip(problem.coordinates.on_bound(q), kinds, strict=True))


def leave_corner(problem: Problem, stopped: Solution, solved: Callable[[FloatArray], Solution]) -> Solution:
    """Return the best of a fit that stopped, and of fits restarted next to any corner in which it stopped.

    `solved` fits from a point. If `stopped` is in no corner, it is returned without a further fit.
    """
    best = stopped
    for q in _points_beside_corners(problem, stopped):
        found = solved(q)
        if found.triangle.cost < best.triangle.cost - SEARCH.notable_fall:
            best = found
    return best


def _points_beside_corners(problem: Problem, stopped: Solution) -> Iterator[FloatArray]:
    """Yield restart points next to each corner that contains a solution."""
    space, q = problem.space, stopped.q
    at, values = problem.coordinates.of_mechanism(q), problem.space.values(problem.coordinates.of_mechanism(q))
    seen = seen_coordinates(problem, stopped.triangle)
    unseen = [c.name for c, sees in zip(space.coordinates, seen, strict=False) if not sees and space.stands_alone(c)]
    for c, excess in zip(space.coordinates, at, strict=True):
        # Only parameters of the same block lose their effect in the corner.
        hidden = [name for name in unseen if _table(name) == _table(c.name)]
        if c.kind != "excess" or excess > STAGES.corner_share * abs(values[c.below]) or not hidden:
            continue
        known = space.mechanism.parameters
        lowered = {c.below: STAGES.lowered * values[c.name]} if known[c.below].is_free else {}
        for factor in STAGES.spread:
            moved = {name: factor * known[name].value for name in hidden}
            initial = space.from_values({n: p.value for n, p in known.items()} | values | lowered | moved)
            yield np.concatenate([initial, problem.coordinates.of_records(q)])


def _table(name: str) -> str:
    return name.rpartition(".")[0]


def joint_fit(
    watch: Watch, state: SearchState, name: str, free: tuple[str, ...], *, tolerance: float = 1e-8
) -> SearchState:
    """Fit all windows to convergence, with restarts next to a singular corner in which the fit stops.

    A detent that ends beyond the limit of its amplitude is from then on searched by amplitude and phase.
    """
    substeps = state.problem.substeps
    on_progress = partial(watch.tell, name, f"{substeps} step{'s' * (substeps > 1)} a sample")
    evaluations = 0
    while True:
        solved = partial(_solve, watch, state, tolerance, on_progress)
        solution = leave_corner(state.problem, solved(state.q), solved)
        state = watch.note(replace(state, q=solution.q, solution=solution))
        evaluations += solution.evaluations
        # Cosine and sine are bounded by a square, so that a fit may end outside the disc of the amplitude's limit.
        outside = state.problem.space.outside_disc(solution.q)
        if not outside:
            break
        problem, q = state.problem.to_polar(outside, solution.q)
        state = watch.note(replace(state, problem=problem, q=q))
    return watch.close(state, name, free, solution.triangle.cost, evaluations, solution.message)


def _solve(
    watch: Watch, state: SearchState, tolerance: float, on_progress: Callable[[float], None], q: FloatArray
) -> Solution:
    """Return the solution from a point, from the journal if it is there."""
    problem, windows = state.problem, state.windows

    def note_better(better: FloatArray) -> None:
        watch.note(state.at(better))

    def work() -> dict[str, Any]:
        found = solve(problem, q, windows, tolerance=tolerance, progress=on_progress, accepted=note_better)
        return {**vars(found), "triangle": vars(found.triangle)}

    found = watch.journal.step("joint fit", [identity(problem), q, windows, tolerance], work)
    return Solution(**{**found, "triangle": Triangle(**found["triangle"])})


def fit_past_cliffs(watch: Watch, state: SearchState, free: tuple[str, ...], seed: int) -> SearchState:
    """Continue from better points along a cliff at which a joint fit has stopped, as long as there are any.

    Each fit stops at the very edge of the cliff. If finer integration steps would put it beyond the edge, it is moved
    back to a point that is on this side with those steps as well, at the cost of a few sigmas squared.
    """
    rng = np.random.default_rng((seed, 0, 0))
    for _ in range(STAGES.most_cliffs):
        if _unused_reduction(state) <= SEARCH.notable_fall:
            break
        # A lower cost than this counts as progress, so the loop cannot continue on rounding errors.
        better = _search_cliff(watch, state, rng, SEARCH.notable_fall)
        if better is None:
            break
        state = joint_fit(watch, watch.note(state.at(better)), "along a threshold", free)
    if _unused_reduction(state) > 0.1 and _depends_on_steps(state):
        back = _search_cliff(watch, state, rng, -STAGES.back_from_edge)
        state = state if back is None else watch.note(state.at(back))
    return state


def _search_cliff(watch: Watch, state: SearchState, rng: np.random.Generator, least_gain: float) -> FloatArray | None:
    """Return a better point along a cliff, from the journal if it is there."""
    problem, q, windows = state.problem, state.q, state.windows
    found: FloatArray | None = watch.journal.step(
        "along a threshold",
        [identity(problem), q, windows, least_gain],
        lambda: search_cliff(problem, q, windows, rng, least_gain=least_gain),
        rng,
    )
    return found


def _depends_on_steps(state: SearchState) -> bool:
    """Tell whether the cost of the last joint fit changes with twice the integration steps."""
    assert state.solution is not None
    fine = replace(state.problem, substeps=2 * state.problem.substeps)
    cost = float(np.sum(np.square(fine.norms(state.q, state.windows))))
    return not abs(cost - state.solution.triangle.cost) < SEARCH.notable_fall


def _unused_reduction(state: SearchState) -> float:
    """Return the reduction of the cost that the derivatives still predict after convergence."""
    solution = state.solution
    if solution is None or not solution.converged:
        return 0.0
    return predicted_reduction(solution.triangle, ~state.problem.coordinates.on_bound(solution.q))


def warn_of_thresholds(name: str, state: SearchState) -> list[str]:
    """Return a warning if the derivatives still predict a lower cost although the solver has converged."""
    gain = _unused_reduction(state)
    if gain <= SEARCH.notable_fall:
        return []
    return [
        f"{name}: the fit stopped at a stick/slip threshold: by its derivatives the cost should still fall by "
        f"{gain:.3g}, but beyond the threshold a stick/slip event flips and the cost rises; try another seed, "
        "or a shorter record"
    ]


def confirm_optimum(watch: Watch, state: SearchState, names: tuple[str, ...], seed: int) -> SearchState:
    """Check with a stricter limit and finer steps that the joint optimum follows all records.

    Otherwise, grow from it again. A stick-slip event that flips for a moment is hidden below the growth's limit, and an
    optimum that depends on one within the integration error is not real.
    """
    for attempt in range(1, STAGES.confirmations + 1):
        fine = replace(state.problem, substeps=2 * state.problem.substeps)
        strict = chance_limit(fine)
        # The strict limit is one of chance, so each record is judged by its own residual level.
        judged = set_residual_levels(fine, state.q)
        if not unfollowed_records(judged, state.q, most=strict):
            return state
        rng = np.random.default_rng((seed, 0, attempt))
        growth = grow_horizons(judged, state.q, rng, partial(_note_regrowth, watch), most=strict, journal=watch.journal)
        if growth.complete or _cost(fine, growth.q) < _cost(fine, state.q):
            state = watch.note(state.with_problem(fine).at(growth.q, {t.name: t.samples for t in fine.targets}))
            state = fit_past_cliffs(watch, joint_fit(watch, state, "growth again", names), names, seed)
        if not growth.complete:
            if unfollowed_records(set_residual_levels(state.problem, state.q), state.q, most=strict):
                state = watch.note(state.with_warnings(_suspicion(growth, fine)))
            break
    lost = unfollowed_records(set_residual_levels(state.problem, state.q), state.q)
    if not lost:
        return state
    said = f"{', '.join(lost)}: the residual is for a moment larger than elsewhere, by more than chance"
    return watch.note(state.with_outcome(FitOutcome.EVENT_MISSED).with_warnings(said))


def _cost(problem: Problem, q: FloatArray) -> float:
    return float(np.sum(np.square(problem.norms(q, problem.whole_windows()))))


def _suspicion(growth: Growth, problem: Problem) -> str:
    """Return a sentence about records that are followed less well than noise and integration error allow."""
    at = {
        t.name: growth.horizons[t.name] / t.base.sample_rate_hz
        for t in problem.targets
        if growth.horizons[t.name] < t.samples
    }
    places = ", ".join(f"record {name} at {seconds:.4g} s" for name, seconds in at.items())
    return (
        f"{places}: near a stick/slip threshold: a stick/slip event differs from the measured one, or flips with finer "
        "integration steps, and no nearby estimate resolves it"
    )


def _note_regrowth(watch: Watch, q: FloatArray, gates: Mapping[str, int]) -> None:
    share = 100.0 * sum(gates.values()) / sum(t.samples for t in watch.latest.problem.targets)
    watch.tell("growth again", f"{share:.1f} % of all samples followed")
