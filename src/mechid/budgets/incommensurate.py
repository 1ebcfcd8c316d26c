"""Lines of harmonics whose period does not fit the steps, as of a tooth mesh: linear response about a periodic motion.

A harmonic c sin(k alpha) + s cos(k alpha) = Re[(s - i c) e^(i k alpha)] with k T_alpha no multiple of 2 pi, where the
rotor turns by T_alpha in a repetition, keeps a motion from repeating. Without it the motion repeats, and its derivative
z to the harmonic, forced by e^(i k alpha), is the periodic motion's frequency response: over a repetition it returns to
itself but for a turn,

    z(T) = M z(0) + b = e^(i kappa) z(0),   z(0) = (e^(i kappa) I - M)^-1 b,   kappa = k T_alpha mod 2 pi

with M and b the derivatives of the period map to the state and to the harmonic. So e^(-i kappa t/T) z(t) is periodic,
and the torque has lines at (j + kappa/(2 pi))/T for all whole j: that at k and its sidebands. One repetition suffices,
however close the orders of several meshes are. N. M. Wereley, PhD thesis, MIT 1991 (harmonic transfer functions).

The lines are proportional to the amplitude. What this leaves out is measured: the whole mechanism is simulated beside
it from the same start. If the difference exceeds `MOTION.linear`, the motion counts as one that does not repeat.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.budgets.lines import filter_settling_s, through_filter
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.orbit import Orbit
from mechid.budgets.period_map import PeriodMap, directions
from mechid.budgets.settings import MOTION
from mechid.plant.block import PolarPair
from mechid.plant.mechanism import Mechanism
from mechid.simulation.block import State
from mechid.simulation.repetition import MOST_STEPS


@dataclass(frozen=True, eq=False)
class IncommensurateLines:
    """Lines of a torque at multiples of a frequency that are no whole numbers.

    Attributes
    ----------
    orders : (n,)
        Ascending, multiples of the fundamental of the periodic motion.
    values : (n,) complex
        Peak amplitude and phase, N m.
    gradient : (n, p) complex
        Their derivatives to amplitudes and phases of the harmonics, 0 for other parameters.
    error : (n,)
        What the linear response leaves out, N m.
    """

    orders: FloatArray
    values: ComplexArray
    gradient: ComplexArray
    error: FloatArray


def map_period(
    mechanism: Mechanism, mode: OperatingMode, rate: float, names: Sequence[str], substeps: int
) -> PeriodMap:
    """Return the period map of a mechanism, without the harmonics that alone keep its motion from repeating.

    Parameters
    ----------
    mechanism : Mechanism
        In flight, with its line filter.
    mode : OperatingMode
    rate : float
        Full steps/s.
    names : sequence of str, (p,)
        Parameters whose derivatives are needed.
    substeps : int
    """
    whole = PeriodMap(mechanism, mode, rate, tuple(names), substeps)
    if whole.repeats or mode.command.clock_tick_s:
        return whole
    apart = _without_period(mechanism, min(MOTION.quick_s * rate, MOST_STEPS), mode.command.mirrored_steps)
    # A tied amplitude is another harmonic's too.
    if not apart or any(mechanism.parameters[pair.amplitude].tied_to for pair in apart):
        return whole
    rest = mechanism.with_values({pair.amplitude: 0.0 for pair in apart})
    period = replace(whole, mechanism=rest, whole=mechanism, apart=apart)
    return period if period.repeats else whole


def _without_period(mechanism: Mechanism, most_steps: float, voltages: int) -> tuple[PolarPair, ...]:
    """Return the harmonics over the rotor's angle that do not repeat, together with the others, within some steps."""
    if mechanism.electrical_periods is None:
        return ()
    steps = np.arange(voltages, int(most_steps) + 1, voltages)
    turns = steps / (mechanism.full_steps * mechanism.electrical_periods)
    apart, own, together = [], [], voltages
    for pair in mechanism.plant.polar_pairs:
        cycles = turns * float(pair.cycles.subs(mechanism.by_symbol))
        found = steps[np.abs(cycles - np.round(cycles)) < MOTION.whole_cycles]
        if mechanism.value(pair.amplitude):
            own.append((int(found[0]) if found.size else 0, pair))
    # Short periods first: they are those of the motor, and most have a common multiple.
    for period, pair in sorted(own, key=lambda one: one[0]):
        joint = math.lcm(together, period)
        if 0 < joint <= most_steps:
            together = joint
        else:
            apart.append(pair)
    return tuple(apart)


def incommensurate_lines(period: PeriodMap, orbit: Orbit, largest: float) -> IncommensurateLines | None:
    """Return the lines of the harmonics that a period map leaves out; None if they are not small enough for it.

    Parameters
    ----------
    period : PeriodMap
    orbit : Orbit
    largest : float
        Amplitude of the largest line of the periodic motion, N m; lines far below it are left out.

    Raises
    ------
    FitError
        The mechanism diverged.
    """
    whole = period.of_whole.mechanism
    p, m = whole.kernel_values(), orbit.periods
    parts = [whole.plant.parameters.index(s) for pair in period.apart for s in (pair.sine, pair.cosine)]
    # Re[(s - i c) z]: the first lane of a pair is the response to cos(k alpha), the second to sin(k alpha).
    size = p[parts[::2]] - 1j * p[parts[1::2]]
    turn = np.array([_turn(period, pair, m) for pair in period.apart])
    z, share = _responses(period, orbit, parts, turn, size)
    if not share <= MOTION.linear:
        return None
    slopes = directions(whole, period.names)[parts]
    lines = _collect(period, m, turn, z, size, slopes[::2] - 1j * slopes[1::2])
    named = [round(q, MOTION.digits) for q in turn.tolist()]
    least = MOTION.kept_line * max(largest, *(abs(value) for value, _ in lines.values()))
    kept = {q: line for q, line in sorted(lines.items()) if abs(line[0]) > least or q in named}
    values = np.array([value for value, _ in kept.values()], dtype=np.complex128)
    gradient = np.array([slope for _, slope in kept.values()], dtype=np.complex128)
    return IncommensurateLines(np.array(list(kept)), values, gradient, share * np.abs(values))


def _responses(
    period: PeriodMap, orbit: Orbit, parts: Sequence[int], turn: FloatArray, size: ComplexArray
) -> tuple[ComplexArray, float]:
    """Return the filtered torque's response z to each harmonic over a repetition, (N, k), and its nonlinear share."""
    m = orbit.periods
    own = np.zeros((period.mechanism.kernel_values().size, len(parts)))
    own[parts, np.arange(len(parts))] = 1.0
    image = period(orbit.x, m, own=own)
    forced = image.by_parameter[:, ::2] + 1j * image.by_parameter[:, 1::2]
    start = np.column_stack([_quasi_periodic_start(image.by_state, b, k) for b, k in zip(forced.T, turn, strict=True)])
    lanes = np.stack([start.real, start.imag], axis=-1).reshape(len(start), -1)
    skipped = m * math.ceil(filter_settling_s(period) / (m * period.duration_s))
    times = m * math.ceil(MOTION.least_s / (m * period.duration_s))
    along = period.stretch(State(orbit.x, lanes), skipped, times, own=own)
    z = along.below[:, 1::2] + 1j * along.below[:, 2::2]
    share = _nonlinear_share(period, orbit.x + (start @ size).real, along.below[:, 0], (z @ size).real, skipped)
    return z[: len(z) * m // times], share


def _turn(period: PeriodMap, pair: PolarPair, periods: int) -> float:
    """Return the cycles of a harmonic over some periods."""
    mechanism = period.mechanism
    steps = mechanism.full_steps * (mechanism.electrical_periods or math.nan)
    return periods * period.steps * float(pair.cycles.subs(mechanism.by_symbol)) / steps


def _quasi_periodic_start(by_state: FloatArray, forced: ComplexArray, turn: float) -> ComplexArray:
    """Return z(0) = (e^(2 pi i turn) I - M)^-1 b, (n,) complex."""
    matrix = np.exp(2j * np.pi * turn) * np.eye(len(by_state)) - by_state
    return np.asarray(np.linalg.solve(matrix, forced), dtype=np.complex128)


def _nonlinear_share(period: PeriodMap, x: FloatArray, periodic: FloatArray, linear: FloatArray, skipped: int) -> float:
    """Return what the linear response misses of the whole mechanism's torque, over the response's RMS."""
    periods = round(periodic.size / period.samples)
    start, values = State(x, np.zeros((x.size, 0))), period.of_whole.mechanism.kernel_values()
    found = period.stretch(start, skipped, periods, slopes=False, values=values).below[:, 0]
    off = found - periodic - linear
    return float(np.sqrt(np.mean(off**2) / np.mean(linear**2)))


def _collect(
    period: PeriodMap, m: int, turn: FloatArray, z: ComplexArray, size: ComplexArray, slopes: ComplexArray
) -> dict[float, tuple[complex, ComplexArray]]:
    """Return line and gradient by order, multiples of the fundamental; lines of one frequency add with their phases."""
    n, most = len(z), int(m * period.duration_s * period.mode.highest_hz)
    lines: dict[float, tuple[complex, ComplexArray]] = {}
    for k, kappa in enumerate((turn % 1.0).tolist()):
        found = np.fft.fft(z[:, k] * np.exp(-2j * np.pi * kappa * np.arange(n) / n)) / n
        number = np.arange(-most, most)
        values = found[number] / through_filter(period, (number + kappa) / (m * period.duration_s))
        for order, value in zip((number + kappa).tolist(), values.tolist(), strict=True):
            line, slope, key = value * size[k], value * slopes[k], round(abs(order), MOTION.digits)
            # A line at a negative frequency is the conjugate of one at the positive.
            line, slope = (line, slope) if order > 0.0 else (line.conjugate(), slope.conj())
            before = lines.get(key, (0j, np.zeros(slope.size)))
            lines[key] = before[0] + line, before[1] + slope
    return lines
