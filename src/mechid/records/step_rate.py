"""Estimation of a record's step rate from its spectrum, without knowledge of the command.

The motion of a motor at a constant step rate is periodic: all its lines are multiples of the repetition frequency. This
is the step rate, or half or a quarter of it if the coils differ or the detent has a period of two steps. Full steps act
as impacts and fill the spectrum with multiples of the step rate; microsteps cause a few low lines and one at the rate
of the microsteps. A rate that changes linearly causes straight ridges in the spectrogram.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.command import RateProfile
from mechid.records.settings import STEP_RATE
from mechid.signal.lines import Line, Prominence
from mechid.signal.mains import mains_lines
from mechid.signal.moments import mean
from mechid.signal.remainder import Remainder
from mechid.signal.series import Series
from mechid.signal.spectrogram import spectrogram
from mechid.signal.trend import Line as Constant

FULL_ORDERS, LEAST_FULL_ORDERS = range(5, 13), 6
"""Orders that are examined for full steps, and how many of them must be lines; microsteps have hardly any."""
MICROSTEPS = (2, 4, 8, 16, 32, 64, 128, 256)


@dataclass(frozen=True, kw_only=True)
class SuggestedRate:
    """Estimated command of a record.

    Attributes
    ----------
    profile : RateProfile
        Full steps/s over the time since the first sample: a constant rate, or a linear sweep.
    sigma : float
        Standard error of a constant rate in full steps/s; NaN for a sweep.
    repetition_hz : float
        Frequency of which all lines are multiples; NaN for a sweep.
    stepping : str
        ``"full"``, ``"micro"``, or empty if it cannot be determined.
    microsteps : int or None
        Microsteps per full step, if their line is detected.
    others : tuple of float
        Other rates that explain the same lines, in full steps/s.
    share : float
        Share of the lines that are explained; for a sweep, share of the windows with a significant ridge.
    """

    profile: RateProfile
    sigma: float
    repetition_hz: float
    stepping: str
    microsteps: int | None
    others: tuple[float, ...]
    share: float

    @property
    def rate(self) -> float:
        """Largest rate in full steps/s."""
        return max(self.profile.rates)

    @property
    def is_constant(self) -> bool:
        """Whether the rate is constant."""
        return len(self.profile.rates) == 1


@dataclass(frozen=True, kw_only=True)
class RateReading:
    """Constant rate measured in a record with a declared rate: rate in full steps/s, and period in full steps."""

    rate: float
    sigma: float
    repeats: float


def read_declared_rate(suggested: SuggestedRate, declared: float) -> RateReading | None:
    """Return the measured value of a declared constant rate, or None if the lines do not match it.

    Parameters
    ----------
    suggested : SuggestedRate
        Estimate of a constant rate.
    declared : float
        Declared rate in full steps/s, above 0.
    """
    repeats = declared / suggested.repetition_hz
    nearest = min(STEP_RATE.readable, key=lambda whole: abs(repeats / whole - 1.0))
    if abs(repeats / nearest - 1.0) > STEP_RATE.off:
        return None
    rate = nearest * suggested.repetition_hz
    sigma = rate * suggested.sigma / suggested.profile.rates[0]
    return RateReading(rate=rate, sigma=sigma, repeats=nearest)


def suggest_rate_without_hum(data: Series, found: Prominence, lines: Sequence[Line]) -> SuggestedRate | None:
    """Estimate the step rate from the lines without mains hum.

    If this fails, the mains lines are included, and the result is accepted if it has the lines of full steps.

    Parameters
    ----------
    data : Series of N samples
        In any unit.
    found : Prominence
        Spectrum of the samples.
    lines : sequence of Line
        Lines of the spectrum.
    """
    hum = {round(one.line.frequency_hz / found.bin_hz) for one in mains_lines(found)}
    y = Remainder(data, Constant(mean(data)))
    own = suggest_rate(y, found, [one for one in lines if round(one.frequency_hz / found.bin_hz) not in hum])
    if own or not hum:
        return own
    with_hum = suggest_rate(y, found, lines)
    return with_hum if with_hum and with_hum.stepping == "full" else None


def suggest_rate(y: Series, found: Prominence, lines: Sequence[Line]) -> SuggestedRate | None:
    """Estimate the step rate of a record; return None if it cannot be determined.

    Parameters
    ----------
    y : Series of N samples
        With zero mean.
    found : Prominence
        Spectrum of the samples.
    lines : sequence of Line
        Lines of the spectrum.
    """
    return _find_constant_rate(found, lines) or _find_sweep(y, found.sample_rate_hz)


def _find_constant_rate(found: Prominence, lines: Sequence[Line]) -> SuggestedRate | None:
    repetition = repetition_frequency(lines, found.bin_hz)
    if repetition is None:
        return None
    frequency, sigma, share = repetition
    amplitude = _multiple_amplitudes(found, frequency, max(line.frequency_hz for line in lines))
    repeats = _repetition_steps(amplitude)
    strong = repeats if repeats > 1 else _multiple_of_strongest(lines, frequency)
    stepping, microsteps = _stepping_mode(lines, strong * frequency, found.bin_hz)
    others = () if repeats > 1 else tuple(m * frequency for m in (1, 2, 4) if m != strong)
    return SuggestedRate(
        profile=RateProfile.constant(strong * frequency),
        sigma=math.hypot(strong * sigma, STEP_RATE.settles * found.bin_hz),
        repetition_hz=frequency,
        stepping=stepping,
        microsteps=microsteps,
        others=others,
        share=share,
    )


def repetition_frequency(lines: Sequence[Line], bin_hz: float) -> tuple[float, float, float] | None:
    """Return the largest frequency of which the lines are multiples, its standard error, and the share of such lines.

    Examples
    --------
    >>> lines = [Line(frequency_hz=f, amplitude=1.0, sigma=0.01, ratio=1e4) for f in (46.0, 69.0, 92.0, 138.0)]
    >>> round(repetition_frequency(lines, 0.1)[0], 6)
    23.0
    """
    steady = _find_fundamental(lines, bin_hz, STEP_RATE.steady, least=(STEP_RATE.explained, 0.0))
    return steady or _find_fundamental(
        lines, bin_hz, STEP_RATE.wandering, least=(STEP_RATE.mostly_explained, STEP_RATE.most_power)
    )


def _find_fundamental(
    lines: Sequence[Line], bin_hz: float, near: float, least: tuple[float, float]
) -> tuple[float, float, float] | None:
    """Return the largest frequency of which at least given shares of the lines and of their power are multiples."""
    if len(lines) < STEP_RATE.fewest:
        return None
    frequencies, power = (np.array([getattr(line, key) for line in lines]) for key in ("frequency_hz", "amplitude"))
    weights = np.stack((np.log10([line.ratio for line in lines]), power**2))
    weights /= weights.sum(axis=1, keepdims=True)
    strongest = sorted(lines, key=lambda line: -line.amplitude)[: STEP_RATE.strongest]
    trials = {
        line.frequency_hz / part
        for line in (*strongest, *lines[: STEP_RATE.lowest])
        for part in range(1, STEP_RATE.parts + 1)
    }
    # The largest frequency is accepted first: all its multiples are also multiples of its integer fractions.
    for trial in sorted((t for t in trials if t >= STEP_RATE.least_bins * bin_hz), reverse=True):
        best, sigma = _fit_fundamental(lines, trial, bin_hz, near)
        own = _are_multiples(frequencies, best, bin_hz, near)
        shares = weights[:, own].sum(axis=1)
        chance = 2.0 * np.maximum(STEP_RATE.near_bins * bin_hz, near * frequencies[own]) / best
        # The trial was derived from one of the lines, which is therefore a multiple in any case and does not count.
        unlikely = -float(np.sort(np.log10(np.minimum(chance, 1.0)))[1:].sum())
        if np.count_nonzero(own) >= STEP_RATE.fewest and np.all(shares >= least) and unlikely >= STEP_RATE.by_chance:
            return best, sigma, float(shares[0])
    return None


def _are_multiples(
    frequencies: FloatArray, fundamental: float, bin_hz: float, near: float = STEP_RATE.steady
) -> BoolArray:
    """Return the mask of frequencies that are multiples of a fundamental."""
    off = np.abs(frequencies - np.rint(frequencies / fundamental) * fundamental)
    return np.asarray(
        (off <= np.maximum(STEP_RATE.near_bins * bin_hz, near * frequencies)) & (frequencies > 0.5 * fundamental)
    )


def _fit_fundamental(lines: Sequence[Line], trial: float, bin_hz: float, near: float) -> tuple[float, float]:
    """Fit a trial frequency to the lines that are its multiples; return it and its standard error in Hz."""
    frequencies = np.array([line.frequency_hz for line in lines])
    relative = np.array([line.sigma / line.amplitude for line in lines])
    error = bin_hz * np.hypot(STEP_RATE.frequency_error * np.minimum(relative, 1.0), STEP_RATE.least_error)
    best, sigma = trial, math.inf
    # Low lines are fitted first: the order of a high line is unambiguous only for an accurate fundamental.
    for upto in (4.0, 16.0, math.inf):
        own = _are_multiples(frequencies, best, bin_hz, near) & (frequencies <= upto * trial)
        if own.any():
            multiple = np.rint(frequencies[own] / best)
            information = (multiple / error[own]) ** 2
            each = frequencies[own] / multiple
            best = float(np.sum(information * each) / information.sum())
            scatter = float(np.sum(information * (each - best) ** 2)) / max(each.size - 1, 1)
            sigma = math.sqrt(max(scatter, 1.0) / float(information.sum()))
    return best, sigma


def _multiple_amplitudes(found: Prominence, frequency: float, top_hz: float) -> FloatArray:
    """Return the amplitude at each multiple of a frequency up to a limit, (K,), as the maximum of three bins."""
    numbers = np.rint(np.arange(1, int(top_hz / frequency * 1.001) + 1) * frequency / found.bin_hz).astype(np.int64)
    numbers = numbers[numbers < found.amplitude.size - 1]
    return np.asarray(np.max([found.amplitude[numbers + k] for k in (-1, 0, 1)], axis=0), dtype=np.float64)


def _repetition_steps(amplitude: FloatArray) -> int:
    """Return the period of a motor in steps, doubled each time that the even multiples clearly exceed the odd ones."""
    repeats = 1
    while repeats < STEP_RATE.repeats and amplitude.size >= 2 * STEP_RATE.fewest:
        odd, even = amplitude[0::2], amplitude[1::2]
        if not np.median(even) > STEP_RATE.contrast * np.median(odd[: even.size]):
            break
        repeats, amplitude = 2 * repeats, even
    return repeats


def _multiple_of_strongest(lines: Sequence[Line], frequency: float) -> int:
    """Return the order of the strongest line if it is 2 or 4, otherwise 1."""
    multiple = round(max(lines, key=lambda line: line.amplitude).frequency_hz / frequency)
    return multiple if multiple in (2, 4) else 1


def _stepping_mode(lines: Sequence[Line], rate: float, bin_hz: float) -> tuple[str, int | None]:
    """Return the stepping mode at a rate according to the lines, and the microsteps per full step."""
    frequencies = np.array([line.frequency_hz for line in lines])
    orders = set(np.rint(frequencies[_are_multiples(frequencies, rate, bin_hz)] / rate).astype(int).tolist())
    inside = sum(order in orders for order in FULL_ORDERS)
    if inside >= LEAST_FULL_ORDERS:
        return "full", 1
    seen = [n for n in MICROSTEPS if n in orders and n > max(FULL_ORDERS[0], 4)]
    return ("micro", seen[0]) if seen and inside <= 2 else ("", None)


def _find_sweep(y: Series, sample_rate_hz: float) -> SuggestedRate | None:
    """Return the sweep with the strongest straight ridge in the spectrogram, or None if it is weak or constant."""
    window_s = min(STEP_RATE.window_s, y.size / sample_rate_hz / STEP_RATE.fewest_windows)
    time, frequency, amplitude = spectrogram(y, sample_rate_hz, window_s, STEP_RATE.windows)
    if frequency.size < 2 * STEP_RATE.fewest_windows or time.size < STEP_RATE.fewest_windows:
        return None
    power = amplitude**2 + np.finfo(float).tiny
    # Relative to the median of each window, so that loud windows count no more than others; the clipping bounds the
    # weight of a single strong bin.
    height = np.clip(np.log10(power / np.median(power, axis=0)), 0.0, 6.0)
    height[: STEP_RATE.lowest_bins] = 0.0
    lapse = time / (y.size / sample_rate_hz)
    top = min(STEP_RATE.fastest_hz, float(frequency[-1]) / 2.0)
    ends = _best_ends(height, lapse, float(frequency[1]), top)
    along = _ridge_heights(height, lapse, float(frequency[1]), *(np.array([end]) for end in ends))[0]
    share = float(np.mean(along > STEP_RATE.stands_out))
    if share < STEP_RATE.mostly or abs(ends[1] - ends[0]) < STEP_RATE.swept * max(ends):
        return None
    profile = RateProfile.through([(0.0, ends[0]), (y.size / sample_rate_hz, ends[1])])
    return SuggestedRate(
        profile=profile, sigma=math.nan, repetition_hz=math.nan, stepping="", microsteps=None, others=(), share=share
    )


def _best_ends(height: FloatArray, lapse: FloatArray, bin_hz: float, top: float) -> tuple[float, float]:
    """Return the rates at both ends of the strongest ridge, found by successively refined grid searches."""
    reach, middle = 0.5 * top, (0.5 * top, 0.5 * top)
    for trials in (STEP_RATE.trials, 21, 21, 21):
        first, last = (np.clip(np.linspace(m - reach, m + reach, trials), 0.0, top) for m in middle)
        starts, stops = (grid.ravel() for grid in np.meshgrid(first, last, indexing="ij"))
        score = np.zeros(starts.size)
        # In parts, which bounds the memory for the heights of all trials.
        for part in np.array_split(np.arange(starts.size), max(starts.size // 2000, 1)):
            score[part] = _ridge_heights(height, lapse, bin_hz, starts[part], stops[part]).mean(axis=1)
        best = int(np.argmax(score))
        middle, reach = (float(starts[best]), float(stops[best])), 3.0 * reach / trials
    return middle


def _ridge_heights(
    height: FloatArray, lapse: FloatArray, bin_hz: float, starts: FloatArray, stops: FloatArray
) -> FloatArray:
    """Return the heights along straight ridges, (trials, windows), linearly interpolated between bins."""
    place = (starts[:, None] + (stops - starts)[:, None] * lapse) / bin_hz
    below = np.minimum(place.astype(np.int64), height.shape[0] - 2)
    window = np.arange(lapse.size)
    part = place - below
    return np.asarray((1.0 - part) * height[below, window] + part * height[below + 1, window], dtype=np.float64)
