"""Whether a joint optimum is confirmed: it follows all records, more strictly and in finer integration steps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.output_error.problem import Problem
from mechid.identification.result.outcome import FitOutcome
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.gates import Growth, chance, floors, grow, horizons_at
from mechid.identification.search.settings import SEARCH
from mechid.identification.stages.joint_fit import fit_past_cliffs, joint_fit
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.watch import Watch
from mechid.identification.uncertainty.noise import by_own_residuals


def confirmed(watch: Watch, state: SearchState, names: tuple[str, ...], seed: int) -> SearchState:
    """See that the joint optimum follows all records, more strictly and in finer steps; else grow from it again.

    A stick/slip that falls the other way for a moment hides below the growth's limit, and one that hangs by
    less than the integration's error is no optimum.
    """
    for attempt in range(1, STAGES.confirmations + 1):
        fine = replace(state.problem, substeps=2 * state.problem.substeps)
        strict = chance(fine)
        judged = by_own_residuals(fine, state.q)
        if not _lost(judged, state.q, most=strict):
            return state
        rng = np.random.default_rng((seed, 0, attempt))
        growth = grow(judged, state.q, rng, partial(_note_regrowth, watch), most=strict, journal=watch.journal)
        if growth.complete or _cost(fine, growth.q) < _cost(fine, state.q):
            state = watch.note(state.of(fine).at(growth.q, {t.name: t.samples for t in fine.targets}))
            state = fit_past_cliffs(watch, joint_fit(watch, state, "growth again", names), names, seed)
        if not growth.complete:
            if _lost(by_own_residuals(state.problem, state.q), state.q, most=strict):
                state = watch.note(state.saying(_suspicion(growth, fine)))
            break
    lost = _lost(by_own_residuals(state.problem, state.q), state.q)
    if not lost:
        return state
    said = f"{', '.join(lost)}: for a moment the residual is larger than elsewhere by more than chance"
    return watch.note(state.ending(FitOutcome.EVENT_MISSED).saying(said))


def _cost(problem: Problem, q: FloatArray) -> float:
    return float(np.sum(np.square(problem.norms(q, problem.whole()))))


def _suspicion(growth: Growth, problem: Problem) -> str:
    """Say where a record is followed less well than noise and integration error allow."""
    at = {
        t.name: growth.horizons[t.name] / t.base.sample_rate_hz
        for t in problem.targets
        if growth.horizons[t.name] < t.samples
    }
    places = ", ".join(f"record {name} at {seconds:.4g} s" for name, seconds in at.items())
    return (
        f"{places}: near a stick/slip threshold: a stick/slip falls the other way than measured, or does so in finer "
        "integration steps, and no estimate near by was found that settles it"
    )


def _lost(problem: Problem, q: FloatArray, *, most: float = SEARCH.diverged_at) -> list[str]:
    """Return the records that the model at `q` does not follow to their ends."""
    whole = {t.name: t.samples for t in problem.targets}
    found = horizons_at(problem, q, whole, floors(problem), most=most)
    return [name for name, n in whole.items() if found[name] < n]


def _note_regrowth(watch: Watch, q: FloatArray, gates: Mapping[str, int]) -> None:
    share = 100.0 * sum(gates.values()) / sum(t.samples for t in watch.latest.problem.targets)
    watch.tell("growth again", f"{share:.1f} % of all samples followed")
