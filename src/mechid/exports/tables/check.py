"""Verification of the tables: comparison with direct simulations, and reading back of all files."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.budgets.attractors import FROM_REST
from mechid.budgets.incommensurate import map_period
from mechid.budgets.lines import filter_decay_s
from mechid.budgets.steady_state import SteadyState
from mechid.command import RateProfile
from mechid.errors import FitError, UsageError
from mechid.exports.forcing import Forcing
from mechid.plant.flight import keeps_stand
from mechid.plant.mechanism import Mechanism
from mechid.simulation.simulator import Simulator, TimeBase
from mechid.simulation.trajectory import SimulationOutcome

# Where the torque jumps, a sample is an average, with an error of first order in its length.
SAMPLES_HZ = 200_000.0
"""Least sample rate of the coarser of two direct simulations; two lengths of samples allow extrapolation."""
LEAST_S, DECAYS = 1.0, 20.0
"""Simulated time before the evaluation: least duration, and multiple of the decay time of the slowest transient."""
STRETCH_S = 0.25
"""Least duration from which lines are computed."""
# All files have at least ten digits.
ALIKE = 1e-9
"""Largest relative difference between a written and a read number."""


@dataclass(frozen=True, eq=False)
class DirectComparison:
    """Comparison of the lines at one rate with a direct simulation.

    Attributes
    ----------
    stepping : str
    rate : float
        Rate in full steps/s.
    seconds : float
        Simulated time from rest.
    off : (n,)
        Differences of the amplitudes in N m.
    largest : float
        Largest line in N m.
    """

    stepping: str
    rate: float
    seconds: float
    off: FloatArray
    largest: float


def compare_directly(lined: Mechanism, lanes: int, forcing: Forcing) -> DirectComparison | None:
    """Compare the motion with the largest torque; None if no periodic motion is reached from rest.

    Parameters
    ----------
    lined : Mechanism
        Mechanism on a held base with filtered lines (`plant.flight.with_line_filter`); the unfiltered torque is used.
    lanes : int
        Number of derivatives in its kernel.
    forcing : Forcing
    """
    plain = [state for here in forcing.states for state in here if state.periods and FROM_REST in state.reached]
    if not plain:
        return None
    state = max(plain, key=lambda one: one.rms)
    period_s = state.steps * state.periods / state.rate
    skipped = math.ceil(max(LEAST_S, DECAYS * max(state.decay_s, _stand_decay_s(lined))) / period_s)
    times = math.ceil(STRETCH_S / period_s)
    # Harmonics that do not repeat with the steps are no part of a periodic motion.
    periodic = map_period(lined, forcing.mode, state.rate, (), 1).mechanism
    coarse, fine = (_lines(periodic, lanes, forcing, state, skipped, times, finer) for finer in (1, 2))
    # Richardson extrapolation: the error is of first order in the sample length.
    off = np.abs(2.0 * fine - coarse) - np.abs(state.lines[state.is_periodic])
    return DirectComparison(
        forcing.stepping.name, state.rate, (skipped + times) * period_s, off, float(abs(state.lines).max())
    )


def _stand_decay_s(lined: Mechanism) -> float:
    """Return the 1/e decay time of the test stand's filters; the filter of lines is not included."""
    return filter_decay_s(lined) if keeps_stand(lined) else 0.0


def _lines(
    lined: Mechanism, lanes: int, forcing: Forcing, state: SteadyState, skipped: int, times: int, finer: int
) -> ComplexArray:
    """Return the lines of the last whole periods of a simulation from rest, (n,) N m."""
    each = state.steps * state.periods * forcing.stepping.command.steps_per_full_step
    period_s = state.steps * state.periods / state.rate
    samples = finer * each * math.ceil(SAMPLES_HZ * period_s / each)
    # The first sample lies half an interval after the first step, so that no step falls on a sample.
    late_s = 0.5 * period_s / samples
    command = replace(forcing.stepping.command, rate=RateProfile.constant(state.rate))
    base = TimeBase(samples / period_s, (skipped + times) * samples, late_s)
    run = Simulator(lined.plant, command, base, capacity=lanes).run(
        lined.kernel_values(), directions=np.zeros((lined.kernel_values().size, 0))
    )
    first, torque = skipped * samples, np.empty(times * samples)
    for block in run.blocks():
        if block.stop > first:
            kept = block.y[max(first - block.start, 0) :, 0]
            torque[block.stop - kept.size - first : block.stop - first] = kept
    if run.outcome is not SimulationOutcome.COMPLETE:
        raise FitError(f"at {state.rate:.6g} steps/s: {run.outcome.value}")
    turned = np.exp(-2j * np.pi * state.frequency_hz[state.is_periodic] * late_s)
    bins = np.round(state.orders[state.is_periodic] * times).astype(np.int64)
    return np.asarray(2.0 / torque.size * np.fft.rfft(torque)[bins] * turned, dtype=np.complex128)


def refuse_difference(file: Path, written: Mapping[str, FloatArray], read: Mapping[str, FloatArray]) -> None:
    """Refuse a file whose numbers differ from those written.

    Raises
    ------
    UsageError
        The numbers differ.
    """
    for name, values in written.items():
        if not np.allclose(read[name], values, rtol=ALIKE, atol=0.0, equal_nan=True):
            raise UsageError(f"{file.name}: column {name} holds other numbers than were written; try another disk")
