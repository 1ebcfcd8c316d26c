"""Step instants and rate profiles that excite a mode less: paired and staggered steps, input shaping, S-curves.

A mode of frequency f and damping ratio zeta, excited by a step, has decayed after half a damped period
T/2 = 1/(2 f sqrt(1 - zeta^2)) to K = exp(-pi zeta/sqrt(1 - zeta^2)) of its amplitude, with the opposite sign. Two
commands half a period apart with the weights 1/(1 + K) and K/(1 + K) therefore leave no swing [SingerSeering1990]_; two
equal steps leave 1 - K of the swing of one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike

from mechid.arrays import FloatArray
from mechid.command.entry import format_found, is_number, is_whole
from mechid.command.rate import RateProfile
from mechid.errors import UsageError

MOST_STEPS = 1_000_000
"""Largest number of steps that are listed."""
SAME = 1e-12
"""Relative difference of instants, and of rates, that counts as rounding."""
CURVE_POINTS = 16
"""Straight segments of a rate profile for each phase of constant jerk."""
Crossing = tuple[float, float, float]
"""Rate in full steps/s, acceleration there in full steps/s^2, and half-width of the band in full steps/s."""
Phase = tuple[float, float, float]
"""Duration in s, first and last acceleration in full steps/s^2 of a phase of constant jerk."""


def paired_steps(pairs: int, rate: float, frequency_hz: float, damping: float = 0.0) -> FloatArray:
    """Return the instants of pairs of steps, half a period of a mode apart, so that the second cancels the first.

    After a pair the mode swings with 1 - exp(-pi zeta/sqrt(1 - zeta^2)) of the amplitude that its second step alone
    would leave: 0 without damping. In half stepping a pair is a full step split in two.

    Parameters
    ----------
    pairs : int
    rate : float
        Pairs per second; the first begins at 1/`rate`.
    frequency_hz : float
        Undamped natural frequency f of the mode.
    damping : float
        Damping ratio zeta, from 0 to below 1.

    Returns
    -------
    (2 pairs,) float
        Instants in s, for ``step_times``.

    Raises
    ------
    UsageError
        A value is impossible, or half a period is not shorter than the time between pairs.

    Examples
    --------
    >>> paired_steps(2, 10.0, 25.0)
    array([0.1 , 0.12, 0.2 , 0.22])
    """
    return staggered_steps(2 * pairs, 2.0 * _positive("rate", rate), (0.0, _late_s(rate, frequency_hz, damping)))


def staggered_steps(steps: int, rate: float, delays_s: Sequence[float]) -> FloatArray:
    """Return the instants of steps at a mean rate, delayed by a repeated pattern.

    A pattern of m delays d_i multiplies the line at a frequency f that a single pulse of each step would leave by
    abs(sum_i exp(-2 pi j f (i T + d_i)))/m, T = 1/`rate`: delays of (0, d) suppress the lines where f (T + d) is an odd
    multiple of 1/2, and create lines at multiples of half the rate.

    Parameters
    ----------
    steps : int
    rate : float
        Mean rate in steps/s; without delay the first step is at 1/`rate` times the pattern's length.
    delays_s : sequence of float
        Delay of each step of the pattern in s; negative ones are early.

    Returns
    -------
    (steps,) float
        Instants in s, for ``step_times``.

    Raises
    ------
    UsageError
        A value is impossible, or a step would overtake the one before.

    Examples
    --------
    >>> staggered_steps(4, 10.0, (0.0, 0.02))
    array([0.2 , 0.32, 0.4 , 0.52])
    """
    if not is_whole(steps, 1, MOST_STEPS):
        raise UsageError(f"steps: found {format_found(steps)}; write a whole number from 1 to {MOST_STEPS}")
    interval_s, delays = 1.0 / _positive("rate", rate), np.asarray(delays_s, dtype=np.float64)
    if delays.ndim != 1 or not delays.size or not np.all(np.isfinite(delays)):
        raise UsageError(f"delays_s: found {format_found(delays_s)}; write one finite delay in s or more")
    number = np.arange(steps)
    times = (number + delays.size) * interval_s + delays[number % delays.size]
    early = np.flatnonzero(np.diff(times, prepend=0.0) <= 0.0)
    if early.size:
        raise UsageError(
            f"delays_s: step {early[0]} at {times[early[0]]:.6g} s is not after the one before; "
            f"write delays that differ by less than {interval_s:.6g} s"
        )
    return times


def _late_s(rate: float, frequency_hz: float, damping: float) -> float:
    """Return the delay of every second step that turns a uniform rate into pairs."""
    half_s, interval_s = _half_period_s(frequency_hz, damping), 1.0 / rate
    if half_s >= interval_s:
        raise UsageError(
            f"rate: found {rate:.6g} pairs/s; half a period of the mode takes {half_s:.6g} s, "
            f"write less than {1.0 / half_s:.6g}"
        )
    return half_s - 0.5 * interval_s


def shaped_rate(
    rate: float | ArrayLike, frequency_hz: float, damping: float = 0.0, *, robust: bool = False
) -> FloatArray:
    """Return a rate profile that starts, stops and changes its rate without leaving a mode swinging.

    The profile is convolved with two impulses half a damped period apart (zero vibration), or with three (zero
    vibration and derivative, `robust`), whose residual swing grows with the square of an error of the frequency
    [SingerSeering1990]_. It lasts half a period longer, or a whole one.

    Parameters
    ----------
    rate : float or (B, 2) array
        Rate in full steps/s, taken up at t = 0 from rest; or breakpoints of command time in s and full steps/s. Before
        the first breakpoint its rate holds; write [[0, 0], [0, 40], [2, 40], [2, 0]] to start and stop.
    frequency_hz : float
        Undamped natural frequency of the mode.
    damping : float
        Its damping ratio, from 0 to below 1.
    robust : bool
        Whether to use three impulses.

    Returns
    -------
    (B', 2) float
        Breakpoints, for ``rate`` of `make_command` or ``rate_profile``.

    Raises
    ------
    UsageError
        A value is impossible.

    Examples
    --------
    >>> shaped_rate(40.0, 25.0).tolist()
    [[0.0, 0.0], [0.0, 20.0], [0.02, 20.0], [0.02, 40.0]]
    """
    points = np.asarray(rate, dtype=np.float64)
    if points.ndim == 0:
        points = np.array([[0.0, 0.0], [0.0, float(points)]])
    if points.ndim != 2 or points.shape[1] != 2:
        raise UsageError(f"rate: found an array of shape {points.shape}; write a rate, or [[time in s, full steps/s]]")
    profile = RateProfile.through((float(t), float(r)) for t, r in points)
    half_s, ratio = _half_period_s(frequency_hz, damping), _decay(damping)
    weights = np.array([1.0, 2.0 * ratio, ratio**2] if robust else [1.0, ratio])
    weights /= weights.sum()
    delays: FloatArray = half_s * np.arange(weights.size, dtype=np.float64)
    return _weighted_sum(np.array(profile.times_s), np.array(profile.rates), delays, weights)


def _weighted_sum(times: FloatArray, rates: FloatArray, delays: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the breakpoints of the sum of delayed and weighted copies of a profile, (B', 2)."""
    lapse, change = np.diff(times), np.diff(rates)
    slope = np.divide(change, lapse, out=np.zeros_like(lapse), where=lapse > 0.0)
    jump = np.where(lapse > 0.0, 0.0, change)
    # A jump is between two points of one time: it is kept at the first of them.
    jumps, bends = np.append(jump, 0.0), np.diff(slope, prepend=0.0, append=0.0)
    at = (times + delays[:, None]).ravel()
    order = np.argsort(at, kind="stable")
    at = at[order]
    # Copies whose points fall on one instant but for rounding are merged.
    first = np.append(True, np.diff(at) > SAME * (at[-1] - at[0]))
    group = np.cumsum(first) - 1
    jumps, bends = (np.bincount(group, (weights[:, None] * values).ravel()[order]) for values in (jumps, bends))
    at = at[first]
    grown = np.cumsum(np.append(0.0, np.cumsum(bends)[:-1] * np.diff(at)))
    after = rates[0] + grown + np.cumsum(jumps)
    after[-1] = rates[-1]
    before = after - jumps
    found: FloatArray = np.stack((np.repeat(at, 2), np.stack((before, after), axis=1).ravel()), axis=1)
    is_jump = np.abs(jumps) > SAME * np.abs(rates).max(initial=0.0)
    return np.asarray(found[np.stack((is_jump, np.ones_like(is_jump)), axis=1).ravel()])


def shaped_ramp(
    start_rate: float,
    end_rate: float,
    acceleration: float,
    jerk: float,
    crossings: Sequence[Crossing] = (),
) -> FloatArray:
    """Return a ramp of the rate with limited jerk, which passes resonant rates at accelerations of its own.

    The acceleration rises from 0 with the jerk, holds, and falls to 0. Within the band of each crossing it has the
    value of that crossing, so that the ramp passes a resonance fast and starts gently elsewhere, or the reverse.

    Parameters
    ----------
    start_rate, end_rate : float
        Full steps/s; the start rate holds before t = 0, and the end rate after the ramp.
    acceleration : float
        Magnitude outside the crossings in full steps/s^2.
    jerk : float
        Magnitude in full steps/s^3.
    crossings : sequence of (float, float, float)
        Rate, magnitude of the acceleration there, and half-width of the band around it, in full steps/s, full
        steps/s^2, full steps/s; in any order.

    Returns
    -------
    (B, 2) float
        Breakpoints, for ``rate`` of `make_command` or ``rate_profile``: `CURVE_POINTS` straight segments for each phase
        of constant jerk, one for each of constant acceleration.

    Raises
    ------
    UsageError
        A value is impossible, or the rates leave no room to change the acceleration with this jerk.

    Examples
    --------
    >>> ramp = shaped_ramp(0.0, 60.0, 20.0, 400.0, [(46.0, 80.0, 2.0)])
    >>> ramp[-1].round(3).tolist()
    [2.45, 60.0]
    """
    for key, value in (("start_rate", start_rate), ("end_rate", end_rate)):
        if not is_number(value):
            raise UsageError(f"{key}: found {format_found(value)}; write full steps/s")
    slow, jolt = _positive("acceleration", acceleration), _positive("jerk", jerk)
    way = 1.0 if end_rate >= start_rate else -1.0
    first, last = way * start_rate, way * end_rate
    bands = sorted(_band(at, crossing, way, (first, last)) for at, crossing in enumerate(crossings))
    phases = list(_phases(first, last, slow, jolt, bands))
    times, rates, now, here = [0.0], [first], 0.0, first
    for duration, begin, end in phases:
        count = 1 if begin == end else CURVE_POINTS
        lapse = duration * np.arange(1, count + 1) / count
        times += (now + lapse).tolist()
        rates += (here + begin * lapse + (end - begin) * lapse**2 / (2.0 * duration)).tolist()
        now, here = times[-1], rates[-1]
    # The sum of the phases is rounded; the ramp ends on the rate that was asked for.
    rates[-1] = last
    return np.stack((np.array(times), way * np.array(rates)), axis=1)


def _band(at: int, crossing: Sequence[float], way: float, ends: tuple[float, float]) -> tuple[float, float, float]:
    """Return lower and upper rate of a crossing in the direction of the ramp, and the acceleration there."""
    if len(crossing) != 3 or not all(map(is_number, crossing)) or min(crossing[1:]) <= 0.0:
        remedy = "write (rate, acceleration, half-width), the last two above 0"
        raise UsageError(f"crossings[{at}]: found {format_found(crossing)}; {remedy}")
    rate, acceleration, half = way * crossing[0], float(crossing[1]), float(crossing[2])
    if not ends[0] < rate - half < rate + half < ends[1]:
        remedy = "write a band between the rates of the ramp"
        raise UsageError(f"crossings[{at}]: found {format_found(crossing)}; {remedy}")
    return rate - half, rate + half, acceleration


def _phases(first: float, last: float, slow: float, jerk: float, bands: Sequence[Crossing]) -> Iterator[Phase]:
    """Yield the phases of a rising ramp; each band has its acceleration from its lower to its upper rate."""
    here, now = first, 0.0
    for low, high, fast in (*bands, (last, last, 0.0)):
        gain, mean = low - here, 0.5 * (now**2 + fast**2)
        need = 0.5 * abs(fast**2 - now**2)
        if need > jerk * gain * (1.0 + SAME):
            least = f"write at least {need / gain:.6g}" if gain > 0.0 else "the bands overlap"
            raise UsageError(
                f"jerk: found {jerk:.6g}; from {here:.6g} to {low:.6g} full steps/s there is no room to change the "
                f"acceleration from {now:.6g} to {fast:.6g}; {least}"
            )
        # A change from a to b gains (b^2 - a^2)/(2 jerk): the rates leave room for levels between these two.
        lowest, highest = math.sqrt(max(mean - jerk * gain, 0.0)), math.sqrt(mean + jerk * gain)
        level = min(max(slow, lowest), highest)
        spent = 0.5 * (abs(level**2 - now**2) + abs(fast**2 - level**2)) / jerk
        yield from _change(now, level, jerk)
        if gain - spent > SAME * max(abs(last - first), 1e-300):
            yield (gain - spent) / level, level, level
        yield from _change(level, fast, jerk)
        if high > low:
            yield (high - low) / fast, fast, fast
        here, now = high, fast


def _change(begin: float, end: float, jerk: float) -> Iterator[Phase]:
    """Yield the phase of a change of the acceleration, if there is one."""
    if begin != end:
        yield abs(end - begin) / jerk, begin, end


def _half_period_s(frequency_hz: float, damping: float) -> float:
    """Return half a damped period in s."""
    return 0.5 / (_positive("frequency_hz", frequency_hz) * math.sqrt(1.0 - _ratio(damping) ** 2))


def _decay(damping: float) -> float:
    """Return the decay of a mode over half a damped period."""
    return math.exp(-math.pi * damping / math.sqrt(1.0 - _ratio(damping) ** 2))


def _ratio(damping: float) -> float:
    if not is_number(damping) or not 0.0 <= damping < 1.0:
        raise UsageError(f"damping: found {format_found(damping)}; write a damping ratio from 0 to below 1")
    return float(damping)


def _positive(key: str, value: float) -> float:
    if not is_number(value) or value <= 0.0:
        raise UsageError(f"{key}: found {format_found(value)}; write a number above 0")
    return float(value)
