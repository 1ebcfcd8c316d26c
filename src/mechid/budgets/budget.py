"""Budget of every mode of operation, through the structure, against every requirement."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.budgets.attractors import steady_states
from mechid.budgets.budget_file import BudgetFile
from mechid.budgets.coupling import coupled_modes, largest_loop_gain
from mechid.budgets.emission import emission
from mechid.budgets.ensemble import Ensemble, make_ensemble
from mechid.budgets.findings import findings
from mechid.budgets.flying_mechanism import Estimate, flying_estimate, on_modes
from mechid.budgets.line_of_sight import LineOfSight, Response, respond
from mechid.budgets.margins import margins
from mechid.budgets.mode_budget import ModeBudget
from mechid.budgets.mode_prediction import predict_modes
from mechid.budgets.named_modes import named_modes
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.orders import Crossing, crossings, rates_to_avoid
from mechid.budgets.over_rate import deciding_curve, level_curve, rms_bands, total_bands, two_way_curve
from mechid.budgets.prediction import Prediction
from mechid.budgets.profile_run import run_profile
from mechid.budgets.requirement import Requirement, Standing
from mechid.budgets.settings import LEVEL
from mechid.budgets.side_response import SideResponse, side_response
from mechid.budgets.side_source import SideSource
from mechid.budgets.standing import Parts, assess_standing, nominal_level
from mechid.budgets.steady_state import SteadyState, enough_substeps, steady_state
from mechid.display import DisplayedResult
from mechid.errors import InputFileError
from mechid.identification.computation.parallel import map_tasks, one_core_algebra
from mechid.identification.computation.workforce import working_on
from mechid.identification.result.fit import Fit
from mechid.plant.flight import moving_base_objection
from mechid.plant.mechanism import Mechanism
from mechid.structure import Modes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Listener = Callable[[str], None]

BY_DUTY = "all modes, by duty"


@dataclass(frozen=True, eq=False, repr=False)
class Budget(DisplayedResult):
    """Result of a budget file; `by_duty` combines all modes, weighted by their share of the time.

    `two_way_by_duty` holds the two-way levels of the nominal unit over time for all modes together, rad, by
    requirement. `side` holds the other force and moment components measured on the bench, if any, `predictions` the
    verdicts on the emission requirements.
    """

    file: BudgetFile
    estimate: Estimate
    modes: tuple[ModeBudget, ...]
    by_duty: tuple[Standing, ...]
    two_way_by_duty: dict[str, float]
    crossings: tuple[Crossing, ...]
    warnings: tuple[str, ...]
    side: SideSource | None = None
    predictions: tuple[Prediction, ...] = ()

    def plot(self, mode: str | None = None, *, ax: Axes | None = None) -> Axes:
        """Plot the level of each requirement relative to its limit, or the line of sight of one mode in rad.

        Parameters
        ----------
        mode : str or None
            Mode whose line of sight is plotted over rate or time; None plots the requirements.
        ax : matplotlib.axes.Axes or None
            None creates new axes.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        UsageError
            There is no such mode.
        """
        from mechid.budgets.plot import plot_mode, plot_requirements
        from mechid.ink.axes import one_of

        if mode is None:
            return plot_requirements(self.to_dict()["requirements"], ax)
        modes = {one.mode.name: one for one in self.modes}
        return plot_mode(modes[one_of(mode, modes, "mode")], ax)

    @property
    def standings(self) -> list[Standing]:
        """Standings of every mode, followed by those of all modes by duty."""
        return [*(s for mode in self.modes for s in mode.standings), *self.by_duty]


def make_budget(
    file: BudgetFile, fit: Fit, workers: int = 1, listener: Listener | None = None, *, executor: Executor | None = None
) -> Budget:
    """Return the budget of a file.

    Parameters
    ----------
    file : BudgetFile
    fit : Fit
        Fit of the mechanism that flies.
    workers : int
        Number of threads.
    listener : callable or None
        Called with one line of text as each step begins.
    executor : concurrent.futures.Executor or None
        External executor, as `distributed.Client.get_executor()`; None uses threads.

    Raises
    ------
    InputFileError
        The fit cannot fly, or does not suit the file.
    UsageError
        A profile is shorter than the windows of a requirement, or the fit has neither a folder nor its campaign.
    FitError
        The mechanism diverged.
    """
    estimate = flying_estimate(fit, file.flight)
    file = replace(file, modes=tuple(mode.for_mechanism(estimate.mechanism) for mode in file.modes))
    spread = file.flight.spread
    ensemble = make_ensemble(tuple(spread), np.array(list(spread.values())), file.errors, file.seed)
    side = _side_source(file, estimate)
    maker = _Maker(file, estimate, ensemble, workers, listener or _ignore, side)
    with one_core_algebra(), working_on(executor):
        modes = tuple(maker.profile(mode) if mode.is_profile else maker.steady(mode) for mode in file.modes)
        by_duty, two_way_by_duty = maker.by_duty(modes), maker.two_way_by_duty(modes)
        exported = predict_modes(file, estimate, modes)
    found = (*findings(file, estimate, modes, side), *(note for one in exported for note in one.notes))
    crossed = tuple(_crossings(file, estimate))
    return Budget(file, estimate, modes, by_duty, two_way_by_duty, crossed, found, side, exported)


def _side_source(file: BudgetFile, estimate: Estimate) -> SideSource | None:
    """Return the other components measured on the bench with their path to the structure, None if there are none."""
    if estimate.side is None:
        return None
    try:
        return SideSource(estimate.side, file.frame, file.structure)
    except InputFileError as error:
        raise InputFileError(f"{file.path.name}: structure.frame: {error}") from error


def _ignore(line: str) -> None:
    """Ignore a line of progress."""


@dataclass(frozen=True, eq=False)
class _Maker:
    """State shared by the computation of all modes."""

    file: BudgetFile
    estimate: Estimate
    ensemble: Ensemble
    workers: int
    listener: Listener
    side: SideSource | None

    @property
    def names(self) -> tuple[str, ...]:
        """Parameters whose derivatives are needed."""
        return (*self.estimate.names, *self.ensemble.names)

    def steady(self, mode: OperatingMode) -> ModeBudget:
        """Return the budget of a mode with steady rates."""
        file, mode = self.file, _refine_rates(mode, self.file, self.estimate)
        self.listener(f'mode "{mode.name}": {mode.rates.size} rate{"s" * (mode.rates.size > 1)}')
        found = steady_states(self.estimate.mechanism, mode, self.names, self.workers)
        states = tuple(tuple(self._respond(mode, state) for state in here) for here in found)
        responses = tuple(_largest_response(here) for here in states)
        levels = {r.name: level_curve(r, states, self.estimate, file.errors, file.seed) for r in file.requirements}
        worst = int(np.argmax([response.rms().max() for response in responses]))
        self.listener(f'mode "{mode.name}": two-way')
        joined = self._joinable()
        two_way = self._two_way_responses(on_modes(self.estimate.mechanism, joined), mode, found) if joined else ()
        lines = responses[worst].state.frequency_hz
        gain = largest_loop_gain(file.structure, self.estimate.mechanism, lines, mode.command)
        curves = {r.name: two_way_curve(r, levels[r.name], two_way, file.errors) for r in file.requirements if two_way}
        exerted = tuple(emission(r, self.estimate, mode.highest_hz, file.seed) for r in responses)
        made = ModeBudget(
            mode,
            responses,
            states,
            worst=worst,
            rms_band=rms_bands(responses, self.estimate, file.seed),
            total_band=total_bands(responses, self.estimate, file.seed),
            emissions=exerted,
            two_way=two_way,
            loop_gain=gain,
            levels=levels,
            two_way_curves=curves,
            two_way_levels={name: (int(c.level.argmax()), float(c.level.max())) for name, c in curves.items()},
        )
        return _with_deciding(self._with_standings(made))

    def _two_way_responses(
        self, mechanism: Mechanism, mode: OperatingMode, found: Sequence[Sequence[SteadyState]]
    ) -> tuple[Response, ...]:
        """Return the two-way responses: from rest and, where there are several steady states, from each of these."""
        # The coupled motion may depend on its start, so it is started from each one-way motion.
        held = self.estimate.mechanism.plant.states
        tasks = [
            (here[0].rate, [_on_resting_base(s.x, held, mechanism.plant.states) for s in here if len(here) > 1])
            for here in found
        ]
        joined = map_tasks(
            partial(_states_from, mechanism, mode, enough_substeps(mechanism, mode)), tasks, self.workers
        )
        return tuple(_largest_response([self._respond(mode, state) for state in states]) for states in joined)

    def _respond(self, mode: OperatingMode, state: SteadyState) -> Response:
        source = self.estimate.residual
        here = None if source is None else source.at(mode.command, state.rate)
        return respond(state, self.file.structure, here, mode.highest_hz, self._side(mode, state))

    def _side(self, mode: OperatingMode, state: SteadyState) -> SideResponse | None:
        """Return the response to the other components at a rate; None if none of them reaches the structure."""
        if self.side is None or not self.side.flying_components:
            return None
        return side_response(state, self.side, self.side.at(mode.command, state.rate), mode.highest_hz)

    def profile(self, mode: OperatingMode) -> ModeBudget:
        """Return the budget of a mode with a profile."""
        file, mechanism = self.file, self.estimate.mechanism
        self.listener(f'mode "{mode.name}": a profile of {mode.duration_s:.6g} s')
        course = run_profile(mechanism, mode, self.names, enough_substeps(mechanism, mode, self.names), file.structure)
        joined, two_way = self._joinable(), None
        if joined:
            moving = on_modes(mechanism, joined)
            two_way = run_profile(moving, mode, (), enough_substeps(moving, mode), file.structure)
        # A profile has no fixed lines: the gain is searched over the whole band.
        frequency = np.linspace(1.0, mode.highest_hz, 2000)
        gain = largest_loop_gain(file.structure, mechanism, frequency, mode.command)
        levels = self._two_way_levels(two_way) if two_way else {}
        made = ModeBudget(mode, course=course, two_way_course=two_way, loop_gain=gain, two_way_levels=levels)
        return self._with_standings(made)

    def _joinable(self) -> Modes | None:
        """Return the structural modes to couple with the mechanism; None without modes or for a fixed base."""
        if moving_base_objection(self.estimate.mechanism):
            return None
        return coupled_modes(self.file.structure, self.file.coupled_below_hz)

    def _two_way_levels(self, course: LineOfSight) -> dict[str, tuple[int, float]]:
        """Return the two-way level of a profile, by requirement."""
        return {r.name: (0, nominal_level(r, [(1.0, course)], self.file.errors)) for r in self.file.requirements}

    def _with_standings(self, made: ModeBudget) -> ModeBudget:
        self.listener(f'mode "{made.mode.name}": {len(self.file.requirements)} requirements')
        tasks = [(r, [(1.0, made.worst_for(r))]) for r in self.file.requirements]
        standings = map_tasks(partial(_assess, made.mode.name, self.estimate, self.ensemble), tasks, self.workers)
        return replace(made, standings=tuple(standings))

    def by_duty(self, modes: Sequence[ModeBudget]) -> tuple[Standing, ...]:
        """Return the standings of all modes together, each at its worst rate; empty if a mode has no duty."""
        if _lacks_duty(modes):
            return ()
        self.listener("all modes by duty")
        return tuple(
            assess_standing(
                r, BY_DUTY, [(made.mode.duty or 0.0, made.worst_for(r)) for made in modes], self.estimate, self.ensemble
            )
            for r in self.file.requirements
        )

    def two_way_by_duty(self, modes: Sequence[ModeBudget]) -> dict[str, float]:
        """Return complete two-way levels of the nominal unit for all modes together, rad, by requirement."""
        out: dict[str, float] = {}
        for r in () if _lacks_duty(modes) else self.file.requirements:
            parts = [(made.mode.duty or 0.0, worst) for made in modes if (worst := made.two_way_worst_for(r))]
            if len(parts) == len(modes):
                out[r.name] = nominal_level(r, parts, self.file.errors)
        return out


def _with_deciding(made: ModeBudget) -> ModeBudget:
    """Add the deciding levels over the rate and the rates to avoid to a mode of steady rates."""
    rates, curves = made.mode.rates, made.levels | made.two_way_curves
    deciding, avoid = {}, {}
    for s in made.standings:
        r = s.requirement
        decided = margins(s, made.two_way_levels.get(r.name, (0, None))[1])["decided"]
        # A large margin is a low level: the ends of the interval change places.
        low, high = (r.limit_rad * (1.0 - margin) for margin in decided["margin95"][::-1])
        deciding[r.name] = deciding_curve(curves[r.name], decided["level_rad"], (low, high))
        if rates.size > 1:
            avoid[r.name] = tuple(rates_to_avoid(rates, deciding[r.name].band[:, 1], r.limit_rad))
    return replace(made, deciding=deciding, avoid=avoid)


def _states_from(
    mechanism: Mechanism, mode: OperatingMode, substeps: int, task: tuple[float, Sequence[FloatArray]]
) -> list[SteadyState]:
    """Return the steady states at a rate, one from rest and one from each given start."""
    rate, states = task
    return [steady_state(mechanism, mode, rate, (), substeps, start) for start in (None, *states)]


def _assess(mode: str, estimate: Estimate, ensemble: Ensemble, task: tuple[Requirement, Parts]) -> Standing:
    requirement, parts = task
    return assess_standing(requirement, mode, parts, estimate, ensemble)


def _lacks_duty(modes: Sequence[ModeBudget]) -> bool:
    return any(made.mode.duty is None for made in modes)


def _largest_response(responses: Sequence[Response]) -> Response:
    """Return the response with the largest RMS along any line of sight, the non-repeating part included."""
    return max(responses, key=lambda response: float(response.whole_rms().max()))


def _on_resting_base(x: FloatArray, held: Sequence[Any], states: Sequence[Any]) -> FloatArray:
    """Extend a state of the mechanism on a held base with structural modes at rest."""
    known = dict(zip(held, x, strict=True))
    return np.array([known.get(state, 0.0) for state in states])


def _refine_rates(mode: OperatingMode, file: BudgetFile, estimate: Estimate) -> OperatingMode:
    """Add rates around each crossing of an order with a mode of the structure or the mechanism."""
    if not mode.refined:
        return mode
    ends = (float(mode.rates[0]), float(mode.rates[-1]))
    met = crossings(LEVEL.campbell_orders, named_modes(file.structure, estimate), ends)
    near = np.array([c.rate * (1.0 + side) for c in met for side in LEVEL.rates_at_crossing])
    inside = near[(near >= ends[0]) & (near <= ends[1])]
    return replace(mode, rates=np.unique(np.round(np.concatenate([mode.rates, inside]), 9)))


def _crossings(file: BudgetFile, estimate: Estimate) -> list[Crossing]:
    rates = [rate for mode in file.modes for rate in mode.rates]
    if not rates:
        return []
    around = (min(rates) * (1.0 - LEVEL.around_rates), max(rates) * (1.0 + LEVEL.around_rates))
    return crossings(LEVEL.campbell_orders, named_modes(file.structure, estimate), around)
