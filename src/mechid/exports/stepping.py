"""The ways in which a campaign stepped the mechanism, and the rates at which its torque is tabulated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.command import Command, RateProfile
from mechid.exports.handover import Trial
from mechid.plant.mechanism import Mechanism
from mechid.simulation.resonances import resonances

COUNT = 40
"""Parts of the range, evenly: rates are nowhere further apart."""
ORDERS = np.arange(1, 33) / 2.0
"""Of the step rate that may meet a resonance: lines stand at halves."""
GRADE, NARROWEST = 0.3, 1e-3
"""Rates are no further apart than this share of how far away an order meets a resonance, or of its half width, which is
taken as no less than the second, relative."""
MOST = 300
"""Rates; where several narrow resonances would ask for more, the share is doubled until they do not."""
APART = 1e-3
"""Relative distance from a record's constant rate, below which no other is kept."""
SPAN = 24.0
"""The lowest rate is no smaller than this part of the highest: a slow period is long and has many lines."""
SLOWEST, FASTEST = 0.02, 1e5
"""Full steps/s: slower ones take minutes for a period, and at faster ones no stepper follows."""
FULL_STEP_DEG = 90.0
NEAR = 1e-9


@dataclass(frozen=True)
class Stepping:
    """One way of stepping.

    Attributes
    ----------
    name : str
        As ``full``, ``micro16``.
    command : Command
        Of the first record that was stepped so; its rate counts for nothing.
    ranges : tuple of (float, float)
        Least and largest rate of each record that was stepped so, full steps/s, without sign.
    """

    name: str
    command: Command
    ranges: tuple[tuple[float, float], ...]

    def tested(self, rates: FloatArray) -> BoolArray:
        """Return at which rates, (r,), a record of this stepping ran."""
        inside = [(rates >= low * (1.0 - NEAR)) & (rates <= high * (1.0 + NEAR)) for low, high in self.ranges]
        return np.asarray(np.any(inside, axis=0))


def steppings(trials: Sequence[Trial]) -> tuple[Stepping, ...]:
    """Return the ways of stepping of some records, in their order; records that hardly step tell none."""
    found: dict[tuple[object, ...], list[Trial]] = {}
    for trial in trials:
        if _range(trial)[1] >= SLOWEST:
            found.setdefault(_key(trial.command), []).append(trial)
    plain = [_name(alike[0].command) for alike in found.values()]
    return tuple(
        Stepping(
            name=name if plain.count(name) == 1 else f"{name}_{alike[0].command.start_angle_deg:g}deg",
            command=replace(alike[0].command, start="commanded", begun_s=0.0, rate=RateProfile.constant(1.0)),
            ranges=tuple(map(_range, alike)),
        )
        for name, alike in zip(plain, found.values(), strict=True)
    )


def usual_rates(mechanism: Mechanism, ways: Sequence[Stepping]) -> FloatArray:
    """Return the rates of a campaign, (r,) full steps/s: its range evenly, its constant rates, its resonances.

    Where an order of the steps meets a resonance of the mechanism, rates stand close enough to show it.
    """
    ranges = np.array([one for way in ways for one in way.ranges])
    highest = float(ranges.max())
    slowest = np.where(ranges[:, 0] > 0.0, ranges[:, 0], highest / SPAN)
    lowest = max(float(slowest.min()), highest / SPAN, SLOWEST)
    constant = np.unique(ranges[(ranges[:, 0] == ranges[:, 1]) & (ranges[:, 0] >= SLOWEST), 0])
    grid = _graded(mechanism, lowest, highest)
    away = np.all(np.abs(grid[:, None] / constant - 1.0) > APART, axis=1)
    return np.unique(np.round(np.concatenate([grid[away], constant]), 9))


def _graded(mechanism: Mechanism, lowest: float, highest: float) -> FloatArray:
    """Return rates from the lowest to the highest, (r,), the closer the nearer an order is to a resonance."""
    found = resonances(mechanism)
    met = np.array([r.frequency_hz / order for r in found for order in ORDERS])
    width = np.repeat([max(r.damping, NARROWEST) for r in found], ORDERS.size)
    grade, rates = GRADE, _stepped(met, width, GRADE, lowest, highest)
    while len(rates) > MOST:
        grade *= 2.0
        rates = _stepped(met, width, grade, lowest, highest)
    return np.array(rates)


def _stepped(met: FloatArray, width: FloatArray, grade: float, lowest: float, highest: float) -> list[float]:
    """Return rates that stand by a share of how far they are from where orders meet resonances, (m,), of some width."""
    rates = [lowest]
    while rates[-1] < highest:
        off = np.maximum(np.abs(rates[-1] / met - 1.0), width)
        step = min((highest - lowest) / COUNT, grade * rates[-1] * off.min(initial=np.inf))
        rates.append(min(rates[-1] + step, highest))
    return rates


def _range(trial: Trial) -> tuple[float, float]:
    """Return the least and the largest rate within a record, without sign."""
    rate, end_s = trial.command.rate, trial.base.start_s + trial.base.duration_s
    within = [r for t, r in zip(rate.times_s, rate.rates, strict=True) if 0.0 <= t <= end_s]
    values = np.array([rate.at(0.0), *within, rate.at(end_s)])
    crosses_zero = values.min() < 0.0 < values.max()
    return 0.0 if crosses_zero else float(np.abs(values).min()), float(np.abs(values).max())


def _key(command: Command) -> tuple[object, ...]:
    """Return what tells ways of stepping apart; whole steps of the start angle do not."""
    step_deg = FULL_STEP_DEG / command.steps_per_full_step
    angle = round(command.start_angle_deg % step_deg / step_deg, 9) % 1.0
    return command.stepping, command.microsteps, command.waveform, command.clock_tick_s, angle


def _name(command: Command) -> str:
    count = str(command.microsteps) if command.stepping == "micro" else ""
    waveform = "" if command.waveform == "cosine" else f"_{command.waveform}"
    tick = f"_tick{1e6 * command.clock_tick_s:g}us" if command.clock_tick_s else ""
    return f"{command.stepping}{count}{waveform}{tick}"
