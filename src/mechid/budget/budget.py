"""The budget: every mode of operation through the structure, against every requirement."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mechid.budget.budget_file import BudgetFile, OperatingMode
from mechid.budget.coupling import SUFFICES, coupled_modes, loop_gain
from mechid.budget.flying_mechanism import Estimate, on_base, read_flying
from mechid.budget.line_of_sight import Response, ensemble_draws, nominal_level, respond, standing
from mechid.budget.orders import Crossing, OrderMap, crossings, rates_to_avoid
from mechid.budget.requirement import Standing
from mechid.budget.steady_state import SteadyState, enough_substeps, steady_state
from mechid.identification.parallel import mapped, one_core_algebra
from mechid.plant.mechanism import Mechanism
from mechid.structure import Modes, Structure

FloatArray = NDArray[np.float64]

CAMPBELL_ORDERS = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 16.0)
"""Lines a full step whose crossings with modes are listed."""
TOLD_UNCOVERED, TOLD_UNSTEADY = 0.05, 0.05


@dataclass(frozen=True, eq=False)
class ModeBudget:
    """One mode of operation.

    Attributes
    ----------
    mode : OperatingMode
    responses : tuple of Response, (r,)
        One-way, at each rate.
    worst : int
        Position of the rate with the largest RMS along any line of sight.
    two_way : Response or None
        At the worst rate, the structure's modes joined with the mechanism.
    loop_gain : float
        Largest |receptance x dynamic stiffness| at the lines of the worst rate; NaN where not known.
    standings : tuple of Standing
        At the worst rate of each requirement.
    avoid : mapping of requirement to ranges
        Rates, from and to, at which the nominal level exceeds the limit; of a mode with several rates.
    """

    mode: OperatingMode
    responses: tuple[Response, ...]
    worst: int
    two_way: Response | None
    loop_gain: float
    standings: tuple[Standing, ...]
    avoid: dict[str, tuple[tuple[float, float], ...]]

    @property
    def order_map(self) -> OrderMap:
        """Torque lines over the rate, N m."""
        most = max(response.state.orders.size for response in self.responses)
        lines = np.full((len(self.responses), most), np.nan, dtype=np.complex128)
        for row, response in enumerate(self.responses):
            lines[row, : response.state.lines.size] = response.state.lines
        return OrderMap(self.mode.rates, 0.5 * np.arange(1.0, most + 1.0, dtype=np.float64), lines)


@dataclass(frozen=True, eq=False)
class Budget:
    """What a budget file leads to."""

    file: BudgetFile
    estimate: Estimate
    modes: tuple[ModeBudget, ...]
    crossings: tuple[Crossing, ...]
    warnings: tuple[str, ...]


def make_budget(file: BudgetFile, workers: int = 1, listener: Callable[[str], None] | None = None) -> Budget:
    """Return the budget of a file.

    Parameters
    ----------
    file : BudgetFile
    workers : int
        Threads.
    listener : callable or None
        Told in a line what is at work.

    Raises
    ------
    InputFileError
        The estimate is missing or wrong, or does not fit the file.
    FitError
        The mechanism diverged.
    """
    estimate = read_flying(file.estimate, file.flight)
    with one_core_algebra():
        modes = tuple(_mode_budget(mode, file, estimate, workers, listener or _silent) for mode in file.modes)
    return Budget(file, estimate, modes, tuple(_crossings(file, estimate)), tuple(_warnings(file, estimate, modes)))


def _silent(line: str) -> None:
    """Listen to nothing."""


def _mode_budget(
    mode: OperatingMode, file: BudgetFile, estimate: Estimate, workers: int, listener: Callable[[str], None]
) -> ModeBudget:
    listener(f'mode "{mode.name}": {mode.rates.size} rates')
    names = (*estimate.names, *file.flight.spread)
    substeps = enough_substeps(estimate.mechanism, mode)
    one = partial(_steady, estimate.mechanism, mode, names, substeps)
    states = mapped(one, [float(rate) for rate in mode.rates], workers)
    responses = tuple(respond(state, file.structure) for state in states)
    worst = int(np.argmax([response.rms().max() for response in responses]))
    draws = ensemble_draws(len(file.flight.spread), file.seed)
    spread = np.array(list(file.flight.spread.values()))
    standings, avoid = [], {}
    for requirement in file.requirements:
        levels = np.array([nominal_level(requirement, r) for r in responses])
        at = responses[int(levels.argmax())]
        standings.append(standing(requirement, mode.name, at, estimate, spread, draws))
        if mode.rates.size > 1:
            avoid[requirement.name] = tuple(rates_to_avoid(mode.rates, levels, requirement.limit_rad))
    listener(f'mode "{mode.name}": two-way at {mode.rates[worst]:.6g} steps/s')
    state = responses[worst].state
    gains = loop_gain(file.structure, estimate.mechanism, state.frequency_hz)
    return ModeBudget(
        mode, responses, worst, _two_way(mode, file, estimate, state), float(np.nanmax(gains, initial=0.0)),
        tuple(standings), avoid,
    )  # fmt: skip


def _steady(mechanism: Mechanism, mode: OperatingMode, names: Sequence[str], substeps: int, rate: float) -> SteadyState:
    return steady_state(mechanism, mode, rate, names, substeps)


def _two_way(mode: OperatingMode, file: BudgetFile, estimate: Estimate, held: SteadyState) -> Response | None:
    """Return the response with the structure's modes joined, at the same rate."""
    modes = coupled_modes(file.structure, file.coupled_below_hz)
    if modes is None:
        return None
    mechanism = on_base(estimate.mechanism, modes)
    substeps = enough_substeps(mechanism, mode)
    return respond(steady_state(mechanism, mode, held.rate, (), substeps), file.structure)


def _crossings(file: BudgetFile, estimate: Estimate) -> list[Crossing]:
    rates = [rate for mode in file.modes for rate in mode.rates]
    return crossings(CAMPBELL_ORDERS, _named_modes(file.structure, estimate, file), (min(rates), max(rates)))


def _named_modes(structure: Structure, estimate: Estimate, file: BudgetFile) -> list[tuple[str, float]]:
    """Return the modes that orders may meet: of gear and load on a stuck rotor, of the load, of the structure."""
    v = estimate.mechanism.value
    named = [("gear and load", float(np.sqrt(v("gear.stiffness") / v("load.inertia")) / (2.0 * np.pi)))]
    named += [(f"load {k}", mode.frequency_hz) for k, mode in enumerate(file.flight.load_modes)]
    if isinstance(structure.model, Modes):
        modes = structure.model
        named += [(f"structure {k}", float(f)) for k, f in enumerate(modes.frequency_hz) if not modes.rigid[k]]
    return named


def _warnings(file: BudgetFile, estimate: Estimate, modes: Sequence[ModeBudget]) -> list[str]:
    out = [f"{file.structure.name}: {line}" for line in file.structure.warnings]
    if estimate.outcome:
        out.append(f"{file.estimate.name}: {estimate.outcome} A budget of it is worth no more")
    if estimate.removed:
        out.append(f"left on the bench: {', '.join(estimate.removed)}")
    for budget in modes:
        name, at = budget.mode.name, budget.responses[budget.worst]
        if at.uncovered > TOLD_UNCOVERED:
            low, high = file.structure.coverage_hz
            share = 100.0 * at.uncovered
            out.append(f'mode "{name}": {share:.2g} % of its torque is outside {low:.4g} to {high:.4g} Hz, not counted')
        unsteady = max(budget.responses, key=lambda r: r.state.unsteady).state
        if unsteady.unsteady > TOLD_UNSTEADY:
            share = 100.0 * unsteady.unsteady
            out.append(
                f'mode "{name}": at {unsteady.rate:.6g} steps/s {share:.2g} % of the torque does not repeat with the '
                "steps; it counts as random; a longer settle_s may let it settle"
            )
        if not np.isnan(budget.loop_gain) and budget.loop_gain > SUFFICES:
            gain = budget.loop_gain
            out.append(f'mode "{name}": |receptance x dynamic stiffness| reaches {gain:.2g}: take the two-way result')
    return out
