"""Parametric bootstrap: records simulated at the estimate, with noise like theirs, and refitted.

The scatter of the refits is that of the estimates over repetitions of the campaign, as far as the model and its noise
hold; no derivative enters (Efron and Tibshirani 1993, chapter 6). The noise is white or drawn from the autoregressive
model of each record's residual, and each prior is drawn as if it were measured anew. Each draw has its own random
generator, so the results do not depend on the number of workers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial
from itertools import chain, islice
from typing import Any

import numpy as np
from scipy.special import chdtri

from mechid.arrays import BoolArray, FloatArray
from mechid.display import DisplayedResult
from mechid.errors import FitError
from mechid.identification.computation.journal import Journal
from mechid.identification.computation.workforce import working_on
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import combine_triangles
from mechid.identification.output_error.target import Target
from mechid.identification.refit.chord import Chord, DrawOptimum, chord_at, chord_optima
from mechid.identification.refit.settings import REFIT
from mechid.identification.result.fit import Optimum
from mechid.identification.search.settings import SEARCH
from mechid.identification.search.solve import predicted_reduction, solve
from mechid.identification.uncertainty.covariance import residual, uncertainty
from mechid.identification.uncertainty.verdict import seen_coordinates
from mechid.kernel.batch.source import SETS
from mechid.signal.autoregression import Autoregression, fit_autoregression
from mechid.units import angle_difference

QUANTILES = (0.025, 0.975)
"""Quantiles of a 95 % interval."""


class DrawOutcome(Enum):
    """Outcome of the refit of a draw; the value is the sentence for the user."""

    CONVERGED = "converged near the estimate"
    ELSEWHERE = "converged farther off than the covariance allows: another branch of stick and slip"
    CLIFF = "stopped at a stick/slip threshold, where the derivatives predict a fall of the cost that does not occur"
    NOT_CONVERGED = "stopped at its limit of steps"
    FAILED = "could not be simulated"

    @property
    def code(self) -> str:
        """Short name for programs."""
        return self.name.lower()


@dataclass(frozen=True)
class Draw:
    """One refit: its number, its outcome, its cost in sigmas squared, and the values in the file's units."""

    number: int
    outcome: DrawOutcome
    cost: float
    values: Mapping[str, float]


@dataclass(frozen=True)
class Spread:
    """Scatter of one parameter over the refits, in the file's unit; angles are unwrapped around the estimate.

    Attributes
    ----------
    mean_shift : float
        Mean of the refits minus the estimate.
    deviation : float
        Standard deviation of the refits.
    interval : (float, float)
        2.5 % and 97.5 % quantiles of the refits.
    """

    name: str
    unit: str
    value: float
    std_error: float | None
    mean_shift: float
    deviation: float
    interval: tuple[float, float]


@dataclass(frozen=True, repr=False)
class Bootstrap(DisplayedResult):
    """All draws, in order, and the scatter of each parameter. Quantiles exclude failed draws only."""

    draws: tuple[Draw, ...]
    spreads: tuple[Spread, ...]
    noise: Mapping[str, Mapping[str, Autoregression]]
    seed: int = 0
    synthetic: bool = False
    fit_digest: str = ""

    @property
    def tally(self) -> dict[DrawOutcome, int]:
        """Number of draws with each outcome."""
        return {outcome: sum(d.outcome is outcome for d in self.draws) for outcome in DrawOutcome}


def bootstrap(
    optimum: Optimum,
    draws: int,
    *,
    seed: int = 0,
    workers: int = 1,
    executor: Executor | None = None,
    journal: Journal | None = None,
    on_draw: Callable[[Draw], None] = lambda draw: None,
) -> Bootstrap:
    """Refit `draws` draws; draws in the journal are read from there.

    The work runs on threads, or on the workers of an executor such as `distributed.Client.get_executor()`.

    Raises
    ------
    FitError
        If no draw could be refitted.
    """
    world = _build_basis(optimum)
    at, windows = optimum.q, optimum.windows

    def report_batch(task: tuple[int, int], found: Sequence[Mapping[str, Any]]) -> None:
        for number, one in enumerate(found[: draws - task[1]], task[1]):
            on_draw(_draw(number, one))

    work = partial(_refit_batch, world, at, windows)
    # Whole batches of SETS draws, the last one too; surplus refits are dropped below.
    tasks = [(seed, first) for first in range(0, draws, SETS)]
    with working_on(executor):
        found = (journal or Journal()).map_tasks("bootstrap draws", work, tasks, workers, report_batch)
    done = tuple(_draw(number, one) for number, one in enumerate(islice(chain(*found), draws)))
    noise = {t.name: dict(zip(t.quantities, world.noise[t.name], strict=True)) for t in world.problem.targets}
    return Bootstrap(done, _spreads(optimum, done), noise, seed)


def _draw(number: int, found: Mapping[str, Any]) -> Draw:
    return Draw(number, DrawOutcome[found["outcome"].upper()], found["cost"], found["values"])


@dataclass(frozen=True, eq=False)
class _Basis:
    """Basis of the draws: each record's simulated channels, their noise, the covariance and the chord."""

    problem: Problem
    signals: Mapping[str, tuple[FloatArray, ...]]
    noise: Mapping[str, tuple[Autoregression, ...]]
    counted: BoolArray
    root: FloatArray
    chord: Chord | None


def _build_basis(optimum: Optimum) -> _Basis:
    problem, q, windows = replace(optimum.problem, workers=1), optimum.q, optimum.windows
    used = [t for t in problem.targets if t.name in windows]
    noise = {t.name: _fit_noise(problem, t, q, windows[t.name]) for t in used}
    triangle = combine_triangles(problem.triangles(q, windows))
    counted = seen_coordinates(problem, triangle) & ~problem.coordinates.on_bound(q)
    robust = uncertainty(problem, q, windows, optimum.triangle, counted).robust[np.ix_(counted, counted)]
    values, vectors = np.linalg.eigh(robust)
    root = vectors / np.sqrt(np.maximum(values, 1e-14 * values.max(initial=1e-300)))
    signals = {t.name: problem.model.predict(t, q, t.samples) for t in used}
    chord = chord_at(problem, q, windows, ~problem.coordinates.on_bound(q))
    return _Basis(replace(problem, targets=tuple(used)), signals, noise, counted, root, chord)


def _fit_noise(problem: Problem, target: Target, q: FloatArray, window: tuple[int, int]) -> tuple[Autoregression, ...]:
    """Fit an autoregressive model to the residual of each channel."""
    return tuple(
        fit_autoregression(r, rejected=channel.rejected_within(window))
        for channel, r in zip(target.channels, residual(problem, target, q, window), strict=True)
    )


def _refit_batch(world: _Basis, at: FloatArray, windows: Windows, task: tuple[int, int]) -> list[dict[str, object]]:
    """Return the refits of one batch of draws, by seed and first number, from the estimate `at`."""
    seed, first = task
    # Always a full batch: rounding depends on the draws simulated together, and refits must repeat to the last bit.
    draws = [_problem(world, at, np.random.default_rng((seed, number))) for number in range(first, first + SETS)]
    near = chord_optima(world.chord, draws, at, windows) if world.chord else [None] * len(draws)
    return [
        _convert_optimum(world, at, draw, end) if end else _refit_draw(world, at, windows, draw)
        for draw, end in zip(draws, near, strict=True)
    ]


def _problem(world: _Basis, at: FloatArray, rng: np.random.Generator) -> Problem:
    """Return the problem of one draw."""
    targets = tuple(_draw_target(t, world, rng) for t in world.problem.targets)
    here = world.problem.coordinates.values(at)
    priors = {
        name: (here[name] + sigma * rng.standard_normal(), sigma)
        for name, (_, sigma) in world.problem.priors.items()
        if name in here
    }
    return replace(world.problem, targets=targets, priors=priors)


def _convert_optimum(world: _Basis, at: FloatArray, problem: Problem, end: DrawOptimum) -> dict[str, object]:
    far = _distance(world, end.q - at) > chdtri(int(world.counted.sum()), REFIT.elsewhere)
    outcome = DrawOutcome.ELSEWHERE if far else DrawOutcome.CONVERGED
    return {"outcome": outcome.code, "cost": end.cost, "values": problem.coordinates.values(end.q)}


def _refit_draw(world: _Basis, at: FloatArray, windows: Windows, problem: Problem) -> dict[str, object]:
    """Return the refit of one draw by the general solver."""
    solution = solve(problem, at, windows)
    outcome = DrawOutcome.CONVERGED
    if not np.all(np.isfinite(solution.triangle.jacobian)):
        outcome = DrawOutcome.FAILED
    elif not solution.converged:
        outcome = DrawOutcome.NOT_CONVERGED
    elif predicted_reduction(solution.triangle, ~problem.coordinates.on_bound(solution.q)) > SEARCH.notable_fall:
        outcome = DrawOutcome.CLIFF
    elif _distance(world, solution.q - at) > chdtri(int(world.counted.sum()), REFIT.elsewhere):
        outcome = DrawOutcome.ELSEWHERE
    return {"outcome": outcome.code, "cost": solution.triangle.cost, "values": problem.coordinates.values(solution.q)}


def _draw_target(target: Target, world: _Basis, rng: np.random.Generator) -> Target:
    """Return a target with the simulated output plus noise like that of the record."""
    drawn = [
        replace(channel, measured=y + _noise(model, target.samples, rng))
        for channel, y, model in zip(target.channels, world.signals[target.name], world.noise[target.name], strict=True)
    ]
    return replace(target, channels=tuple(drawn))


def _noise(model: Autoregression, samples: int, rng: np.random.Generator) -> FloatArray:
    white = model.sigma * rng.standard_normal(samples + (REFIT.warm_up if model.order else 0))
    # A coloured series starts from a zero memory: its first samples are dropped, since they are too quiet.
    return model.colour_rows(white, np.zeros(model.order))[0][-samples:]


def _distance(world: _Basis, step: FloatArray) -> float:
    """Return the squared distance of a step from the estimate, in sigmas of the robust covariance."""
    return float(np.sum((step[world.counted] @ world.root) ** 2))


def _spreads(optimum: Optimum, draws: tuple[Draw, ...]) -> tuple[Spread, ...]:
    good = [d for d in draws if d.outcome is not DrawOutcome.FAILED]
    if not good:
        raise FitError(f"none of {len(draws)} draws could be simulated at the estimate; identify anew")
    return tuple(_spread(optimum, name, good) for name in optimum.estimated_names)


def _spread(optimum: Optimum, name: str, draws: list[Draw]) -> Spread:
    own, value = optimum.estimate_of(name), optimum.values(optimum.q)[name]
    off = np.array([d.values[name] for d in draws]) - value
    if own.unit == "deg" and own.min is None:
        off = angle_difference(off)
    low, high = np.quantile(off, QUANTILES)
    return Spread(
        name=name,
        unit=own.unit,
        value=value,
        std_error=own.std_error,
        mean_shift=float(off.mean()),
        deviation=float(off.std(ddof=1)) if off.size > 1 else 0.0,
        interval=(value + float(low), value + float(high)),
    )
