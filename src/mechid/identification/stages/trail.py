"""The search in progress: where it stands, what it has done, and whom it tells."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechid.identification.computation.journal import Journal
from mechid.identification.computation.progress import Listener, Progress, silent
from mechid.identification.output_error.declaration import Taken
from mechid.identification.output_error.identity import identity
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.reduction import Triangle
from mechid.identification.result.ending import Ending, Frozen
from mechid.identification.result.fit import FitOutcome, StageReport
from mechid.identification.search.cliffs import along_cliff
from mechid.identification.search.doubts import refused_gain
from mechid.identification.search.gates import Growth
from mechid.identification.search.solve import Solution, solve
from mechid.identification.stages.over_noise import OverNoise

FloatArray = NDArray[np.float64]
MOST_CLIFFS = 3
BACK_FROM_EDGE = 4.0
"""Sigmas squared that it may cost to stand clear of a cliff."""
WORTH_SAYING = 1.0
"""A fall of the cost, in sigmas squared, that moves no parameter by more than its standard error."""


@dataclass
class Trail:
    """The problem at present, the best point of it so far, the stages done; an interruption leaves it usable."""

    problem: Problem
    listener: Listener
    total: int
    q: FloatArray
    windows: dict[str, tuple[int, int]]
    outcome: FitOutcome = FitOutcome.FAILED
    taken: dict[str, Taken] = field(default_factory=dict)
    stages: list[StageReport] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    journal: Journal = field(default_factory=Journal)
    began: float = field(default_factory=time.perf_counter)
    stage_began: float = field(default_factory=time.perf_counter)
    noise: OverNoise = field(init=False)

    def __post_init__(self) -> None:
        self.noise = OverNoise(self.problem)

    def clock(self) -> float:
        """Return seconds that run on through a resumed search, as if what the journal holds were worked out now."""
        return float(time.perf_counter() + self.journal.saved_s)

    def at(self, q: FloatArray, gates: Mapping[str, int] | None = None) -> None:
        """Note a better point, and how far it follows the records where that is what makes it better."""
        self.q = q
        if gates is not None:
            self.windows = {name: (0, n) for name, n in gates.items()}

    def take(self, problem: Problem, growth: Growth, taken: Mapping[str, Taken], said: Sequence[str]) -> None:
        """Go on with records that are taken otherwise than declared, and what is said of that."""
        self.problem, self.taken = problem, dict(taken)
        self.at(growth.q, growth.horizons)
        self.warnings += said

    def tell(self, stage: str, line: str, cost: float | None = None) -> None:
        """Report progress of the stage at work."""
        number = min(len(self.stages) + 1, self.total)
        noise = {} if self.listener is silent else self.noise.seen(stage, self.problem, self.q)
        self.listener(Progress(number, self.total, stage, line, cost, self.clock() - self.began, self.values, noise))

    @property
    def values(self) -> dict[str, float]:
        """The file's values of all that is free, by name, where the search stands."""
        return self.problem.values(self.q)

    def ending(self, seed: int, frozen: Sequence[Frozen] = ()) -> Ending:
        """Return where the search stands, for the conclusion."""
        seconds = self.clock() - self.began
        stages, warnings = tuple(self.stages), tuple(self.warnings)
        return Ending(self.problem, self.q, self.windows, self.outcome, stages, warnings, seed, seconds,
                      tuple(frozen), self.taken)  # fmt: skip

    def close(self, name: str, free: tuple[str, ...], cost: float, evaluations: int, note: str = "") -> None:
        """Note a finished stage."""
        now = self.clock()
        rates = {t.name: t.base.sample_rate_hz for t in self.problem.targets}
        used = {name: (w[1] - w[0] - 1) / rates[name] for name, w in self.windows.items()}
        self.stages.append(StageReport(name=name, records=used, free=free, cost=cost, evaluations=evaluations,
                                       seconds=now - self.stage_began, note=note))  # fmt: skip
        self.stage_began = now


def joint_fit(trail: Trail, name: str, free: tuple[str, ...], *, tolerance: float = 1e-8) -> Solution:
    """Fit all windows of the trail to convergence.

    A detent that ends beyond the limit of its amplitude is searched by amplitude and phase from there on.
    """
    substeps = trail.problem.substeps
    told = partial(trail.tell, name, f"{substeps} step{'s' * (substeps > 1)} a sample")
    evaluations = 0
    while True:
        solution = _solved(trail, tolerance, told)
        trail.q = solution.q
        evaluations += solution.evaluations
        outside = trail.problem.space.outside_disc(solution.q)
        if not outside:
            break
        trail.problem, trail.q = trail.problem.in_polar(outside, solution.q)
    trail.close(name, free, solution.triangle.cost, evaluations, solution.message)
    return solution


def _solved(trail: Trail, tolerance: float, told: Callable[[float], None]) -> Solution:
    """Return the solution from where the trail stands, from the journal where it is there."""
    problem, q, windows = trail.problem, trail.q, trail.windows

    def work() -> dict[str, Any]:
        found = solve(problem, q, windows, tolerance=tolerance, progress=told, accepted=trail.at)
        return {**vars(found), "triangle": vars(found.triangle)}

    found = trail.journal.step("joint fit", [identity(problem), q, windows, tolerance], work)
    return Solution(**{**found, "triangle": Triangle(**found["triangle"])})


def _along_cliff(trail: Trail, rng: np.random.Generator, least_gain: float) -> FloatArray | None:
    """Return a better point along a cliff, from the journal where it is there."""
    problem, q, windows = trail.problem, trail.q, trail.windows
    found: FloatArray | None = trail.journal.step(
        "along a cliff",
        [identity(problem), q, windows, least_gain],
        lambda: along_cliff(problem, q, windows, rng, least_gain=least_gain),
        rng,
    )
    return found


def fit_past_cliffs(trail: Trail, solution: Solution, free: tuple[str, ...], seed: int) -> Solution:
    """Go on from better points along a cliff at which a joint fit has stopped, while there are any.

    Each fit comes to rest at the cliff's very edge; where finer integration steps would put it beyond, it is taken
    back to a point that they keep on this side, at the cost of a few sigmas squared.
    """
    rng = np.random.default_rng((seed, 0, 0))
    for _ in range(MOST_CLIFFS):
        if _refused(trail.problem, solution) <= WORTH_SAYING:
            break
        better = _along_cliff(trail, rng, WORTH_SAYING)
        if better is None:
            break
        trail.at(better)
        solution = joint_fit(trail, "along a cliff", free)
    if _refused(trail.problem, solution) > 0.1 and _depends_on_steps(trail, solution):
        back = _along_cliff(trail, rng, -BACK_FROM_EDGE)
        trail.at(trail.q if back is None else back)
    return solution


def _depends_on_steps(trail: Trail, solution: Solution) -> bool:
    """Tell whether the cost is another one at twice the integration steps."""
    fine = replace(trail.problem, substeps=2 * trail.problem.substeps)
    cost = float(np.sum(np.square(fine.norms(trail.q, trail.windows))))
    return not abs(cost - solution.triangle.cost) < WORTH_SAYING


def _refused(problem: Problem, solution: Solution) -> float:
    """Return by how much the derivatives promise that the cost falls yet, where the solver called it converged."""
    return refused_gain(solution.triangle, ~problem.on_bound(solution.q)) if solution.converged else 0.0


def cliff_warnings(name: str, problem: Problem, solution: Solution) -> list[str]:
    """Say where the solver called it converged although its own derivatives promise better."""
    gain = _refused(problem, solution)
    if gain <= WORTH_SAYING:
        return []
    return [
        f"{name}: stopped where the cost should still fall by {gain:.3g} but does not: a stick/slip hangs by a thread "
        "near the estimate, which may be off by more than its error; try another seed, or a shorter record"
    ]
