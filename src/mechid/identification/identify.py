"""Identify: from a campaign to a fit, by the user's stages or by the plan made without them."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from mechid.campaign import Campaign
from mechid.errors import FitError
from mechid.identification.computation.journal import Journal
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.computation.progress import Listener, silent
from mechid.identification.conclude import conclude
from mechid.identification.contradiction.agreement import Agreement, agreement, explains
from mechid.identification.contradiction.agreement_text import agreement_warnings
from mechid.identification.contradiction.common_reading import common_readings
from mechid.identification.contradiction.departure import departure
from mechid.identification.identifiability.ambiguity import refuse_free_voltage
from mechid.identification.output_error.accuracy import enough_substeps
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import target_of
from mechid.identification.result.fit import Fit, FitOutcome
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.gates import DIVERGED_AT, Growth, chance, floors, grow, horizons_at
from mechid.identification.search.multistart import POINTS, Candidate, candidates, multistart
from mechid.identification.stages.freeze import freeze_dependent
from mechid.identification.stages.joint_fit import cliff_warnings, fit_past_cliffs, joint_fit
from mechid.identification.stages.own_stages import follow_stages
from mechid.identification.stages.release import fit_with_noise_released
from mechid.identification.stages.watch import Watch
from mechid.identification.uncertainty.noise import (
    at_least_their_residuals,
    by_own_residuals,
    rejection_warnings,
    without_spikes,
)

FloatArray = NDArray[np.float64]
TRIED_CANDIDATES = 12
CONFIRMATIONS = 2
ROUGH = 1e-6
"""Relative fall of the cost at which the fit before the release of the noise may stop."""
LONGEST_STEP_S = 2e-4
"""Integration steps at most this long are stable also where a start's viscous friction is far too large."""


def identify(
    campaign: Campaign,
    *,
    seed: int = 0,
    workers: int | None = None,
    listener: Listener = silent,
    journal: Journal | None = None,
    near: Mapping[str, float] | None = None,
) -> Fit:
    """Identify the free parameters of a campaign's mechanism from its records.

    Parameters
    ----------
    campaign : Campaign
    seed : int
        Of the search; equal seeds give equal results.
    workers : int or None
        Threads; None takes one per core.
    listener : callable
        Told of progress.
    journal : Journal or None
        Where what is worked out is noted, and taken from if it is there already.
    near : mapping of str to float or None
        Values by name, in the file's units, that are close to the optimum, so that what they leave of the records is
        noise. Search and confirmation are left out; they have no effect where the file has stages.

    Returns
    -------
    Fit
        Also where the fit did not succeed or was interrupted: its `outcome` says so.

    Raises
    ------
    FitError
        If nothing is free, or no record is to be estimated from.
    """
    problem = make_problem(campaign, workers or os.cpu_count() or 1)
    state = SearchState(problem, problem.start, problem.whole())
    watch = Watch(state, listener, len(campaign.stages) or 4, journal)
    with one_core_algebra():
        try:
            if campaign.stages:
                state = follow_stages(watch, state, campaign)
            else:
                state = _follow_plan(watch, state, campaign, seed, near)
            if state.outcome.good or state.outcome in (FitOutcome.CLIFF, FitOutcome.NOT_CONVERGED):
                state = freeze_dependent(watch, state, campaign)
        except KeyboardInterrupt:
            state = watch.latest.ending(FitOutcome.INTERRUPTED)
        state = state.saying(*rejection_warnings(state.problem))
        try:
            return conclude(campaign, state, seed, watch.seconds)
        except KeyboardInterrupt:  # what was found is not lost; an interrupted fit is not tested by draws
            return conclude(campaign, state.ending(FitOutcome.INTERRUPTED), seed, watch.seconds)


def make_problem(campaign: Campaign, workers: int) -> Problem:
    """Return the output-error problem of the records that are to be estimated from."""
    if not campaign.mechanism.free:
        raise FitError(
            f"{campaign.mechanism_path}: nothing to estimate: every parameter is a bare number; "
            "give those to be estimated as { value, min, max }"
        )
    refuse_free_voltage(campaign)
    targets = tuple(target_of(r) for r in campaign.estimated)
    if campaign.options.spikes == "reject":
        targets = tuple(map(without_spikes, targets))
    if not targets:
        raise FitError(f'{campaign.path}: no record has use = "estimate"; there is nothing to estimate from')
    longest = max(t.base.interval_s for t in targets)
    substeps = max(1, math.ceil(longest / LONGEST_STEP_S - 1e-6))
    priors = {} if campaign.options.priors == "none" else _priors(campaign)
    return Problem(SearchSpace(campaign.mechanism), targets, priors, substeps=substeps, workers=workers)


def _priors(campaign: Campaign) -> dict[str, tuple[float, float]]:
    """Return value and standard deviation of what the mechanism file knows beforehand."""
    return {q.name: (q.value, q.sigma) for q in campaign.free if q.sigma}


def _follow_plan(
    watch: Watch, state: SearchState, campaign: Campaign, seed: int, near: Mapping[str, float] | None
) -> SearchState:
    """Multi-start on the first moments, gated growth to the records' ends, joint fit, noise released."""
    names = (*(p.name for p in campaign.mechanism.free), *state.problem.coordinates.own_names)
    state, growth = _search(watch, state, campaign, names, seed) if near is None else _vouched(state, near)
    if growth is None:
        return state
    names = (*names, *(n for n in state.problem.coordinates.own_names if n not in names))
    left_out = any(t.left_out for t in state.taken.values())
    whole = growth.complete and not left_out
    state = state.at(growth.q, growth.horizons).ending(FitOutcome.CONVERGED if whole else FitOutcome.HORIZON)
    state = watch.note(state.saying(*_horizon_warnings(state.problem, growth)))
    substeps = enough_substeps(state.problem, state.q, state.windows)
    state = watch.note(state.of(replace(state.problem, substeps=substeps)))
    state = joint_fit(watch, state, "joint fit", names, tolerance=ROUGH)
    state = fit_with_noise_released(watch, state, campaign.options, names)
    if growth.complete and near is None:
        state = _confirmed(watch, state, names, seed)
    return watch.note(_judged(fit_past_cliffs(watch, state, names, seed)))


def _judged(state: SearchState) -> SearchState:
    """Return the state at the end of the plan with what its last joint fit leaves in doubt."""
    said = cliff_warnings("noise released", state)
    state = state.saying(*said)
    if state.outcome is FitOutcome.CONVERGED and said:
        return state.ending(FitOutcome.CLIFF)
    if state.outcome is FitOutcome.CONVERGED and not state.converged:
        return state.ending(FitOutcome.NOT_CONVERGED)
    return state


def _search(
    watch: Watch, state: SearchState, campaign: Campaign, names: tuple[str, ...], seed: int
) -> tuple[SearchState, Growth | None]:
    """Return the growth from the best starts, or None where none of them can be simulated."""
    found = _candidates(watch, state, seed)
    best = next(found, None)
    state = state.at(best.q) if best else state
    state = watch.close(state, "multi-start", names, best.cost if best else math.inf, POINTS)
    if best is None:
        return state, None
    state, growth = _grown(watch, state, campaign, best, found, seed)
    state = state.at(growth.q, growth.horizons)
    followed = "all records followed to their ends" if growth.complete else "not all records followed"
    return watch.close(state, "gated growth", names, math.nan, growth.rounds, followed), growth


def _vouched(state: SearchState, near: Mapping[str, float]) -> tuple[SearchState, Growth]:
    """Return values already near the optimum as a growth that has come to the records' ends.

    Who gives them vouches for them: what they leave of a record is its noise, also where that is coloured, so that
    the high-frequency floor is none.
    """
    problem, q = state.problem, state.problem.coordinates.point(near)
    problem = replace(problem, targets=tuple(at_least_their_residuals(problem, t, q) for t in problem.targets))
    return state.of(problem), Growth(q, {t.name: t.samples for t in problem.targets}, True, 0)


def _grown(
    watch: Watch, state: SearchState, campaign: Campaign, best: Candidate, found: Iterator[Candidate], seed: int
) -> tuple[SearchState, Growth]:
    """Grow from the best start; where that fails, see whether the records agree before the other starts are tried."""
    growth = _grow_best(watch, state, iter([best]), seed)
    if growth.complete:
        return state, growth
    problem, journal = state.problem, watch.journal
    explained = explains(problem, best)
    told = partial(watch.tell, "records compared")
    agreed = agreement(problem, growth, seed, explained=explained, tell=told, journal=journal)
    if agreed and agreed.judged:
        state = watch.note(_taking(state, campaign, agreed))
        return state, _grow_best(watch, state, _candidates(watch, state, seed), seed, agreed.growth)
    rest = agreed if agreed and agreed.growth.complete else None
    if rest and not rest.left_out:
        return state, rest.growth
    said = [] if explained else common_readings(problem, growth, seed, journal)
    if not said and (explained or not rest):  # leaving out for good what one start explained needs the others too
        growth = _grow_best(watch, state, found, seed, growth)
        said = common_readings(problem, growth, seed, journal) if explained and not growth.complete else []
    if rest and not said and not growth.complete:
        return watch.note(_taking(state, campaign, rest)), rest.growth
    return state.saying(*said), growth


def _taking(state: SearchState, campaign: Campaign, agreed: Agreement) -> SearchState:
    """Return the state with records that are taken otherwise than declared, and what is said of that."""
    state = replace(state.of(agreed.problem), taken=agreed.taken).at(agreed.growth.q, agreed.growth.horizons)
    return state.saying(*agreement_warnings(campaign, agreed))


def _confirmed(watch: Watch, state: SearchState, names: tuple[str, ...], seed: int) -> SearchState:
    """See that the joint optimum follows all records, more strictly and in finer steps; else grow from it again.

    A stick/slip that falls the other way for a moment hides below the growth's limit, and one that hangs by
    less than the integration's error is no optimum.
    """
    for attempt in range(1, CONFIRMATIONS + 1):
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
    said = f"the joint optimum does not follow {', '.join(lost)} to the end"
    return watch.note(state.ending(FitOutcome.HORIZON).saying(said))


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
        f"{places}: a stick/slip hangs by a thread; it falls the other way than measured, or does so in finer "
        "integration steps, and no estimate near by was found that settles it"
    )


def _lost(problem: Problem, q: FloatArray, *, most: float = DIVERGED_AT) -> list[str]:
    """Return the records that the model at `q` does not follow to their ends."""
    whole = {t.name: t.samples for t in problem.targets}
    found = horizons_at(problem, q, whole, floors(problem), most=most)
    return [name for name, n in whole.items() if found[name] < n]


def _note_regrowth(watch: Watch, q: FloatArray, gates: Mapping[str, int]) -> None:
    share = 100.0 * sum(gates.values()) / sum(t.samples for t in watch.latest.problem.targets)
    watch.tell("growth again", f"{share:.1f} % of all samples followed")


def _horizon_warnings(problem: Problem, growth: Growth) -> list[str]:
    """Name the records that are not followed to their ends, and what happens where they are left."""
    return [
        f"record {t.name}: the model follows it for {n / t.base.sample_rate_hz:.4g} s of "
        f"{(t.samples - 1) / t.base.sample_rate_hz:.4g} s; {departure(problem, growth.q, t, n)}"
        for t in problem.targets
        if (n := growth.horizons[t.name]) < t.samples
    ]


def _candidates(watch: Watch, state: SearchState, seed: int) -> Iterator[Candidate]:
    """Yield refined candidates, the best of all starts first."""
    problem, journal = state.problem, watch.journal

    def told(done: int, total: int) -> None:
        watch.tell("multi-start", f"{done} of {total} starts")

    starts = multistart(problem, seed, problem.workers, told, journal)
    for number, candidate in enumerate(candidates(problem, starts, problem.workers, journal), 1):
        if number == 1:
            watch.note(state.at(candidate.q))
            watch.tell("multi-start", f"{len(starts)} starts to be refined", candidate.cost)
        yield candidate


def _grow_best(
    watch: Watch, state: SearchState, found: Iterator[Candidate], seed: int, best: Growth | None = None
) -> Growth:
    """Grow from one candidate after another until one follows all records; else return the furthest."""
    if best and best.complete:
        return best
    problem, begun = state.problem, 2 if best else 1
    for number, candidate in enumerate(islice(found, TRIED_CANDIDATES + 1 - begun), begun):
        told = partial(_note_growth, watch, state, number, best)
        rng = np.random.default_rng((seed, number))
        growth = grow(problem, candidate.q, rng, told, journal=watch.journal)
        if best is None or growth.reached(problem) > best.reached(problem):
            best = growth
        if best.complete:
            break
    assert best is not None
    return best


def _note_growth(
    watch: Watch, state: SearchState, number: int, best: Growth | None, q: FloatArray, gates: Mapping[str, int]
) -> None:
    """Keep a point that follows the records further than all before, and tell of it."""
    here = sum(gates.values())
    if best is None or here > sum(best.horizons.values()):
        watch.note(state.at(q, gates))
    share = 100.0 * here / sum(t.samples for t in state.problem.targets)
    watch.tell("gated growth", f"start {number}: {share:.1f} % of all samples followed")
