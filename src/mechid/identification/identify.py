"""Identify: from a campaign to a fit, by the user's stages or by the plan made without them."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mechid.campaign import Campaign, Stage
from mechid.errors import FitError, InputFileError
from mechid.identification.accuracy import enough_substeps
from mechid.identification.conclude import Ending, conclude
from mechid.identification.fit import Fit, FitOutcome, StageReport
from mechid.identification.gates import Growth, floors, grow, horizons_at
from mechid.identification.multistart import Candidate, multistart, refine_all
from mechid.identification.noise import released_sigmas
from mechid.identification.parallel import one_core_algebra
from mechid.identification.problem import Problem, Target
from mechid.identification.progress import Listener, Progress, silent
from mechid.identification.solve import Solution, solve
from mechid.identification.space import SearchSpace
from mechid.identification.target import target_of

FloatArray = NDArray[np.float64]
TRIED_CANDIDATES = 12


@dataclass
class Trail:
    """The search in progress: best point so far, what has been done, whom to tell."""

    problem: Problem
    listener: Listener
    total: int
    q: FloatArray
    windows: dict[str, tuple[int, int]]
    outcome: FitOutcome = FitOutcome.FAILED
    stages: list[StageReport] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    moved: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=bool))
    began: float = field(default_factory=time.perf_counter)
    stage_began: float = field(default_factory=time.perf_counter)

    def tell(self, stage: str, line: str, cost: float | None = None) -> None:
        """Report progress of the stage at work."""
        number = min(len(self.stages) + 1, self.total)
        self.listener(Progress(number, self.total, stage, line, cost, time.perf_counter() - self.began))

    def ending(self, seed: int) -> Ending:
        """Return where the search stands, for the conclusion."""
        seconds = time.perf_counter() - self.began
        stages, warnings = tuple(self.stages), tuple(self.warnings)
        return Ending(self.problem, self.q, self.windows, self.outcome, stages, warnings, self.moved, seed, seconds)

    def close(self, name: str, free: tuple[str, ...], cost: float, evaluations: int, note: str = "") -> None:
        """Note a finished stage."""
        now = time.perf_counter()
        rates = {t.name: t.base.sample_rate_hz for t in self.problem.targets}
        used = {name: (w[1] - w[0]) / rates[name] for name, w in self.windows.items()}
        self.stages.append(StageReport(name=name, records=used, free=free, cost=cost, evaluations=evaluations,
                                       seconds=now - self.stage_began, note=note))  # fmt: skip
        self.stage_began = now


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
    plan = _follow_stages if campaign.stages else _follow_plan
    trail = Trail(problem, listener, len(campaign.stages) or 4, problem.start, problem.whole(),
                  moved=np.zeros(problem.size, dtype=bool))  # fmt: skip
    trail.warnings += [
        f"{q.name}: its prior (sigma = {q.sigma:g}) is not used by the fit yet"
        for q in campaign.mechanism.free
        if q.sigma
    ]
    with one_core_algebra():
        try:
            plan(trail, campaign, seed)
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
    return Problem(SearchSpace(campaign.mechanism), targets, workers=workers)


def _refuse_free_voltage(campaign: Campaign) -> None:
    """Refuse a free supply voltage beside R, L and k_m: torque alone cannot tell them apart."""
    scaled = ("stepper.peak_voltage", "stepper.coil_resistance", "stepper.coil_inductance", "stepper.torque_constant")
    free = {q.name for q in campaign.mechanism.free}
    if free.issuperset(scaled):
        raise InputFileError(
            f"{campaign.mechanism_path}: stepper.peak_voltage: free together with R, L and k_m, which torque records "
            "cannot tell apart (U -> c U, k_m -> c k_m, R and L -> c^2 gives the same torque); give it as a number"
        )


def _follow_stages(trail: Trail, campaign: Campaign, seed: int) -> None:
    """Work through the user's stages in order; each starts where the one before ended."""
    del seed
    used: dict[str, tuple[int, int]] = {}
    for number, stage in enumerate(campaign.stages, 1):
        trail.problem, trail.q = trail.problem.in_polar(_halves(trail.problem, stage), trail.q)
        trail.windows = {t.name: _window(t, stage) for t in trail.problem.targets if t.name in stage.records}
        trail.problem = replace(trail.problem, substeps=enough_substeps(trail.problem, trail.q, trail.windows))
        free = np.array([name in stage.free for name in trail.problem.names])
        name = f"stage {number}"
        told = partial(trail.tell, name, f"{trail.problem.substeps} steps a sample")
        solution = solve(trail.problem, trail.q, trail.windows, free=free, progress=told)
        trail.q = solution.q
        trail.moved = trail.moved | free
        trail.close(name, stage.free, solution.triangle.cost, solution.evaluations, solution.message)
        used = {n: _joined(used.get(n, w), w) for n, w in (used | trail.windows).items()}
        if not solution.converged:
            trail.warnings.append(f"{name}: stopped at its limit of steps before it converged")
    trail.windows = used
    sigmas = released_sigmas(trail.problem, trail.q, used, trail.warnings)
    trail.problem = trail.problem.with_sigmas(sigmas)
    trail.outcome = FitOutcome.STAGES_DONE


def _halves(problem: Problem, stage: Stage) -> frozenset[str]:
    """Return the detents of which the stage frees amplitude or phase alone."""
    pairs = ((c.name, c.partner) for c in problem.space.coordinates if c.kind == "cosine")
    return frozenset(a for a, phase in pairs if (a in stage.free) != (phase in stage.free))


def _joined(a: tuple[int, int], b: tuple[int, int]) -> tuple[int, int]:
    return min(a[0], b[0]), max(a[1], b[1])


def _window(target: Target, stage: Stage) -> tuple[int, int]:
    if stage.window_s is None:
        return 0, target.samples
    first, last = ((s - target.base.start_s) * target.base.sample_rate_hz for s in stage.window_s)
    return max(0, math.ceil(first - 1e-6)), min(target.samples, math.floor(last + 1e-6) + 1)


def _follow_plan(trail: Trail, campaign: Campaign, seed: int) -> None:
    """Multi-start on the first moments, gated growth to the records' ends, joint fit, noise released."""
    names = tuple(p.name for p in campaign.mechanism.free)
    trail.moved = np.ones(trail.problem.size, dtype=bool)
    candidates = _candidates(trail, seed)
    trail.close("multi-start", names, candidates[0].cost if candidates else math.inf, len(candidates))
    if not candidates:
        return
    growth = _grow_best(trail, candidates, seed)
    trail.q = growth.q
    trail.windows = {name: (0, n) for name, n in growth.horizons.items()}
    followed = "all records followed to their ends" if growth.complete else "not all records followed"
    trail.close("gated growth", names, math.nan, growth.rounds, followed)
    trail.outcome = FitOutcome.CONVERGED if growth.complete else FitOutcome.HORIZON
    trail.problem = replace(trail.problem, substeps=enough_substeps(trail.problem, trail.q, trail.windows))
    _joint_fit(trail, "joint fit", names)
    _check_followed(trail)
    trail.problem = trail.problem.with_sigmas(released_sigmas(trail.problem, trail.q, trail.windows, trail.warnings))
    _joint_fit(trail, "noise released", names)


def _check_followed(trail: Trail) -> None:
    """See that the joint optimum still follows every record as far as the growth did."""
    windows = {name: stop for name, (_, stop) in trail.windows.items()}
    found = horizons_at(trail.problem, trail.q, windows, floors(trail.problem))
    lost = [name for name, n in windows.items() if found[name] < n]
    if lost:
        trail.outcome = FitOutcome.HORIZON
        trail.warnings.append(f"the joint optimum does not follow {', '.join(lost)} to the end")


def _joint_fit(trail: Trail, name: str, free: tuple[str, ...]) -> Solution:
    line = f"{trail.problem.substeps} steps a sample"
    solution = solve(trail.problem, trail.q, trail.windows, progress=partial(trail.tell, name, line))
    trail.q = solution.q
    outside = trail.problem.space.outside_disc(solution.q)
    if outside:
        trail.problem, trail.q = trail.problem.in_polar(outside, solution.q)
        return _joint_fit(trail, name, free)
    trail.close(name, free, solution.triangle.cost, solution.evaluations, solution.message)
    if not solution.converged and trail.outcome is FitOutcome.CONVERGED:
        trail.outcome = FitOutcome.NOT_CONVERGED
    return solution


def _candidates(trail: Trail, seed: int) -> list[Candidate]:
    """Return refined candidates in order of cost."""
    workers = trail.problem.workers

    def told(done: int, total: int) -> None:
        trail.tell("multi-start", f"{done} of {total} starts")

    found = multistart(trail.problem, seed, workers, told)
    best = refine_all(trail.problem, found, workers)
    if best:
        trail.q = best[0].q
        trail.tell("multi-start", f"{len(best)} refined", best[0].cost)
    return best


def _grow_best(trail: Trail, candidates: list[Candidate], seed: int) -> Growth:
    """Grow from one candidate after another until one follows all records; else return the furthest."""
    total = sum(t.samples for t in trail.problem.targets)
    best: Growth | None = None
    for number, candidate in enumerate(candidates[:TRIED_CANDIDATES], 1):

        def told(gates: Mapping[str, int], number: int = number) -> None:
            share = 100.0 * sum(gates.values()) / total
            trail.tell("gated growth", f"start {number}: {share:.1f} % of all samples followed")

        growth = grow(trail.problem, candidate.q, np.random.default_rng((seed, number)), told)
        if best is None or growth.reached(trail.problem) > best.reached(trail.problem):
            best, trail.q = growth, growth.q
            trail.windows = {name: (0, n) for name, n in growth.horizons.items()}
        if best.complete:
            break
    assert best is not None
    return best
