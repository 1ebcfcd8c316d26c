"""The joint fit of all that counts, and what is done where it stops at a cliff: a state in, the next one out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.output_error.identity import identity
from mechid.identification.output_error.reduction import Triangle
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.cliffs import along_cliff
from mechid.identification.search.doubts import refused_gain
from mechid.identification.search.settings import SEARCH
from mechid.identification.search.solve import Solution, solve
from mechid.identification.stages.corners import out_of_corner
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.watch import Watch


def joint_fit(
    watch: Watch, state: SearchState, name: str, free: tuple[str, ...], *, tolerance: float = 1e-8
) -> SearchState:
    """Fit all windows to convergence; from beside a singular corner where one has stopped in it.

    A detent that ends beyond the limit of its amplitude is searched by amplitude and phase from there on.
    """
    substeps = state.problem.substeps
    on_progress = partial(watch.tell, name, f"{substeps} step{'s' * (substeps > 1)} a sample")
    evaluations = 0
    while True:
        solved = partial(_solved, watch, state, tolerance, on_progress)
        solution = out_of_corner(state.problem, solved(state.q), solved)
        state = watch.note(replace(state, q=solution.q, solution=solution))
        evaluations += solution.evaluations
        outside = state.problem.space.outside_disc(solution.q)
        if not outside:
            break
        problem, q = state.problem.in_polar(outside, solution.q)
        state = watch.note(replace(state, problem=problem, q=q))
    return watch.close(state, name, free, solution.triangle.cost, evaluations, solution.message)


def _solved(
    watch: Watch, state: SearchState, tolerance: float, on_progress: Callable[[float], None], q: FloatArray
) -> Solution:
    """Return the solution from a point, from the journal where it is there."""
    problem, windows = state.problem, state.windows

    def accepted(better: FloatArray) -> None:
        watch.note(state.at(better))

    def work() -> dict[str, Any]:
        found = solve(problem, q, windows, tolerance=tolerance, progress=on_progress, accepted=accepted)
        return {**vars(found), "triangle": vars(found.triangle)}

    found = watch.journal.step("joint fit", [identity(problem), q, windows, tolerance], work)
    return Solution(**{**found, "triangle": Triangle(**found["triangle"])})


def fit_past_cliffs(watch: Watch, state: SearchState, free: tuple[str, ...], seed: int) -> SearchState:
    """Go on from better points along a cliff at which a joint fit has stopped, while there are any.

    Each fit comes to rest at the cliff's very edge; where finer integration steps would put it beyond, it is taken
    back to a point that they keep on this side, at the cost of a few sigmas squared.
    """
    rng = np.random.default_rng((seed, 0, 0))
    for _ in range(STAGES.most_cliffs):
        if _refused(state) <= SEARCH.notable_fall:
            break
        better = _along_cliff(watch, state, rng, SEARCH.notable_fall)
        if better is None:
            break
        state = joint_fit(watch, watch.note(state.at(better)), "along a threshold", free)
    if _refused(state) > 0.1 and _depends_on_steps(state):
        back = _along_cliff(watch, state, rng, -STAGES.back_from_edge)
        state = state if back is None else watch.note(state.at(back))
    return state


def _along_cliff(watch: Watch, state: SearchState, rng: np.random.Generator, least_gain: float) -> FloatArray | None:
    """Return a better point along a cliff, from the journal where it is there."""
    problem, q, windows = state.problem, state.q, state.windows
    found: FloatArray | None = watch.journal.step(
        "along a threshold",
        [identity(problem), q, windows, least_gain],
        lambda: along_cliff(problem, q, windows, rng, least_gain=least_gain),
        rng,
    )
    return found


def _depends_on_steps(state: SearchState) -> bool:
    """Tell whether the cost of the last joint fit is another one at twice the integration steps."""
    assert state.solution is not None
    fine = replace(state.problem, substeps=2 * state.problem.substeps)
    cost = float(np.sum(np.square(fine.norms(state.q, state.windows))))
    return not abs(cost - state.solution.triangle.cost) < SEARCH.notable_fall


def _refused(state: SearchState) -> float:
    """Return by how much the derivatives promise that the cost falls yet, where the solver called it converged."""
    solution = state.solution
    if solution is None or not solution.converged:
        return 0.0
    return refused_gain(solution.triangle, ~state.problem.coordinates.on_bound(solution.q))


def threshold_warnings(name: str, state: SearchState) -> list[str]:
    """Say where the solver called it converged although its own derivatives promise better."""
    gain = _refused(state)
    if gain <= SEARCH.notable_fall:
        return []
    return [
        f"{name}: the fit stopped at a stick/slip threshold: by its derivatives the cost should still fall by "
        f"{gain:.3g}, but beyond the threshold a stick/slip falls the other way and the cost rises; try another seed, "
        "or a shorter record"
    ]
