"""Times that a record shows by itself: when it begins to move, whether rows were lost, how fast a sweep was."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.command.edges import steps_travelled
from mechid.identification.contradiction.record_sight import COARSE
from mechid.identification.output_error.declaration import Reading
from mechid.identification.output_error.target import Target
from mechid.identification.search.first_moments import motion_begins
from mechid.identification.search.settings import SEARCH

REST_S, SMOOTHED_S, MOVES = 1e-3, 1e-3, 10.0
"""How much of a record is its rest, over what it is smoothed, and from how many standard deviations on it moves."""
SWINGS, SWING = 0.1, (0.01, 0.99)
"""And from what share of its swing, between these quantiles: a few samples that stand for missing ones are none."""
PERIOD_STEPS = 4.0
"""Full steps in one electrical turn, after which the motion at a steady rate repeats itself."""
ALIKE, FEWEST, STEADY, JUMP = 0.97, 2, 0.3, 2.0
"""How alike periods of one motion are (correlation), how many of them stand on either side of a jump, which share of
the least jump they may differ within a side, and how many samples a jump is at least."""
LEAST_JUMP, OF_A_STEP = 0.02, 0.1
"""Of a full step: a smaller jump is none; and one this near to whole steps may be steps that the motor lost."""
ORDERS = (0.5, 1.0)
"""Lines of a sweep, in times the step rate: where the detents are."""
LAG, LEAD, REACH = 3.0, 1.0, 0.05
"""Turns of a line by which a mechanism may lag in a sweep, or lead (the benches' lines lagged by 0.8 to 2.4), and how
far off, relatively, a rate is looked for."""
CLEAR, NEARER = 100.0, 4.0
"""Times the median of its surroundings, and the most of what a right sweep may show, above which a line is clear."""
KEPT_S = 0.1
"""Rest that a record keeps where it is to be cut, s; a choice, not measured."""
MOST_STEPS, A_STEP = 20_000, 8
"""Of a sweep that are looked at, and points of each."""
MOST_SAMPLES = 2_000_000
"""Of a record that are looked at from its beginning: it need not fit in memory."""


@dataclass(frozen=True)
class LateStart:
    """A record that rests while its motor is commanded two full steps; they move any that is not held.

    Attributes
    ----------
    record : str
    moves_s : float
        Record time at which it leaves its rest, s.
    steps : int
        Full steps that are commanded by then.
    late_s, step_s : float
        By how much the command seems to begin too early, and the time of a full step, s.
    """

    record: str
    moves_s: float
    steps: int
    late_s: float
    step_s: float

    @property
    def reading(self) -> Reading:
        """The record with a command that begins later."""
        return Reading(time_offset_s=(self.late_s, self.late_s - self.step_s, self.late_s + self.step_s))

    def line(self, *, helps: bool) -> str:
        """Return what was seen, with the remedy where it helps."""
        value, least, most = self.late_s, self.late_s - self.step_s, self.late_s + self.step_s
        remedy = (
            f": is the recorder's trigger some {value:.2g} s early? write "
            f"time_offset_s = {{ value = {value:.3g}, min = {least:.3g}, max = {most:.3g} }}"
            if helps
            else "; a later command does not make it fit: look at how its numbers and times were read (mechid look)"
        )
        return (
            f"record {self.record}: it rests until {self.moves_s:.4g} s, although its command has made {self.steps} "
            f"full steps by then{remedy}"
        )


def late_start(target: Target) -> LateStart | None:
    """Return that a record begins to move late; None where it does not.

    One that moves too early is not reported: a rotor that begins off its detents' rest moves before any step.
    """
    if target.command.microsteps > COARSE or not target.command.rate.rates[0]:
        return None
    base, step_s = target.base, 1.0 / abs(target.command.rate.rates[0])
    moves = _first_motion(target)
    commanded = moves - target.time_offset.value if moves is not None else 0.0
    if moves is None or commanded < 2.0 * step_s or base.start_s > target.time_offset.value:
        return None
    return LateStart(target.name, moves, int(commanded / step_s), commanded - step_s, step_s)


def rests_too_long(target: Target) -> str:
    """Say that a record rests for longer than the search for a start looks ahead."""
    base, moves = target.base, motion_begins(target)
    rest_s = (moves - target.burn_in) / base.sample_rate_hz
    if rest_s <= SEARCH.longest_rest_s or moves >= target.samples:
        return ""
    first_s, last_s = base.start_s + moves / base.sample_rate_hz, base.start_s + base.duration_s
    return (
        f"record {target.name}: it rests for {rest_s:.3g} s; starts of the search are judged within "
        f"{SEARCH.longest_rest_s:g} s of its beginning and cannot differ there; "
        f"write window_s = [{first_s - KEPT_S:.6g}, {last_s:.6g}] for it, "
        "which moves no time"
    )


def _first_motion(target: Target) -> float | None:
    """Return the record time at which a torque leaves its rest; None where it begins in motion, or never moves."""
    rate = target.base.sample_rate_hz
    width = max(round(SMOOTHED_S * rate), 1)
    if width >= target.samples:  # so short a record shows no rest
        return None
    y = target.leading.measured[: round(min(target.base.duration_s, 100.0 * REST_S + 20.0) * rate)]
    smooth = np.convolve(y, np.full(width, 1.0 / width), "valid")
    rest = float(np.mean(y[: max(round(REST_S * rate), 1)]))
    least = max(MOVES * target.leading.sigma / np.sqrt(width), SWINGS * 0.5 * float(np.ptp(np.quantile(smooth, SWING))))
    moving = np.flatnonzero(np.abs(smooth - rest) > least)
    return target.base.start_s + float(moving[0]) / rate if moving.size and moving[0] > 0 else None


def lost_rows(target: Target) -> str:
    """Say that a steady motion goes on at another phase from some period on: rows are lost, or a clock has jumped.

    The two periods beside the jump show it as well: a motion that settles comes to its phase bit by bit.
    """
    rate = abs(target.command.rate.rates[0])
    if not rate or target.begins_in_motion:
        return ""
    fs, period_s = target.base.sample_rate_hz, PERIOD_STEPS / rate
    shifts, alike = _shifts(target.leading.measured[:MOST_SAMPLES], period_s * fs)
    for k in range(FEWEST + 1, shifts.size - FEWEST):  # the first period has the beginning of the motion
        sides = shifts[1:k], shifts[k + 1 :]
        steady = all(float(np.ptp(side)) <= max(STEADY * LEAST_JUMP * fs / rate, 1.0) for side in sides)
        jump = float(np.median(sides[0]) - np.median(sides[1]))
        sudden = min(abs(jump), abs(float(shifts[k - 1] - shifts[k + 1])))
        steps = jump / fs * rate
        if not steady or min(*alike[1:k], *alike[k + 1 :]) < ALIKE or sudden < JUMP:
            continue
        if abs(steps) >= LEAST_JUMP and abs(steps - round(steps)) >= OF_A_STEP * min(abs(round(steps)), 1):
            return _jump_line(target, target.base.start_s + k * period_s, jump)
    return ""


def _jump_line(target: Target, at_s: float, samples: float) -> str:
    rows, way = ("lost", "ahead") if samples > 0.0 else ("too many, or lost elsewhere", "behind")
    return (
        f"record {target.name}: its motion goes on {abs(samples) / target.base.sample_rate_hz:.2g} s {way} from about "
        f"{at_s:.2g} s on: some {abs(samples):.0f} rows are {rows}, or its clock jumps there; use one side of it "
        "(window_s), or a file with time stamps"
    )


def _shifts(y: FloatArray, period: float) -> tuple[FloatArray, FloatArray]:
    """Return by how many samples each period lies behind the last one, (k,), and how alike both are then, (k,)."""
    if not A_STEP <= period < y.size:
        return np.zeros(0), np.zeros(0)
    count, size = int(y.size / period), int(period)
    if count < 2 * FEWEST + 2 or size < A_STEP:
        return np.zeros(0), np.zeros(0)
    places = np.arange(size) + period * np.arange(count)[:, np.newaxis]
    blocks = np.interp(places, np.arange(y.size), y)
    blocks -= blocks.mean(axis=1, keepdims=True)
    spectra = np.fft.rfft(blocks)
    product = np.fft.irfft(spectra * np.conj(spectra[-1]), size)
    at = np.argmax(product, axis=1)
    norms = np.linalg.norm(blocks, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        alike = product[np.arange(count), at] / (norms * norms[-1])
    return np.where(at > size // 2, at - size, at).astype(np.float64), np.nan_to_num(alike)


def swept_rate(target: Target) -> str:
    """Say that the lines of a sweep run at another rate than declared; a mechanism makes them lag by a turn or two."""
    rates = np.array(target.command.rate.rates)
    if np.any(rates < 0.0) and np.any(rates > 0.0):
        return ""
    steps, y = _over_steps(target)
    clear = [found for order in ORDERS if (found := _clear_line(steps, y, order))]
    if not clear:
        return ""
    ratio = max(clear)[1]
    off, clock = 100.0 * (ratio - 1.0), 100.0 * (1.0 / ratio - 1.0)
    return (
        f"record {target.name}: its lines are those of some {ratio:.3g} times the rates declared: the rates are about "
        f"{off:+.1g} % off, or the record's sample rate (its clock) {clock:+.1g} %"
    )


def _over_steps(target: Target) -> tuple[float, FloatArray]:
    """Return how many full steps are looked at, and the torque at equal distances of travel, each stretch as large."""
    base = target.base
    y = target.leading.measured[:MOST_SAMPLES]
    time = base.start_s + np.arange(y.size) / base.sample_rate_hz - target.time_offset.value
    travelled = np.abs(steps_travelled(target.command.rate, time))
    last = min(float(travelled[-1]), MOST_STEPS)
    if last < PERIOD_STEPS:
        return 0.0, np.zeros(0)
    width = max(int(base.sample_rate_hz / (4.0 * A_STEP * max(map(abs, target.command.rate.rates)))), 1)
    smooth = np.convolve(y - np.mean(y), np.full(width, 1.0 / width), "same")
    own = np.interp(np.arange(0.0, last, 1.0 / A_STEP), travelled, smooth)
    around = np.full(max(int(PERIOD_STEPS * PERIOD_STEPS * A_STEP), 1), PERIOD_STEPS**-2.0 / A_STEP)
    level = np.sqrt(np.convolve(own**2, around, "same")) if own.size >= around.size else np.zeros(own.size)
    return last, np.divide(own, level, out=np.zeros_like(own), where=level > 0.0)


def _clear_line(steps: float, y: FloatArray, order: float) -> tuple[float, float] | None:
    """Return how clear a line at another rate is, and that rate over the declared one; None where it is as declared."""
    turns = order * steps
    if turns < (LAG + LEAD) / REACH:
        return None
    power = np.abs(np.fft.rfft(y, 4 * y.size)) ** 2
    ratio = np.fft.rfftfreq(4 * y.size, 1.0 / A_STEP) / order
    near = np.abs(ratio - 1.0) < REACH
    right = near & (ratio > 1.0 - LAG / turns) & (ratio < 1.0 + LEAD / turns)
    at = int(np.argmax(np.where(near, power, 0.0)))
    clearness = float(power[at] / np.median(power[near]))
    if right[at] or clearness < CLEAR or power[at] < NEARER * float(power[right].max()):
        return None
    return clearness, float(ratio[at]) + 1.0 / turns
