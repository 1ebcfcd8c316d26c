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
from mechid.identification.result.ending import Frozen
from mechid.identification.result.fit import Fit, FitOutcome
from mechid.identification.search.gates import DIVERGED_AT, Growth, chance, floors, grow, horizons_at
from mechid.identification.search.multistart import POINTS, Candidate, candidates, multistart
from mechid.identification.search.solve import Solution
from mechid.identification.stages.freeze import freeze_dependent
from mechid.identification.stages.own_stages import follow_stages
from mechid.identification.stages.release import fit_with_noise_released
from mechid.identification.stages.trail import Trail, cliff_warnings, fit_past_cliffs, joint_fit
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
    trail = Trail(problem, listener, len(campaign.stages) or 4, problem.start, problem.whole())
    trail.journal = journal or Journal()
    with one_core_algebra():
        frozen: list[Frozen] = []
        try:
            if campaign.stages:
                follow_stages(trail, campaign)
            else:
                _follow_plan(trail, campaign, seed, near)
            if trail.outcome.good or trail.outcome in (FitOutcome.CLIFF, FitOutcome.NOT_CONVERGED):
                freeze_dependent(trail, campaign, frozen)
        except KeyboardInterrupt:
            trail.outcome = FitOutcome.INTERRUPTED
        trail.warnings += rejection_warnings(trail.problem)
        try:
            return conclude(campaign, trail.ending(seed, frozen))
        except KeyboardInterrupt:  # what was found is not lost; an interrupted fit is not tested by draws
            trail.outcome = FitOutcome.INTERRUPTED
            return conclude(campaign, trail.ending(seed, frozen))


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


def _follow_plan(trail: Trail, campaign: Campaign, seed: int, near: Mapping[str, float] | None) -> None:
    """Multi-start on the first moments, gated growth to the records' ends, joint fit, noise released."""
    names = (*(p.name for p in campaign.mechanism.free), *trail.problem.coordinates.own_names)
    growth = _search(trail, campaign, names, seed) if near is None else _vouched(trail, near)
    if growth is None:
        return
    names = (*names, *(n for n in trail.problem.coordinates.own_names if n not in names))
    trail.at(growth.q, growth.horizons)
    left_out = any(t.left_out for t in trail.taken.values())
    trail.outcome = FitOutcome.CONVERGED if growth.complete and not left_out else FitOutcome.HORIZON
    trail.warnings += _horizon_warnings(trail.problem, growth)
    trail.problem = replace(trail.problem, substeps=enough_substeps(trail.problem, trail.q, trail.windows))
    joint_fit(trail, "joint fit", names, tolerance=ROUGH)
    solution = fit_with_noise_released(trail, campaign.options, names)
    if growth.complete and near is None:
        solution = _confirmed(trail, solution, names, seed)
    solution = fit_past_cliffs(trail, solution, names, seed)
    at_cliff = cliff_warnings("noise released", trail.problem, solution)
    trail.warnings += at_cliff
    if at_cliff and trail.outcome is FitOutcome.CONVERGED:
        trail.outcome = FitOutcome.CLIFF
    if not solution.converged and trail.outcome is FitOutcome.CONVERGED:
        trail.outcome = FitOutcome.NOT_CONVERGED


def _search(trail: Trail, campaign: Campaign, names: tuple[str, ...], seed: int) -> Growth | None:
    """Return the growth from the best starts, or None where none of them can be simulated."""
    found = _candidates(trail, seed)
    best = next(found, None)
    trail.close("multi-start", names, best.cost if best else math.inf, POINTS)
    if best is None:
        return None
    growth = _grown(trail, campaign, best, found, seed)
    trail.at(growth.q, growth.horizons)
    followed = "all records followed to their ends" if growth.complete else "not all records followed"
    trail.close("gated growth", names, math.nan, growth.rounds, followed)
    return growth


def _vouched(trail: Trail, near: Mapping[str, float]) -> Growth:
    """Return values already near the optimum as a growth that has come to the records' ends.

    Who gives them vouches for them: what they leave of a record is its noise, also where that is coloured, so that
    the high-frequency floor is none.
    """
    problem, q = trail.problem, trail.problem.coordinates.point(near)
    trail.problem = replace(problem, targets=tuple(at_least_their_residuals(problem, t, q) for t in problem.targets))
    return Growth(q, {t.name: t.samples for t in problem.targets}, True, 0)


def _grown(trail: Trail, campaign: Campaign, best: Candidate, found: Iterator[Candidate], seed: int) -> Growth:
    """Grow from the best start; where that fails, see whether the records agree before the other starts are tried."""
    growth = _grow_best(trail, iter([best]), seed)
    if growth.complete:
        return growth
    explained = explains(trail.problem, best)
    told = partial(trail.tell, "records compared")
    agreed = agreement(trail.problem, growth, seed, explained=explained, tell=told, journal=trail.journal)
    if agreed and agreed.judged:
        _take(trail, campaign, agreed)
        return _grow_best(trail, _candidates(trail, seed), seed, agreed.growth)
    rest = agreed if agreed and agreed.growth.complete else None
    if rest and not rest.left_out:
        return rest.growth
    said = [] if explained else common_readings(trail.problem, growth, seed, trail.journal)
    if not said and (explained or not rest):  # leaving out for good what one start explained needs the others too
        growth = _grow_best(trail, found, seed, growth)
        said = common_readings(trail.problem, growth, seed, trail.journal) if explained and not growth.complete else []
    if rest and not said and not growth.complete:
        _take(trail, campaign, rest)
        return rest.growth
    trail.warnings += said
    return growth


def _take(trail: Trail, campaign: Campaign, agreed: Agreement) -> None:
    trail.take(agreed.problem, agreed.growth, agreed.taken, agreement_warnings(campaign, agreed))


def _confirmed(trail: Trail, solution: Solution, names: tuple[str, ...], seed: int) -> Solution:
    """See that the joint optimum follows all records, more strictly and in finer steps; else grow from it again.

    A stick/slip that falls the other way for a moment hides below the growth's limit, and one that hangs by
    less than the integration's error is no optimum.
    """
    for attempt in range(1, CONFIRMATIONS + 1):
        fine = replace(trail.problem, substeps=2 * trail.problem.substeps)
        strict = chance(fine)
        judged = by_own_residuals(fine, trail.q)
        if not _lost(judged, trail.q, most=strict):
            return solution
        rng = np.random.default_rng((seed, 0, attempt))
        growth = grow(judged, trail.q, rng, partial(_note_regrowth, trail), most=strict, journal=trail.journal)
        if growth.complete or _cost(fine, growth.q) < _cost(fine, trail.q):
            trail.at(growth.q, {t.name: t.samples for t in fine.targets})
            trail.problem = fine
            solution = fit_past_cliffs(trail, joint_fit(trail, "growth again", names), names, seed)
        if not growth.complete:
            if _lost(by_own_residuals(trail.problem, trail.q), trail.q, most=strict):
                trail.warnings.append(_suspicion(growth, fine))
            break
    lost = _lost(by_own_residuals(trail.problem, trail.q), trail.q)
    if lost:
        trail.outcome = FitOutcome.HORIZON
        trail.warnings.append(f"the joint optimum does not follow {', '.join(lost)} to the end")
    return solution


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


def _note_regrowth(trail: Trail, q: FloatArray, gates: Mapping[str, int]) -> None:
    share = 100.0 * sum(gates.values()) / sum(t.samples for t in trail.problem.targets)
    trail.tell("growth again", f"{share:.1f} % of all samples followed")


def _horizon_warnings(problem: Problem, growth: Growth) -> list[str]:
    """Name the records that are not followed to their ends, and what happens where they are left."""
    return [
        f"record {t.name}: the model follows it for {n / t.base.sample_rate_hz:.4g} s of "
        f"{(t.samples - 1) / t.base.sample_rate_hz:.4g} s; {departure(problem, growth.q, t, n)}"
        for t in problem.targets
        if (n := growth.horizons[t.name]) < t.samples
    ]


def _candidates(trail: Trail, seed: int) -> Iterator[Candidate]:
    """Yield refined candidates, the best of all starts first."""
    workers = trail.problem.workers

    def told(done: int, total: int) -> None:
        trail.tell("multi-start", f"{done} of {total} starts")

    starts = multistart(trail.problem, seed, workers, told, trail.journal)
    for number, candidate in enumerate(candidates(trail.problem, starts, workers, trail.journal), 1):
        if number == 1:
            trail.at(candidate.q)
            trail.tell("multi-start", f"{len(starts)} starts to be refined", candidate.cost)
        yield candidate


def _grow_best(trail: Trail, found: Iterator[Candidate], seed: int, best: Growth | None = None) -> Growth:
    """Grow from one candidate after another until one follows all records; else return the furthest."""
    if best and best.complete:
        return best
    begun = 2 if best else 1
    for number, candidate in enumerate(islice(found, TRIED_CANDIDATES + 1 - begun), begun):
        told = partial(_note_growth, trail, number, best)
        rng = np.random.default_rng((seed, number))
        growth = grow(trail.problem, candidate.q, rng, told, journal=trail.journal)
        if best is None or growth.reached(trail.problem) > best.reached(trail.problem):
            best = growth
        if best.complete:
            break
    assert best is not None
    return best


def _note_growth(trail: Trail, number: int, best: Growth | None, q: FloatArray, gates: Mapping[str, int]) -> None:
    """Keep a point that follows the records further than all before, and tell of it."""
    here = sum(gates.values())
    if best is None or here > sum(best.horizons.values()):
        trail.at(q, gates)
    share = 100.0 * here / sum(t.samples for t in trail.problem.targets)
    trail.tell("gated growth", f"start {number}: {share:.1f} % of all samples followed")
