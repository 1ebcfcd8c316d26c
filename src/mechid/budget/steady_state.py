"""A mechanism stepped at one rate until it repeats: its lines, their derivatives, and what does not repeat."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mechid.budget.operating_mode import OperatingMode
from mechid.command import RateProfile
from mechid.errors import FitError
from mechid.plant.mechanism import Mechanism
from mechid.simulation.accuracy import simulate_accurately
from mechid.simulation.simulator import Simulator, TimeBase
from mechid.simulation.trajectory import SimulationOutcome

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

SAMPLE_RATE_HZ = 10_000.0
LEAST_PERIODS, LEAST_S = 4, 0.5
"""Of the stretch that is analysed."""


@dataclass(frozen=True, eq=False)
class SteadyState:
    """The torque on the base at one rate.

    Attributes
    ----------
    rate : float
        Full steps/s.
    orders : (n,) int
        The lines stand at these multiples of half the rate.
    lines : (n,) complex
        Peak amplitude and phase, N m.
    gradient : (n, p) complex
        Derivative of the lines to the parameters asked for.
    sample_rate_hz : float
    torque : (N,)
        Of the stretch that is analysed, N m.
    residual : (N,)
        What does not repeat with a period of 2/rate, N m.
    """

    rate: float
    orders: NDArray[np.int64]
    lines: ComplexArray
    gradient: ComplexArray
    sample_rate_hz: float
    torque: FloatArray
    residual: FloatArray

    @property
    def frequency_hz(self) -> FloatArray:
        """Of each line, (n,)."""
        return np.asarray(0.5 * self.rate * self.orders, dtype=np.float64)

    @property
    def step_orders(self) -> FloatArray:
        """Of each line, (n,): its multiple of the step rate."""
        return np.asarray(0.5 * self.orders, dtype=np.float64)

    @property
    def rms(self) -> float:
        """Of the torque about its mean, N m."""
        return float(np.std(self.torque))

    @property
    def unsteady(self) -> float:
        """Share of the RMS that does not repeat."""
        return float(np.sqrt(np.mean(self.residual**2))) / self.rms if self.rms > 0.0 else 0.0


def steady_state(
    mechanism: Mechanism, mode: OperatingMode, rate: float, names: Sequence[str], substeps: int
) -> SteadyState:
    """Return the lines of a mode at one rate, on a base that holds or on its modes.

    The samples are laid so that a period of 2/rate holds a whole number of them: each line is a bin of the
    transform of whole periods, and what lies on no such bin does not repeat.

    Parameters
    ----------
    mechanism : Mechanism
    mode : OperatingMode
    rate : float
        Full steps/s.
    names : sequence of str, (p,)
        Parameters to which the derivative is wanted; may be empty.
    substeps : int
        Integration steps a sample.

    Raises
    ------
    FitError
        The mechanism diverged.
    """
    per_period = math.ceil(2.0 * SAMPLE_RATE_HZ / rate)
    fs = 0.5 * per_period * rate
    periods = max(LEAST_PERIODS, math.ceil(LEAST_S * rate / 2.0))
    first = math.ceil(mode.settle_s * rate / 2.0) * per_period
    base = TimeBase(fs, first + periods * per_period)
    y, J = simulated(_simulator(mechanism, mode, rate, base, len(names)), mechanism, names, substeps)
    orders = np.arange(1, min(int(2.0 * mode.highest_hz / rate), per_period // 2 - 1) + 1)
    lines, residual = _lines(y[first:], periods, orders)
    gradient, _ = _lines(J[first:], periods, orders)
    return SteadyState(rate, orders, lines[:, 0], gradient, fs, y[first:, 0].copy(), residual[:, 0])


def enough_substeps(mechanism: Mechanism, mode: OperatingMode) -> int:
    """Return the integration steps a sample that the promised accuracy needs at the mode's highest rate."""
    base = TimeBase(SAMPLE_RATE_HZ, round(0.2 * SAMPLE_RATE_HZ))
    simulator = _simulator(mechanism, mode, mode.highest_rate, base, 0)
    return simulate_accurately(simulator, mechanism.kernel_values()).substeps


def _simulator(mechanism: Mechanism, mode: OperatingMode, rate: float, base: TimeBase, lanes: int) -> Simulator:
    command = replace(mode.command, rate=RateProfile.constant(rate))
    return Simulator(mechanism.plant, command, base, capacity=lanes)


def simulated(
    simulator: Simulator, mechanism: Mechanism, names: Sequence[str], substeps: int
) -> tuple[FloatArray, FloatArray]:
    """Return torque (n, 1) and its derivatives (n, p) to the parameters named.

    Raises
    ------
    FitError
        The mechanism diverged.
    """
    slopes = mechanism.kernel_jacobian()
    p = mechanism.kernel_values()
    directions = np.column_stack([slopes[name] for name in names]) if names else np.zeros((p.size, 0))
    run = simulator.run(p, substeps=substeps, directions=directions)
    n = simulator.base.samples
    y, J = np.empty((n, 1)), np.zeros((n, len(names)))
    for block in run.blocks():
        y[block.start : block.stop] = block.y[:, :1]
        if names:
            J[block.start : block.stop] = block.jacobian[:, 0, : len(names)]
    if run.outcome is not SimulationOutcome.COMPLETE:
        raise FitError(f"at {max(simulator.command.rate.rates, key=abs):.6g} steps/s: {run.outcome.value}")
    return y, J


def _lines(y: FloatArray, periods: int, orders: NDArray[np.int64]) -> tuple[ComplexArray, FloatArray]:
    """Return the lines (n, m) of samples (N, m) over whole periods, and what does not repeat, without mean."""
    spectrum = np.fft.rfft(y, axis=0)
    lines = 2.0 / len(y) * spectrum[orders * periods]
    spectrum[::periods] = 0.0
    return lines, np.fft.irfft(spectrum, n=len(y), axis=0)
