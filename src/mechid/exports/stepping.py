"""Stepping modes of a campaign, and the rates at which the torque is tabulated."""

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
"""Least number of intervals in the range of rates."""
ORDERS = np.arange(1, 33) / 2.0
"""Orders of the step rate that can excite a resonance; lines occur at half orders."""
GRADE, NARROWEST = 0.3, 1e-3
"""Largest spacing of rates, as a share of the distance to the nearest resonance of an order or of its half-width,
whichever is larger; and least relative half-width."""
MOST = 300
"""Most rates; if narrow resonances require more, the share is doubled until the limit holds."""
APART = 1e-3
"""Relative distance to the constant rate of a record below which other rates are dropped."""
# A slow motion has a long period and many lines.
SPAN = 24.0
"""Largest ratio of highest to lowest rate; slow motions have long periods and many lines."""
# Slower periods take minutes to simulate, and no stepper follows faster rates.
SLOWEST, FASTEST = 0.02, 1e5
"""Limits of rates in full steps/s: slower periods take minutes to simulate, and no stepper follows faster rates."""
SLOWEST_ASKED = 0.5
"""Lowest rate of a further range: at half a step a second a period lasts four seconds."""
NEAR = 1e-9


@dataclass(frozen=True)
class Stepping:
    """Stepping mode of a campaign.

    Attributes
    ----------
    name : str
        Name as ``full`` or ``micro16``.
    command : Command
        Command of the first record in this mode; its rate is ignored.
    ranges : tuple of (float, float)
        Least and largest magnitude of the rate of each record in this mode, full steps/s.
    """

    name: str
    command: Command
    ranges: tuple[tuple[float, float], ...]

    def covers(self, rates: FloatArray) -> BoolArray:
        """Return whether a record of this mode ran at each of the rates, (r,)."""
        inside = [(rates >= low * (1.0 - NEAR)) & (rates <= high * (1.0 + NEAR)) for low, high in self.ranges]
        return np.asarray(np.any(inside, axis=0))


def steppings(trials: Sequence[Trial]) -> tuple[Stepping, ...]:
    """Return the stepping modes of records, in order; records that hardly step are ignored."""
    found: dict[tuple[object, ...], list[Trial]] = {}
    for trial in trials:
        if _range(trial)[1] >= SLOWEST:
            found.setdefault(_key(trial.command), []).append(trial)
    plain = [_name(alike[0].command) for alike in found.values()]
    return tuple(
        Stepping(
            name=name if plain.count(name) == 1 else f"{name}_{_apart(alike[0].command, at)}",
            command=replace(alike[0].command, start="commanded", begun_s=0.0, rate=RateProfile.constant(1.0)),
            ranges=tuple(map(_range, alike)),
        )
        for at, (name, alike) in enumerate(zip(plain, found.values(), strict=True), start=1)
    )


def choose_rates(
    mechanism: Mechanism, modes: Sequence[Stepping], also: Sequence[tuple[float, float]] = ()
) -> FloatArray:
    """Choose rates for a campaign, (r,) full steps/s: over its range, at its constant rates and near resonances.

    Rates are closely spaced where an order of the steps excites a resonance of the mechanism.

    Parameters
    ----------
    mechanism : Mechanism
    modes : sequence of Stepping
    also : sequence of (float, float)
        Further ranges.
    """
    ranges = np.array([one for mode in modes for one in mode.ranges])
    highest = float(ranges.max())
    slowest = np.where(ranges[:, 0] > 0.0, ranges[:, 0], highest / SPAN)
    lowest = max(float(slowest.min()), highest / SPAN, SLOWEST)
    constant = np.unique(ranges[(ranges[:, 0] == ranges[:, 1]) & (ranges[:, 0] >= SLOWEST), 0])
    asked = [(max(low, SLOWEST_ASKED), min(high, FASTEST)) for low, high in also if high >= SLOWEST_ASKED]
    grid = np.concatenate([_graded_rates(mechanism, *ends) for ends in [(lowest, highest), *asked]])
    away = np.all(np.abs(grid[:, None] / constant - 1.0) > APART, axis=1)
    return np.unique(np.round(np.concatenate([grid[away], constant]), 9))


def _graded_rates(mechanism: Mechanism, lowest: float, highest: float) -> FloatArray:
    """Return rates from the lowest to the highest, (r,), with closer spacing near resonances of an order."""
    found = resonances(mechanism)
    met = np.array([r.frequency_hz / order for r in found for order in ORDERS])
    width = np.repeat([max(r.damping, NARROWEST) for r in found], ORDERS.size)
    grade, rates = GRADE, _spaced_rates(met, width, GRADE, lowest, highest)
    while len(rates) > MOST:
        grade *= 2.0
        rates = _spaced_rates(met, width, grade, lowest, highest)
    return np.array(rates)


def _spaced_rates(met: FloatArray, width: FloatArray, grade: float, lowest: float, highest: float) -> list[float]:
    """Return rates spaced by a share of their distance to the resonant rates, (m,), with the given widths."""
    rates = [lowest]
    while rates[-1] < highest:
        off = np.maximum(np.abs(rates[-1] / met - 1.0), width)
        step = min((highest - lowest) / COUNT, grade * rates[-1] * off.min(initial=np.inf))
        rates.append(min(rates[-1] + step, highest))
    return rates


def _range(trial: Trial) -> tuple[float, float]:
    """Return the least and the largest magnitude of the rate within a record."""
    rate, end_s = trial.command.rate, trial.base.start_s + trial.base.duration_s
    within = [r for t, r in zip(rate.times_s, rate.rates, strict=True) if 0.0 <= t <= end_s]
    values = np.array([rate.at(0.0), *within, rate.at(end_s)])
    # A profile through 0 covers all small rates.
    crosses_zero = values.min() < 0.0 < values.max()
    return 0.0 if crosses_zero else float(np.abs(values).min()), float(np.abs(values).max())


def _key(command: Command) -> tuple[object, ...]:
    """Return a key of the stepping mode; start angles that differ by whole steps are equivalent."""
    # Start angles that differ by whole steps give the same motion; along a table, those by its symmetry.
    step_deg = command.symmetry_deg if command.table else command.full_step_deg / command.steps_per_full_step
    angle = round(command.start_angle_deg % step_deg / step_deg, 9) % 1.0
    return command.stepping, command.microsteps, command.waveform, command.table, command.clock_tick_s, angle


def _apart(command: Command, number: int) -> str:
    return f"{number}" if command.table else f"{command.start_angle_deg:g}deg"


def _name(command: Command) -> str:
    count = str(command.microsteps) if command.stepping == "micro" else ""
    waveform = "" if command.waveform_name == "cosine" else f"_{command.waveform_name}"
    tick = f"_tick{1e6 * command.clock_tick_s:g}us" if command.clock_tick_s else ""
    return f"{command.stepping}{count}{waveform}{tick}"
