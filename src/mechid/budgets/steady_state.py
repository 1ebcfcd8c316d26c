"""Steady state of a mechanism at one step rate: lines, their derivatives, and the non-repeating part."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mechid.arrays import BoolArray, ComplexArray, FloatArray
from mechid.budgets.incommensurate import IncommensurateLines, incommensurate_lines, map_period
from mechid.budgets.lines import Lines, lines_of_repeating, lines_with_scatter
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.orbit import Orbit, find_orbit
from mechid.budgets.period_map import PeriodMap, directions
from mechid.budgets.settings import MOTION
from mechid.errors import FitError
from mechid.plant.flight import with_line_filter
from mechid.plant.mechanism import Mechanism
from mechid.simulation.accuracy import simulate_accurately
from mechid.simulation.block import State
from mechid.simulation.simulator import Simulator
from mechid.simulation.trajectory import SimulationOutcome


@dataclass(frozen=True, eq=False)
class SteadyState:
    """Torque on the base at one rate.

    Attributes
    ----------
    rate : float
        Full steps/s.
    steps : int
        Full steps after which the mechanism's equations are the same.
    periods : int
        Number of such periods after which the motion repeats; 0 if it does not.
    orders : (n,)
        Lines, as multiples of `fundamental_hz`; fractions are lines of harmonics that do not repeat with the steps.
    lines : (n,) complex
        Peak amplitude and phase, N m.
    gradient : (n, p) complex
        Derivative of the lines with respect to the requested parameters.
    error : (n,)
        Error of the lines, N m: sampling and integration, or, for a motion that does not repeat, the scatter over its
        section.
    sample_rate_hz : float
    samples_a_period : float
        Of the finest samples from which the lines were computed.
    torque : (N,)
        Section of the motion, N m.
    residual : (N,)
        Non-repeating part, N m.
    rms : float
        RMS of the torque about its mean, N m.
    rms_error : float
        Standard error of `rms`, N m, over the section of a motion that does not repeat; otherwise 0.
    x : (n_x,)
        State at the start of the section.
    multipliers : (k,) complex
        Floquet multipliers over `periods`, largest first; empty for a motion that does not repeat.
    follows : bool
        Whether the rotor keeps up with the command.
    size : (n_x,)
        Range of each state.
    reached : tuple of str
        Ways in which the motion was reached: from rest, or from that of the next lower or higher rate.
    """

    rate: float
    steps: int
    periods: int
    orders: FloatArray
    lines: ComplexArray
    gradient: ComplexArray
    error: FloatArray
    sample_rate_hz: float
    samples_a_period: float
    torque: FloatArray
    residual: FloatArray
    rms: float
    rms_error: float
    x: FloatArray
    multipliers: ComplexArray
    follows: bool
    size: FloatArray
    reached: tuple[str, ...] = ()

    @property
    def fundamental_hz(self) -> float:
        """Frequency of which all lines are multiples: half the rate if the mechanism repeats after two steps."""
        return self.rate / (self.steps * max(self.periods, 1))

    @property
    def largest_multiplier(self) -> float:
        """Modulus of the largest Floquet multiplier; NaN if the motion does not repeat."""
        return float(np.abs(self.multipliers[0])) if self.multipliers.size else math.nan

    @property
    def decay_s(self) -> float:
        """Time in which the slowest transient falls to 1/e; NaN if the motion does not repeat."""
        # A multiplier of 0 means that transients vanish within one repetition.
        largest = self.largest_multiplier
        return -self.steps * self.periods / self.rate / math.log(largest) if largest != 0.0 else 0.0

    @property
    def frequency_hz(self) -> FloatArray:
        """Frequency of each line, (n,)."""
        return np.asarray(self.fundamental_hz * self.orders, dtype=np.float64)

    @property
    def step_orders(self) -> FloatArray:
        """Multiple of the step rate of each line, (n,), rounded so that equal orders compare as equal."""
        return np.round(self.orders / (self.steps * max(self.periods, 1)), MOTION.digits)

    @property
    def is_periodic(self) -> BoolArray:
        """Whether each line is a whole multiple of `fundamental_hz`, (n,)."""
        return np.asarray(self.orders % 1.0 == 0.0, dtype=np.bool_)

    def phase_changes(self, moved: ComplexArray) -> FloatArray:
        """Return the phase changes of the lines, (k, n) rad, for small changes (k, n) N m; 0 for a line of zero."""
        # To first order the phase changes by the imaginary part of the relative change.
        here = self.lines != 0.0
        return np.asarray(np.imag(moved * np.where(here, 1.0 / np.where(here, self.lines, 1.0), 0.0)))

    @property
    def floor(self) -> FloatArray:
        """Amplitude above which each line is accurate to `MOTION.relative`, (n,) N m, at least `MOTION.verified`."""
        least = MOTION.verified * float(np.abs(self.lines).max(initial=0.0))
        return np.maximum(self.error / MOTION.relative, least)

    @property
    def unsteady(self) -> float:
        """Share of the RMS that does not repeat."""
        return float(np.sqrt(np.mean(self.residual**2))) / self.rms if self.rms > 0.0 else 0.0


def steady_state(
    mechanism: Mechanism,
    mode: OperatingMode,
    rate: float,
    names: Sequence[str],
    substeps: int,
    start: FloatArray | None = None,
) -> SteadyState:
    """Return the lines of a mode at one rate, on a held base or coupled with structural modes.

    The motion is simulated until it approaches a periodic one, which shooting then determines, so that slow transients
    are removed. A motion that does not repeat, such as any on a clock with a tick, is analysed over whole periods of
    the equations; the part that lies on none of their lines is the non-repeating part.

    Parameters
    ----------
    mechanism : Mechanism
    mode : OperatingMode
    rate : float
        Full steps/s.
    names : sequence of str, (p,)
        Parameters whose derivatives are needed; may be empty.
    substeps : int
        Integration steps per sample.
    start : (n_x,) or None
        Initial state; None is at rest.

    Raises
    ------
    FitError
        The mechanism diverged.
    """
    period = map_period(with_line_filter(mechanism, cut_off(mode)), mode, rate, names, substeps)
    settle = periods_to_settle(mode, period.duration_s)
    if not period.repeats:
        return _non_repeating_state(period, start, settle)
    x = start
    for k in range(MOTION.rounds):
        # Longer repetitions are searched in the last round only: a slow transient of period one looks like one of
        # period two.
        x = period.state_after(x, settle)
        orbit = find_orbit(period, x, MOTION.most_periods if k + 1 == MOTION.rounds else 1)
        if orbit is not None:
            state = _repeating_state(period, orbit)
            if state is None:
                break
            return state
    return _non_repeating_state(period.of_whole, start, MOTION.rounds * settle)


def cut_off(mode: OperatingMode) -> float:
    """Return the cut-off of the anti-alias filter of a mode's lines, rad/s: its highest frequency."""
    return 2.0 * math.pi * mode.highest_hz


def periods_to_settle(mode: OperatingMode, duration_s: float) -> int:
    """Return the number of periods until a mode is taken as steady."""
    return math.ceil(mode.settle_s / duration_s)


def _repeating_state(period: PeriodMap, orbit: Orbit) -> SteadyState | None:
    """Return the steady state of a repeating motion, computed over one repetition, with lines beside its own.

    None if these are too large for a linear response.
    """
    found = lines_of_repeating(period, orbit)
    times = math.ceil(MOTION.least_s / (period.duration_s * orbit.periods))
    torque = np.tile(found.torque, max(times, 1))
    if period.apart:
        beside = incommensurate_lines(period, orbit, float(np.abs(found.values).max(initial=0.0)))
        if beside is None:
            return None
        at = 2j * np.pi * np.arange(torque.size) / found.torque.size
        torque = torque + sum(
            (line * np.exp(at * q)).real for q, line in zip(beside.orders, beside.values, strict=True)
        )
        found = _with_lines(found, beside)
    return SteadyState(
        **_line_fields(period, found),
        periods=orbit.periods,
        torque=torque,
        residual=np.zeros(torque.size),
        rms_error=0.0,
        x=orbit.x,
        multipliers=orbit.multipliers,
        follows=orbit.turns == 0,
        size=orbit.size,
    )


def _with_lines(found: Lines, beside: IncommensurateLines) -> Lines:
    """Return the lines of a repeating motion with those beside them, in ascending order."""
    orders = np.concatenate([found.orders, beside.orders])
    at = np.argsort(orders, kind="stable")
    return replace(
        found,
        orders=orders[at],
        values=np.concatenate([found.values, beside.values])[at],
        gradient=np.concatenate([found.gradient, beside.gradient])[at],
        error=np.concatenate([found.error, beside.error])[at],
        power=found.power + 0.5 * float(np.sum(np.abs(beside.values) ** 2)),
    )


def _non_repeating_state(period: PeriodMap, start: FloatArray | None, skipped: int) -> SteadyState:
    """Return the steady state of a motion that does not repeat, over a section after skipped periods."""
    periods = math.ceil(MOTION.endless_s / period.duration_s)
    at_rest = None if start is None else State(start, np.zeros((start.size, len(period.names))))
    found, residual, rms_error = lines_with_scatter(period, at_rest, skipped, periods)
    x = period.state_after(start, skipped)
    on = period(x, periods)
    return SteadyState(
        **_line_fields(period, found),
        periods=0,
        torque=found.torque,
        residual=residual,
        rms_error=rms_error,
        x=x,
        multipliers=np.zeros(0, dtype=np.complex128),
        follows=period.turns_off(on.x - x) == 0,
        size=on.size,
    )


def _line_fields(period: PeriodMap, found: Lines) -> dict[str, Any]:
    return {
        "rate": period.rate,
        "steps": period.steps,
        "orders": found.orders,
        "lines": found.values,
        "gradient": found.gradient,
        "error": found.error,
        "sample_rate_hz": found.sample_rate_hz,
        "samples_a_period": found.sample_rate_hz * period.duration_s,
        # Rounding may leave a power near 0 negative.
        "rms": math.sqrt(max(found.power, 0.0)),
    }


def enough_substeps(mechanism: Mechanism, mode: OperatingMode, names: Sequence[str] = ()) -> int:
    """Return the integration steps per sample that the promised accuracy needs at the mode's highest rate.

    Given the `names` of the derivatives that are needed later, it compiles the kernel that they use.
    """
    # The highest rate is the most demanding one: its step count serves all rates.
    period = PeriodMap(with_line_filter(mechanism, cut_off(mode)), mode, mode.highest_rate, tuple(names), 1)
    simulator = period.simulator(round(0.2 * MOTION.sample_rate_hz), period.lanes)
    return simulate_accurately(simulator, period.mechanism.kernel_values()).substeps


def simulate_torque(
    simulator: Simulator, mechanism: Mechanism, names: Sequence[str], substeps: int, start: State | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return torque (n, 1) and its derivatives (n, p) with respect to named parameters.

    Raises
    ------
    FitError
        The mechanism diverged.
    """
    p, moved = mechanism.kernel_values(), directions(mechanism, names)
    run = simulator.run(p, substeps=substeps, directions=moved)
    if start is not None:
        run.restart(start)
    n = simulator.base.samples
    y, J = np.empty((n, 1)), np.zeros((n, len(names)))
    for block in run.blocks():
        y[block.start : block.stop] = block.y[:, :1]
        if names:
            J[block.start : block.stop] = block.jacobian[:, 0, : len(names)]
    if run.outcome is not SimulationOutcome.COMPLETE:
        raise FitError(f"at {max(simulator.command.rate.rates, key=abs):.6g} steps/s: {run.outcome.value}")
    return y, J
