"""Alternative readings of a record, judged under a model that other records have determined.

A record may have the other sign of torque, the other direction of the command, other steps, another start position of
the drive, or another start time than declared. It cannot be followed as declared, but is followed at once as it was
recorded. Short simulations identify that reading.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.command import Command, MeasuredCommand, RateProfile
from mechid.command.stepping import MOST_MICROSTEPS, stepping_of
from mechid.identification.output_error.declaration import Reading, reinterpret_target
from mechid.identification.output_error.misfit import residual
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.readings.rules import RULES
from mechid.identification.readings.trial import samples_until
from mechid.identification.search.horizons import followed_samples
from mechid.plant.mechanism import Mechanism
from mechid.signal.trend import fit_line
from mechid.units import unit_words

SAME_CYCLES = 1e-9
"""Distance from whole cycles that counts as rounding."""


@dataclass(frozen=True)
class ReadingScore:
    """A reading of a record, its cost over some samples (sigmas squared), and whether the model follows it there."""

    reading: Reading
    cost: float
    follows: bool
    samples: int


def harmonic_orders(mechanism: Mechanism) -> tuple[float, ...]:
    """Return the periods of each harmonic of the rotor's angle in one electrical turn; empty without a stepper."""
    return tuple(h.orders for h in mechanism.harmonics if h.of_rotor)


def distinct_turns_deg(command: Command, orders: Sequence[float]) -> tuple[float, ...]:
    """Return the turns of the start angle that change the records of a mechanism, smallest first.

    A drive may have stood at any of its microsteps, or at a half step, since the full steps with both phases on are not
    always known. Turns that leave all detents unchanged give the same records; the smallest of them is returned.
    """
    count = (command.microsteps if command.table else math.lcm(command.microsteps, 2)) * command.full_steps
    turns = sorted(
        (360.0 * k / count for k in range(1 - count // 2, count // 2 + 1)), key=lambda turn: (abs(turn), -turn)
    )
    different: list[float] = []
    for turn in turns:
        if not any(_is_same(turn - other, command, orders) for other in different):
            different.append(turn)
    return tuple(different)


def _is_same(turn: float, command: Command, orders: Sequence[float]) -> bool:
    """Tell whether a turn of a whole record leaves its torque unchanged."""
    cycles = [turn * order / 360.0 for order in orders]
    if command.waveform == "square":
        cycles.append(turn / command.full_step_deg)
    if command.table:
        cycles.append(turn / command.symmetry_deg)
    return all(abs(c - round(c)) < SAME_CYCLES for c in cycles)


def variants(command: Command, orders: Sequence[float]) -> tuple[Reading, ...]:
    """Return all readings by sign, direction and start angle; the declared one comes first.

    A record that measured channels drive has no direction or start of its own.
    """
    if isinstance(command, MeasuredCommand):
        return Reading(), Reading(polarity=-1)
    return tuple(
        Reading(
            polarity=polarity,
            direction=direction,
            start_angle_deg=None if turn == 0.0 else _wrap_angle(command.start_angle_deg + turn),
        )
        for turn in distinct_turns_deg(command, orders)
        for direction in (1, -1)
        for polarity in (1, -1)
    )


def other_steppings(command: Command) -> tuple[Reading, ...]:
    """Return the readings with twice or half as many microsteps per full step.

    Either the driver had another setting at the same rate, or its pulses were counted for another setting, so that the
    rate of full steps differs too.
    """
    if isinstance(command, MeasuredCommand):
        return ()
    own, found = command.microsteps, []
    counts = [2 * own] * (2 * own <= MOST_MICROSTEPS) + [own // 2] * (own % 2 == 0)
    for microsteps in counts:
        taken = Reading(stepping=stepping_of(microsteps), microsteps=microsteps)
        found += [taken, replace(taken, rate=_scale_rate(command.rate, own / microsteps))]
    return tuple(found)


def _scale_rate(rate: RateProfile, share: float) -> RateProfile:
    return RateProfile(rate.times_s, tuple(share * one for one in rate.rates))


def _wrap_angle(angle_deg: float) -> float:
    """Return an angle in (-180, 180]."""
    return 180.0 - (180.0 - angle_deg) % 360.0


def judge(problem: Problem, q: FloatArray, target: Target, look: int) -> list[ReadingScore]:
    """Return the declared reading of a record, then the alternative ones, the likeliest first.

    Parameters
    ----------
    problem : Problem
        Records that agree.
    q : (n,)
        Point at which these are followed.
    target : Target
        The record to be judged.
    look : int
        Number of its samples over which it is judged.
    """
    orders = harmonic_orders(problem.space.mechanism)
    start = target.truncate(look)
    here = np.asarray(q[: problem.space.size])
    known = start.with_fixed_parameters
    options = variants(target.command, orders)
    costs = _reading_costs(problem, here, known, options)
    declared = _score_reading(problem, here, known, options[0], costs[0])
    if declared.follows:
        return [declared]
    order = sorted(range(1, len(options)), key=lambda i: costs[i])
    late = _best_time_offset(problem, here, known)
    found = [_score_reading(problem, here, known, options[i], costs[i]) for i in order[:8] if math.isfinite(costs[i])]
    # The first moments of a sweep are small: its gain shows only over a longer part.
    longer = target.truncate(min(target.samples, RULES.judged_samples)).with_fixed_parameters
    gains = dict.fromkeys(_nearest_gain(problem, here, one) for one in (known, longer))
    found += [late] if late else []
    found += [_score_gain(problem, here, known, gain) for gain in gains if gain is not None]
    if not any(one.follows for one in found):
        others = other_steppings(target.command)
        costs = _reading_costs(problem, here, known, others) if others else []
        found += [
            _score_reading(problem, here, known, o, c) for o, c in zip(others, costs, strict=True) if math.isfinite(c)
        ]
    return [declared, *_likeliest(found)]


def _likeliest(found: list[ReadingScore]) -> list[ReadingScore]:
    """Sort readings by likelihood; those nearly as likely as the best come in the order of least change."""
    least = min((j.cost for j in found), default=math.inf)

    def place(j: ReadingScore) -> tuple[bool, bool, float, float]:
        near = j.cost <= least + RULES.likelihood_margin
        return not j.follows, not near, j.reading.changes if near else 0.0, j.cost

    return sorted(found, key=place)


def _reading_costs(problem: Problem, q: FloatArray, target: Target, options: Sequence[Reading]) -> list[float]:
    """Return ||r||^2 of a target under each reading, in sigmas squared; inf where the simulation fails."""
    targets = tuple(replace(reinterpret_target(target, o), name=f"{target.name} {i}") for i, o in enumerate(options))
    many = replace(problem, targets=targets)
    return [norm**2 for norm in many.norms(q, many.whole_windows())]


def _score_reading(problem: Problem, q: FloatArray, target: Target, taken: Reading, cost: float) -> ReadingScore:
    own = reinterpret_target(target, replace(taken, time_offset_s=None))
    if taken.time_offset_s is not None:
        own = own.with_time_offset(replace(own.time_offset, value=taken.time_offset_s[0]))
    alone = replace(problem, targets=(own,))
    return ReadingScore(taken, cost, followed_samples(alone, own, q) >= own.samples, own.samples)


def side_by_side(problem: Problem, q: FloatArray, target: Target) -> tuple[FloatArray, FloatArray]:
    """Return the simulated and the measured leading channel of a record, each without its offset and drift.

    The record need not be one of the problem's. NaN where it cannot be simulated.
    """
    alone = replace(problem, targets=(target,))  # without the coordinates that only other records have
    modelled = np.array(alone.model.predict(target, q, target.samples)[0])
    measured = np.array(target.leading.measured[:])
    if np.all(np.isfinite(modelled)):
        for y in (modelled, measured):
            fit_line(y, 2).subtract_from(y)
    return modelled, measured


def _nearest_gain(problem: Problem, q: FloatArray, target: Target) -> float | None:
    """Return the factor that brings a record nearest to the model; None where it is no plausible gain error."""
    modelled, measured = side_by_side(problem, q, target)
    if not np.all(np.isfinite(modelled)):
        return None
    common = float(measured @ modelled)
    scale = float(modelled @ modelled) / common if common > 0.0 else 0.0
    if not RULES.least_gain < scale < 1.0 / RULES.least_gain or abs(scale - 1.0) < RULES.same_gain:
        return None
    return scale


def _score_gain(problem: Problem, q: FloatArray, target: Target, gain: float) -> ReadingScore:
    taken = Reading(scale=gain)
    return _score_reading(problem, q, target, taken, _reading_costs(problem, q, target, [taken])[0])


def _best_time_offset(problem: Problem, q: FloatArray, target: Target) -> ReadingScore | None:
    """Return the likeliest time offset within half the time of the first full step either way."""
    from scipy.optimize import minimize_scalar  # takes 0.1 s to load, and `check` has no use for it

    reach = _offset_reach(target)
    if reach < 1 or isinstance(target.command, MeasuredCommand):
        return None
    shift = _best_shift(problem, q, target, reach)
    tick = target.base.interval_s

    def cost(offset_s: float) -> float:
        moved = reinterpret_target(target, Reading(time_offset_s=(offset_s, offset_s, offset_s)))
        alone = replace(problem, targets=(moved.with_fixed_parameters,))
        return float(min(alone.norm(alone.targets[0], q, (0, target.samples)) ** 2, 1e300))

    about = target.time_offset.value + shift * tick
    fine = minimize_scalar(cost, bounds=(about - tick, about + tick), method="bounded", options={"xatol": 1e-3 * tick})
    limits = target.time_offset.value - reach * tick, target.time_offset.value + reach * tick
    if not limits[0] < fine.x < limits[1]:
        return None
    return _score_reading(problem, q, target, Reading(time_offset_s=(float(fine.x), *limits)), float(fine.fun))


def _offset_reach(target: Target) -> int:
    """Return half the samples of time offset that equal another start angle."""
    return samples_until(target, 1.0) // 2


def _best_shift(problem: Problem, q: FloatArray, target: Target, reach: int) -> int:
    """Return the shift in samples at which the model's leading channel fits best; before its start the model rests."""
    longer = replace(target, base=replace(target.base, samples=target.samples + reach))
    y = replace(problem, targets=(longer,)).model.predict(longer, q, longer.samples)[0]
    # A failed simulation becomes a huge output: its shifts lose against all others.
    y = np.concatenate([np.zeros(reach), np.nan_to_num(y, nan=1e6)])
    n, measured = target.samples, target.leading.measured[:]
    spread = [float(np.var(residual(y[reach - k : reach - k + n], measured))) for k in range(-reach, reach + 1)]
    return int(np.argmin(spread)) - reach


def describe_saturation(problem: Problem, q: FloatArray, target: Target) -> str:
    """Describe the saturation of a sensor relative to the other records' model, as a clause; empty without one.

    Parameters
    ----------
    problem : Problem
        Records that agree.
    q : (n,)
        Point at which these are followed.
    target : Target
        The examined samples of the record that contradicts them.
    """
    modelled, measured = side_by_side(problem, np.asarray(q[: problem.space.size]), target.with_fixed_parameters)
    largest = float(np.abs(modelled).max())
    if not np.isfinite(largest) or largest == 0.0:
        return ""
    # Scaled to 1, so that the cubic term directly gives the relative shortfall at the largest value.
    y = modelled / largest
    (gain, cubic), bent = _fit_rows(np.stack((y, y**3)), measured)
    _, straight = _fit_rows(y[np.newaxis], measured)
    short = -cubic / gain if gain > 0.0 else 0.0
    if straight < RULES.bend_gain * bent or short < RULES.least_bend:
        return ""
    return (
        f"the larger its {target.leading.quantity.replace('_', ' ')}, the more it falls short of the others' model, by "
        f"{100.0 * short:.2g} % at {largest:.3g} {unit_words(target.leading.quantity)}, as where a transducer or its "
        "amplifier saturates"
    )


def _fit_rows(rows: FloatArray, y: FloatArray) -> tuple[FloatArray, float]:
    """Return the least-squares factors of rows, (k, N), to samples, and the norm of the residual."""
    factors = np.asarray(np.linalg.lstsq(rows.T, y, rcond=None)[0], dtype=np.float64)
    return factors, float(np.linalg.norm(y - factors @ rows))
