"""Spectral lines of the torque in flight, without aliasing: from filtered samples, the filter's response divided out.

Friction makes the torque jump. Its lines therefore fall off only as 1/f, and plain sampling folds them back: at 10 kHz
a line at 460 Hz is off by several percent. The torque instead passes a Butterworth filter of order 8 before sampling.
The filter is integrated in closed form, across steps and switches, like the other linear parts of the plant. At ten
samples per period of the cut-off, a component that folds back to a line has been attenuated to 1/9^8. The lines are
then divided by the filter's response.

The error left by sampling and integration is measured: the same motion is computed with twice as many samples and
steps. If the lines differ by more than `MOTION.promised` of the largest, both are doubled again.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import sympy as sp

from mechid.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from mechid.budgets.orbit import Orbit
from mechid.budgets.period_map import PeriodMap, Stretch
from mechid.budgets.settings import MOTION
from mechid.errors import FitError
from mechid.plant.flight import CUT_OFF
from mechid.plant.mechanism import Mechanism
from mechid.plant.mechanisms import LINE_ORDER
from mechid.plant.plant import Plant
from mechid.plant.test_stand import anti_alias_response
from mechid.signal.power import periodic_power
from mechid.simulation.block import State


@dataclass(frozen=True, eq=False)
class Lines:
    """Lines of a torque at multiples of a frequency.

    Attributes
    ----------
    orders : (n,)
    values : (n,) complex
        Peak amplitude and phase, N m.
    gradient : (n, p) complex
        Their derivatives with respect to the parameters.
    error : (n,)
        Error of the lines, N m: sampling and integration, or the scatter of a motion that does not repeat.
    power : float
        Mean square of the whole torque about its mean, (N m)^2; of a repeating motion corrected for the first-order
        error that jumps within a sample cause.
    torque : (N,)
        Unfiltered torque over the same stretch, N m.
    sample_rate_hz : float
    """

    orders: FloatArray
    values: ComplexArray
    gradient: ComplexArray
    error: FloatArray
    power: float
    torque: FloatArray
    sample_rate_hz: float


def lines_of_repeating(period: PeriodMap, orbit: Orbit) -> Lines:
    """Return the lines of a repeating motion over one repetition, after the filter has settled.

    Raises
    ------
    FitError
        The mechanism diverged.
    """
    m = orbit.periods
    skipped = m * math.ceil(filter_settling_s(period) / (m * period.duration_s))
    orders = _orders(period, m)
    coarse = period.stretch(State(orbit.x, orbit.by_parameter), skipped, m)
    # Derivatives are taken at the coarse resolution only: doubling them would cost p + 1 times as much.
    found = _lines(period, coarse, 1, m, orders)
    values, plain, finer = found[:, 0], State(orbit.x, np.zeros((orbit.x.size, 0))), 1
    rough = power = periodic_power(coarse.torque)
    for _ in range(MOTION.most_doublings):
        finer *= 2
        fine = period.stretch(plain, skipped, m, slopes=False, finer=finer)
        before, values = values, _lines(period, fine, 1, m, orders)[:, 0]
        error = _smooth(np.abs(values - before))
        rough, power = power, periodic_power(fine.torque)
        is_fine = error.max(initial=0.0) <= MOTION.promised * np.abs(values).max(initial=0.0)
        if is_fine and abs(power - rough) <= MOTION.power * power:
            break
    kept = _is_kept(values, orders, period.steps * m)
    # Richardson extrapolation: the error that jumps within a sample cause is halved with the sample.
    power = 2.0 * power - rough
    return Lines(
        orders[kept].astype(np.float64),
        values[kept],
        found[kept, 1:],
        error[kept],
        power,
        fine.torque,
        finer * period.sample_rate_hz,
    )


def lines_with_scatter(
    period: PeriodMap, start: State | None, skipped: int, periods: int
) -> tuple[Lines, FloatArray, float]:
    """Return the lines of a motion that does not repeat, the torque left without them, and the error of the RMS.

    The standard error is that of the whole torque's RMS, N m.

    Raises
    ------
    FitError
        The mechanism diverged.
    """
    skipped += math.ceil(filter_settling_s(period) / period.duration_s)
    # A whole number of periods in each piece, so that the lines are bins of each piece's spectrum.
    periods = MOTION.pieces * math.ceil(periods / MOTION.pieces)
    stretch, orders = period.stretch(start, skipped, periods), _orders(period, 1)
    found = _lines(period, stretch, periods, 1, orders)
    pieces = np.split(stretch.below[:, :1], MOTION.pieces)
    each = np.array([_filtered_lines(period, piece, periods // MOTION.pieces, 1, orders)[:, 0] for piece in pieces])
    scatter = np.sqrt(np.mean(np.abs(each - each.mean(axis=0)) ** 2, axis=0) / (MOTION.pieces - 1))
    power = np.array([np.var(piece) for piece in np.split(stretch.torque, MOTION.pieces)])
    rms = float(np.std(stretch.torque))
    error = float(np.std(power, ddof=1)) / math.sqrt(MOTION.pieces) / (2.0 * rms) if rms > 0.0 else 0.0
    lines = Lines(
        orders.astype(np.float64),
        found[:, 0],
        found[:, 1:],
        _smooth(scatter),
        rms**2,
        stretch.torque,
        period.sample_rate_hz,
    )
    return lines, _residual(stretch.torque, periods), error


def filter_settling_s(period: PeriodMap) -> float:
    """Return the time after which the initial state of the filters has decayed."""
    return MOTION.decayed * filter_decay_s(period.mechanism)


def filter_decay_s(mechanism: Mechanism) -> float:
    """Return the time in which the slowest transient of the torque's filters falls to 1/e, 0 without filters.

    Raises
    ------
    FitError
        One does not decay, for example that of a housing without damping.
    """
    plant = mechanism.plant
    if not plant.filter.states:
        return 0.0
    A = np.array(_filter_matrix(plant)(*mechanism.kernel_values().tolist()), dtype=np.float64)
    roots = np.linalg.eigvals(A)
    slowest = float(-roots.real.max())
    if not slowest > MOTION.endless * float(np.abs(roots).max()):
        raise FitError(
            "a filter of the test stand never settles, so that there are no lines behind it: give housing and "
            "transducer a damping above 0, or take the mechanism without its test stand"
        )
    return 1.0 / slowest


@lru_cache(maxsize=32)
def _filter_matrix(plant: Plant) -> Callable[..., list[list[float]]]:
    """Return the filters' matrix A as a function of the kernel's parameters."""
    function: Callable[..., list[list[float]]] = sp.lambdify(plant.parameters, plant.filter.A.tolist(), modules="math")
    return function


def _orders(period: PeriodMap, times: int) -> IntArray:
    """Return the lines up to the mode's highest frequency, as multiples of the motion's fundamental."""
    highest = int(times * period.duration_s * period.mode.highest_hz)
    return np.arange(1, min(highest, period.samples * times // 2 - 1) + 1)


def _lines(period: PeriodMap, stretch: Stretch, rounds: int, times: int, orders: IntArray) -> ComplexArray:
    return _filtered_lines(period, stretch.below, rounds, times, orders)


def _filtered_lines(period: PeriodMap, y: FloatArray, rounds: int, times: int, orders: IntArray) -> ComplexArray:
    """Return the lines (n, k) of filtered samples (N, k) over a number of rounds, the filter's response divided out."""
    through = through_filter(period, orders / (times * period.duration_s))
    found = 2.0 / len(y) * np.fft.rfft(y, axis=0)[orders * rounds]
    return np.asarray(found / through[:, None], dtype=np.complex128)


def through_filter(period: PeriodMap, frequency_hz: FloatArray) -> ComplexArray:
    """Return the response of the lines' filter at frequencies of either sign, (n,)."""
    return anti_alias_response(LINE_ORDER, period.mechanism.value(CUT_OFF), frequency_hz)


def _residual(y: FloatArray, rounds: int) -> FloatArray:
    """Return the part of a torque that lies on no line of the rounds, (N,)."""
    spectrum = np.fft.rfft(y)
    # Over whole rounds each line is exactly one bin; the mean is the bin of order 0.
    spectrum[::rounds] = 0.0
    return np.fft.irfft(spectrum, n=y.size)


def _smooth(differences: FloatArray) -> FloatArray:
    """Return errors, (n,), from differences of single lines: their RMS over neighbours, with a margin."""
    if not differences.size:
        return differences
    width = 2 * MOTION.neighbours + 1
    squares = np.convolve(
        np.pad(differences**2, MOTION.neighbours, mode="edge"), np.full(width, 1.0 / width), mode="valid"
    )
    return np.asarray(MOTION.safety * np.sqrt(squares), dtype=np.float64)


def _is_kept(values: ComplexArray, orders: IntArray, steps: int) -> BoolArray:
    """Return which lines are kept, (n,): all multiples of half the step rate, and others that are not small."""
    loud = np.abs(values) > MOTION.kept_line * np.abs(values).max(initial=0.0)
    return np.asarray((2 * orders % steps == 0) | loud, dtype=np.bool_)
