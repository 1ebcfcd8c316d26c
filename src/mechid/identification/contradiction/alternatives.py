"""What a record may be instead of what it is declared to be, and which of that a model follows.

A record whose torque has the other sign, whose command ran the other way or in other steps, which started from
another position of the drive or at another instant, is of no use as declared, and follows at once as it was. Under a
model that other records have settled, short simulations tell which it is.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.command import Command, MeasuredCommand, RateProfile
from mechid.command.edges import steps_travelled
from mechid.command.stepping import MOST_MICROSTEPS, stepping_of
from mechid.identification.output_error.declaration import Reading, target_as_read
from mechid.identification.output_error.misfit import residual
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.search.gates import followed_samples
from mechid.plant.mechanism import Mechanism
from mechid.signal.trend import fit_line

STEPS = 2.0
"""Full steps of travel that a record's first moments hold; a choice, not measured."""
AFTER_S = 0.06
"""And how long they go on after these, s. The length of the multi-start's window."""
NEAR = 2.0 * math.log(100.0)
"""Sigmas squared; of what is at most a hundred times less likely than the best, the least change is taken; a
choice, not measured."""
LEAST_GAIN, SAME_GAIN = 0.5, 0.02
"""Least factor of a gain that is tried (the largest is its inverse), and how near to 1 it is the declared one; a
choice, not measured."""
LONG = 1_000_000
"""Samples of a record at most over which its gain, or any other reading, is looked for: 100 s at 10 kHz, 16 MB."""
SAME = 1e-9
"""Cycles that differ by no more are whole ones: rounding."""


@dataclass(frozen=True)
class ReadingScore:
    """What a record was taken for, its cost over so many samples (sigmas squared), whether it is followed there."""

    taken: Reading
    cost: float
    follows: bool
    samples: int


def first_moments(target: Target) -> int:
    """Return the samples up to which a record is looked at: two full steps of travel, and 60 ms after them."""
    after = round(AFTER_S * target.base.sample_rate_hz)
    return min(samples_of(target, STEPS) + after, target.samples)


def samples_of(target: Target, steps: float) -> int:
    """Return the samples until the command has travelled so many full steps; all of them where it never has."""
    base = target.base

    def travelled(k: int) -> float:
        time = base.start_s + np.array([k]) / base.sample_rate_hz - target.time_offset.value
        return float(steps_travelled(target.command.rate, time)[0])

    return bisect_left(range(base.samples), steps, key=travelled)


def harmonic_orders(mechanism: Mechanism) -> tuple[float, ...]:
    """Return the periods of each harmonic of the rotor's angle in one electrical turn; none without a stepper."""
    return tuple(h.orders for h in mechanism.harmonics if h.of_rotor)


def turns_deg(command: Command, orders: Sequence[float]) -> tuple[float, ...]:
    """Return the turns of the start angle, least first, between which records of one mechanism can tell.

    A drive may have stood at any of its microsteps, or at a half step: which of its full steps has both phases on is
    not always known. Turns that leave all detents as they are give the same records, and the least stands for them.
    """
    count = math.lcm(command.microsteps, 2) * 4
    turns = sorted(
        (360.0 * k / count for k in range(1 - count // 2, count // 2 + 1)), key=lambda turn: (abs(turn), -turn)
    )
    different: list[float] = []
    for turn in turns:
        if not any(_is_same(turn - other, command, orders) for other in different):
            different.append(turn)
    return tuple(different)


def _is_same(turn: float, command: Command, orders: Sequence[float]) -> bool:
    """Tell whether a turn of all of a record is one that no torque shows."""
    cycles = [turn * order / 360.0 for order in orders]
    if command.waveform == "square":
        cycles.append(turn / 90.0)
    return all(abs(c - round(c)) < SAME for c in cycles)


def variants(command: Command, orders: Sequence[float]) -> tuple[Reading, ...]:
    """Return all that a record may be by sign, direction and start angle; the declared comes first.

    One that measured channels drive has no direction or start of its own.
    """
    if isinstance(command, MeasuredCommand):
        return Reading(), Reading(polarity=-1)
    return tuple(
        Reading(
            polarity=polarity,
            direction=direction,
            start_angle_deg=None if turn == 0.0 else _wrapped(command.start_angle_deg + turn),
        )
        for turn in turns_deg(command, orders)
        for direction in (1, -1)
        for polarity in (1, -1)
    )


def steppings(command: Command) -> tuple[Reading, ...]:
    """Return the steps that may have been counted wrongly: twice or half as many to a full step.

    The driver was set otherwise at the same rate, or the same pulses were taken for those of another setting, so that
    the rate of full steps is another one too.
    """
    if isinstance(command, MeasuredCommand):
        return ()
    own, found = command.microsteps, []
    counts = [2 * own] * (2 * own <= MOST_MICROSTEPS) + [own // 2] * (own % 2 == 0)
    for microsteps in counts:
        taken = Reading(stepping=stepping_of(microsteps), microsteps=microsteps)
        found += [taken, replace(taken, rate=_at_share(command.rate, own / microsteps))]
    return tuple(found)


def _at_share(rate: RateProfile, share: float) -> RateProfile:
    return RateProfile(rate.times_s, tuple(share * one for one in rate.rates))


def _wrapped(angle_deg: float) -> float:
    """Return an angle in (-180, 180]."""
    return 180.0 - (180.0 - angle_deg) % 360.0


def judge(problem: Problem, q: FloatArray, target: Target, look: int) -> list[ReadingScore]:
    """Return the declared reading of a record, then the others that may be it, the likeliest first.

    Parameters
    ----------
    problem : Problem
        Of the records that agree.
    q : (n,)
        Where these are followed.
    target : Target
        The record to be judged.
    look : int
        Over how many of its samples.
    """
    orders = harmonic_orders(problem.space.mechanism)
    start = target.beginning(look)
    here = np.asarray(q[: problem.space.size])
    known = start.settled
    options = variants(target.command, orders)
    costs = _costs(problem, here, known, options)
    declared = _judged(problem, here, known, options[0], costs[0])
    if declared.follows:
        return [declared]
    order = sorted(range(1, len(options)), key=lambda i: costs[i])
    late = _latest(problem, here, known)
    found = [_judged(problem, here, known, options[i], costs[i]) for i in order[:8] if math.isfinite(costs[i])]
    longer = target.beginning(min(target.samples, LONG)).settled  # the first moments of a sweep are small
    gains = dict.fromkeys(_gain(problem, here, one) for one in (known, longer))
    found += [late] if late else []
    found += [_of_gain(problem, here, known, gain) for gain in gains if gain is not None]
    if not any(one.follows for one in found):
        others = steppings(target.command)
        costs = _costs(problem, here, known, others) if others else []
        found += [_judged(problem, here, known, o, c) for o, c in zip(others, costs, strict=True) if math.isfinite(c)]
    return [declared, *_likeliest(found)]


def _likeliest(found: list[ReadingScore]) -> list[ReadingScore]:
    """Return by likelihood, of those as likely as the best the least change first."""
    least = min((j.cost for j in found), default=math.inf)

    def place(j: ReadingScore) -> tuple[bool, bool, float, float]:
        near = j.cost <= least + NEAR
        return not j.follows, not near, j.taken.changes if near else 0.0, j.cost

    return sorted(found, key=place)


def _costs(problem: Problem, q: FloatArray, target: Target, options: Sequence[Reading]) -> list[float]:
    """Return ||r||^2 of a target under each reading, in sigmas squared; inf where the simulation fails."""
    targets = tuple(replace(target_as_read(target, o), name=f"{target.name} {i}") for i, o in enumerate(options))
    many = replace(problem, targets=targets)
    return [norm**2 for norm in many.norms(q, many.whole())]


def _judged(problem: Problem, q: FloatArray, target: Target, taken: Reading, cost: float) -> ReadingScore:
    own = target_as_read(target, replace(taken, time_offset_s=None))
    if taken.time_offset_s is not None:
        own = own.with_time_offset(replace(own.time_offset, value=taken.time_offset_s[0]))
    alone = replace(problem, targets=(own,))
    return ReadingScore(taken, cost, followed_samples(alone, own, q) >= own.samples, own.samples)


def side_by_side(problem: Problem, q: FloatArray, target: Target) -> tuple[FloatArray, FloatArray]:
    """Return what the model gives of a record's leading channel, and what was measured, each less its offset and drift.

    Of a problem that the record may be none of; NaN where it cannot be simulated.
    """
    alone = replace(problem, targets=(target,))  # without the coordinates that only other records have
    modelled = np.array(alone.model.predict(target, q, target.samples)[0])
    measured = np.array(target.leading.measured[:])
    if np.all(np.isfinite(modelled)):
        for y in (modelled, measured):
            fit_line(y, 2).take_from(y)
    return modelled, measured


def _gain(problem: Problem, q: FloatArray, target: Target) -> float | None:
    """Return the factor by which a record is nearest to the model where its gain is off by no unit, else None."""
    modelled, measured = side_by_side(problem, q, target)
    if not np.all(np.isfinite(modelled)):
        return None
    common = float(measured @ modelled)
    scale = float(modelled @ modelled) / common if common > 0.0 else 0.0
    if not LEAST_GAIN < scale < 1.0 / LEAST_GAIN or abs(scale - 1.0) < SAME_GAIN:
        return None
    return scale


def _of_gain(problem: Problem, q: FloatArray, target: Target, gain: float) -> ReadingScore:
    taken = Reading(scale=gain)
    return _judged(problem, q, target, taken, _costs(problem, q, target, [taken])[0])


def _latest(problem: Problem, q: FloatArray, target: Target) -> ReadingScore | None:
    """Return the likeliest time offset, up to half the time of the first full step either way."""
    from scipy.optimize import minimize_scalar  # takes 0.1 s to load, and `check` has no use for it

    reach = _reach(target)
    if reach < 1 or isinstance(target.command, MeasuredCommand):
        return None
    shift = _best_shift(problem, q, target, reach)
    tick = target.base.interval_s

    def cost(offset_s: float) -> float:
        moved = target_as_read(target, Reading(time_offset_s=(offset_s, offset_s, offset_s)))
        alone = replace(problem, targets=(moved.settled,))
        return float(min(alone.norm(alone.targets[0], q, (0, target.samples)) ** 2, 1e300))

    about = target.time_offset.value + shift * tick
    fine = minimize_scalar(cost, bounds=(about - tick, about + tick), method="bounded", options={"xatol": 1e-3 * tick})
    limits = target.time_offset.value - reach * tick, target.time_offset.value + reach * tick
    if not limits[0] < fine.x < limits[1]:
        return None
    return _judged(problem, q, target, Reading(time_offset_s=(float(fine.x), *limits)), float(fine.fun))


def _reach(target: Target) -> int:
    """Return how many samples of time offset cannot be told from another start angle, halved."""
    return samples_of(target, 1.0) // 2


def _best_shift(problem: Problem, q: FloatArray, target: Target, reach: int) -> int:
    """Return by how many samples the model's leading channel, moved, fits best; before its beginning it rests."""
    longer = replace(target, base=replace(target.base, samples=target.samples + reach))
    y = replace(problem, targets=(longer,)).model.predict(longer, q, longer.samples)[0]
    y = np.concatenate([np.zeros(reach), np.nan_to_num(y, nan=1e6)])
    n, measured = target.samples, target.leading.measured[:]
    spread = [float(np.var(residual(y[reach - k : reach - k + n], measured))) for k in range(-reach, reach + 1)]
    return int(np.argmin(spread)) - reach
