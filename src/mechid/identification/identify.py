"""Identify: from a campaign to a fit, by the user's stages or by the plan made without them."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from itertools import chain, islice

import numpy as np
from numpy.typing import NDArray

from mechid.campaign import Campaign
from mechid.errors import FitError, InputFileError
from mechid.identification.accuracy import enough_substeps
from mechid.identification.conclude import conclude
from mechid.identification.fit import Fit, FitOutcome
from mechid.identification.gates import DIVERGED_AT, Growth, chance, floors, grow, horizons_at
from mechid.identification.multistart import POINTS, Candidate, candidates, multistart
from mechid.identification.noise import released_sigmas
from mechid.identification.parallel import one_core_algebra
from mechid.identification.problem import Problem
from mechid.identification.progress import Listener, silent
from mechid.identification.solve import Solution
from mechid.identification.space import SearchSpace
from mechid.identification.stages import follow_stages
from mechid.identification.target import target_of
from mechid.identification.trail import Trail, cliff_warnings, fit_past_cliffs, joint_fit

FloatArray = NDArray[np.float64]
TRIED_CANDIDATES = 12
CONFIRMATIONS = 3
ROUGH = 1e-6
"""Relative fall of the cost at which the fit before the release of the noise may stop."""
LONGEST_STEP_S = 2e-4
"""Integration steps at most this long are stable also where a start's viscous friction is far too large."""


def identify(campaign: Campaign, *, seed: int = 0, workers: int | None = None, listener: Listener = silent) -> Fit:
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
    trail.warnings += [
        f"{q.name}: its prior (sigma = {q.sigma:g}) is not used by the fit yet"
        for q in campaign.mechanism.free
        if q.sigma
    ]
    with one_core_algebra():
        try:
            if campaign.stages:
                follow_stages(trail, campaign)
            else:
                _follow_plan(trail, campaign, seed)
        except KeyboardInterrupt:
            trail.outcome = FitOutcome.INTERRUPTED
        return conclude(campaign, trail.ending(seed))


def make_problem(campaign: Campaign, workers: int) -> Problem:
    """Return the output-error problem of the records that are to be estimated from."""
    if not campaign.mechanism.free:
        raise FitError(
            f"{campaign.mechanism_path}: nothing to estimate: every parameter is a bare number; "
            "give those to be estimated as { value, min, max }"
        )
    _refuse_free_voltage(campaign)
    targets = tuple(target_of(r) for r in campaign.estimated)
    if not targets:
        raise FitError(f'{campaign.path}: no record has use = "estimate"; there is nothing to estimate from')
    longest = max(t.base.interval_s for t in targets)
    substeps = max(1, math.ceil(longest / LONGEST_STEP_S - 1e-6))
    return Problem(SearchSpace(campaign.mechanism), targets, substeps=substeps, workers=workers)


def _refuse_free_voltage(campaign: Campaign) -> None:
    """Refuse a free supply voltage beside R, L and k_m: torque alone cannot tell them apart."""
    scaled = ("stepper.peak_voltage", "stepper.coil_resistance", "stepper.coil_inductance", "stepper.torque_constant")
    free = {q.name for q in campaign.mechanism.free}
    if free.issuperset(scaled):
        raise InputFileError(
            f"{campaign.mechanism_path}: stepper.peak_voltage: free together with R, L and k_m, which torque records "
            "cannot tell apart (U -> c U, k_m -> c k_m, R and L -> c^2 gives the same torque); give it as a number"
        )


def _follow_plan(trail: Trail, campaign: Campaign, seed: int) -> None:
    """Multi-start on the first moments, gated growth to the records' ends, joint fit, noise released."""
    delays = (f"record.{name}.time_offset_s" for name in trail.problem.delayed_targets)
    names = (*(p.name for p in campaign.mechanism.free), *delays)
    found = _candidates(trail, seed)
    best = next(found, None)
    trail.close("multi-start", names, best.cost if best else math.inf, POINTS)
    if best is None:
        return
    growth = _grow_best(trail, chain([best], found), seed)
    trail.at(growth.q, growth.horizons)
    followed = "all records followed to their ends" if growth.complete else "not all records followed"
    trail.close("gated growth", names, math.nan, growth.rounds, followed)
    trail.outcome = FitOutcome.CONVERGED if growth.complete else FitOutcome.HORIZON
    trail.warnings += _horizon_warnings(trail.problem, growth)
    trail.problem = replace(trail.problem, substeps=enough_substeps(trail.problem, trail.q, trail.windows))
    joint_fit(trail, "joint fit", names, tolerance=ROUGH)
    trail.problem = trail.problem.with_sigmas(released_sigmas(trail.problem, trail.q, trail.windows, trail.warnings))
    solution = joint_fit(trail, "noise released", names)
    if growth.complete:
        solution = _confirmed(trail, solution, names, seed)
    solution = fit_past_cliffs(trail, solution, names, seed)
    trail.warnings += cliff_warnings("noise released", trail.problem, solution)
    if not solution.converged and trail.outcome is FitOutcome.CONVERGED:
        trail.outcome = FitOutcome.NOT_CONVERGED


def _confirmed(trail: Trail, solution: Solution, names: tuple[str, ...], seed: int) -> Solution:
    """See that the joint optimum follows all records, more strictly and in finer steps; else grow from it again.

    A stick/slip that falls the other way for a moment hides below the growth's limit, and one that hangs by
    less than the integration's error is no optimum.
    """
    for attempt in range(1, CONFIRMATIONS + 1):
        fine = replace(trail.problem, substeps=2 * trail.problem.substeps)
        strict = chance(fine)
        if not _lost(fine, trail.q, most=strict):
            return solution
        rng = np.random.default_rng((seed, 0, attempt))
        growth = grow(fine, trail.q, rng, partial(_note_regrowth, trail), most=strict)
        if not growth.complete:
            break
        trail.at(growth.q, growth.horizons)
        trail.problem = fine
        solution = joint_fit(trail, "growth again", names)
    lost = _lost(trail.problem, trail.q)
    if lost:
        trail.outcome = FitOutcome.HORIZON
        trail.warnings.append(f"the joint optimum does not follow {', '.join(lost)} to the end")
    return solution


def _lost(problem: Problem, q: FloatArray, *, most: float = DIVERGED_AT) -> list[str]:
    """Return the records that the model at `q` does not follow to their ends."""
    whole = {t.name: t.samples for t in problem.targets}
    found = horizons_at(problem, q, whole, floors(problem), most=most)
    return [name for name, n in whole.items() if found[name] < n]


def _note_regrowth(trail: Trail, q: FloatArray, gates: Mapping[str, int]) -> None:
    share = 100.0 * sum(gates.values()) / sum(t.samples for t in trail.problem.targets)
    trail.tell("growth again", f"{share:.1f} % of all samples followed")


def _horizon_warnings(problem: Problem, growth: Growth) -> list[str]:
    """Name the records that are not followed to their ends."""
    return [
        f"record {t.name}: the model follows it for {growth.horizons[t.name] / t.base.sample_rate_hz:.4g} s "
        f"of {(t.samples - 1) / t.base.sample_rate_hz:.4g} s"
        for t in problem.targets
        if growth.horizons[t.name] < t.samples
    ]


def _candidates(trail: Trail, seed: int) -> Iterator[Candidate]:
    """Yield refined candidates, the best of all starts first."""
    workers = trail.problem.workers

    def told(done: int, total: int) -> None:
        trail.tell("multi-start", f"{done} of {total} starts")

    starts = multistart(trail.problem, seed, workers, told)
    for number, candidate in enumerate(candidates(trail.problem, starts, workers), 1):
        if number == 1:
            trail.at(candidate.q)
            trail.tell("multi-start", f"{len(starts)} starts to be refined", candidate.cost)
        yield candidate


def _grow_best(trail: Trail, found: Iterator[Candidate], seed: int) -> Growth:
    """Grow from one candidate after another until one follows all records; else return the furthest."""
    best: Growth | None = None
    for number, candidate in enumerate(islice(found, TRIED_CANDIDATES), 1):
        told = partial(_note_growth, trail, number, best)
        growth = grow(trail.problem, candidate.q, np.random.default_rng((seed, number)), told)
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
