"""Step loss of a command: lost pole pairs, pull-in and pull-out rates, and margins.

The motor's torque over the rotor's angle repeats every electrical period, a pole pair or four full steps, and pulls
the rotor to the commanded angle of its own period. A step is lost when the rotor leaves that period permanently. After
the command the motor is held until the rotor is at rest, and

    N = round((p/2 alpha - theta) / 2 pi)

pole pairs are lost (N < 0) or gained, 4 |N| full steps. A swing past the edge and back is not a loss. Pull-in
(start-stop) rates are those at which the motor starts and stops abruptly without loss. Pull-out rates are those that it
reaches and leaves slowly without loss (Acarnley, Stepping Motors, 4th ed. 2002, chapter 5).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from mechid.command import Command, RateProfile
from mechid.command.edges import step_edges
from mechid.designs.rate_limit import RateLimit, rate_limit, rates_to_try
from mechid.designs.settings import RATE
from mechid.parameter import Role
from mechid.plant.mechanism import Mechanism
from mechid.plant.plant import Plant
from mechid.plant.stepper import HOLDING
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run
from mechid.simulation.trajectory import SimulationOutcome


@dataclass(frozen=True)
class DriveResult:
    """Outcome of a command.

    Attributes
    ----------
    pole_pairs_lost : int or None
        Negative if the rotor fell behind; None if the simulation failed.
    peak_torque : float
        Largest magnitude of the measured torque during the command, N m.
    """

    pole_pairs_lost: int | None
    peak_torque: float

    @property
    def lost(self) -> bool:
        """Whether steps were lost."""
        return self.pole_pairs_lost != 0


def drive(mechanism: Mechanism, command: Command, seconds: float, *, torque: bool = True) -> DriveResult:
    """Simulate a mechanism through some seconds of a command that then stops abruptly.

    Parameters
    ----------
    mechanism : Mechanism
        A stepper whose rotor angle can be measured.
    command : Command
    seconds : float
    torque : bool
        Whether the peak torque is needed.
    """
    measured = ("rotor_angle", "torque") if torque else ("rotor_angle",)
    watched = replace(mechanism, plant=_plant_measuring(mechanism.plant, measured))
    held = stop_after(command, seconds)
    base = TimeBase(RATE.sample_rate_hz, round((seconds + RATE.hold_s) * RATE.sample_rate_hz) + 1)
    simulator = Simulator(watched.plant, held, base)
    trajectory = simulate_run(simulator.run(watched.kernel_values()))
    # None differs from 0, so that a failed simulation counts as a loss of steps.
    if trajectory.outcome is not SimulationOutcome.COMPLETE:
        return DriveResult(None, math.inf)
    # The average over the last part removes the decaying swing of the rotor.
    resting = round(RATE.at_rest_share * RATE.hold_s * RATE.sample_rate_hz)
    angle = (mechanism.electrical_periods or 1.0) * float(np.mean(trajectory.values["rotor_angle"][-resting:]))
    _, index = step_edges(held.rate, held.steps_per_full_step, seconds + RATE.hold_s)
    step = math.radians(held.full_step_deg)
    wanted = held.start_angle_rad + (index[-1] if index.size else 0) * step / held.steps_per_full_step
    during = trajectory.values["torque"][: round(seconds * RATE.sample_rate_hz) + 1] if torque else np.zeros(1)
    return DriveResult(round((angle - wanted) / (2.0 * math.pi)), float(np.max(np.abs(during))))


@lru_cache(maxsize=16)
def _plant_measuring(plant: Plant, measured: tuple[str, ...]) -> Plant:
    return plant.with_outputs(measured)


def stop_after(command: Command, seconds: float) -> Command:
    """Return a command that stops abruptly after some seconds."""
    profile = command.rate
    kept = [(t, r) for t, r in zip(profile.times_s, profile.rates, strict=True) if t < seconds]
    last = float(np.interp(seconds, profile.times_s, profile.rates))
    # A profile needs a point at time 0.
    first = [] if kept else [(0.0, last)]
    return replace(command, rate=RateProfile.through([*first, *kept, (seconds, last), (seconds, 0.0)]))


def is_stepper(mechanism: Mechanism) -> bool:
    """Return whether step loss is defined for a mechanism: driven step by step, with a known rotor angle."""
    inputs = {str(s) for s in mechanism.plant.inputs}
    return {"e_A", "e_B"} <= inputs and mechanism.electrical_periods is not None


def pull_in(mechanism: Mechanism, command: Command) -> RateLimit:
    """Return the rates at which the motor starts and stops abruptly without loss."""

    def holds(rate: float) -> bool:
        return not drive(mechanism, _at(command, rate), RATE.started_s, torque=False).lost

    return rate_limit(holds, rates_to_try(mechanism, command))


def pull_out(mechanism: Mechanism, command: Command, started: RateLimit | None = None) -> RateLimit:
    """Return the rates at which the motor follows when it is brought there slowly.

    The ramp starts from rest or, if the widest range of pull-in rates lies above a hole, from the middle of that range:
    a slow start from rest would dwell in the hole, and a loss there would say nothing about higher rates. Rates of that
    range are taken to hold, since the motor can start at them.

    Parameters
    ----------
    mechanism : Mechanism
    command : Command
    started : RateLimit or None
        Pull-in rates as `pull_in` found them; None computes them.
    """
    started = started or pull_in(mechanism, command)
    first, last = started.widest or (RATE.lowest, RATE.lowest)
    # The geometric mean, since rates are searched on a logarithmic scale.
    begin = math.sqrt(first * last) if first > RATE.lowest else 0.0
    up, down = RATE.ramp_s + RATE.started_s, 2.0 * RATE.ramp_s + RATE.started_s

    def holds(rate: float) -> bool:
        if begin <= rate < last:
            return True
        slow = RateProfile.through([(0.0, begin), (RATE.ramp_s, rate), (up, rate), (down, begin)])
        return not drive(mechanism, replace(command, rate=slow), down, torque=False).lost

    steps = math.ceil(math.log(RATE.highest / last) / math.log(RATE.slow_ratio))
    rates = [begin or RATE.lowest, *np.geomspace(last, RATE.highest, steps + 1).tolist()]
    return rate_limit(holds, sorted(set(rates)), begin)


def _at(command: Command, rate: float) -> Command:
    return replace(command, rate=RateProfile.constant(rate))


@dataclass(frozen=True)
class Margins:
    """Margins of a command against step loss; None if no change within the search range causes one.

    Attributes
    ----------
    lost : bool
        Whether steps are lost without any change; then there is no margin.
    voltage : float or None
        Share of the peak voltage that may be missing.
    torque_Nm : float or None
        Additional dry friction at the rotor, N m.
    inertia_factor : float or None
        Factor on the load's inertia.
    """

    lost: bool
    voltage: float | None = None
    torque_Nm: float | None = None
    inertia_factor: float | None = None


def margins(mechanism: Mechanism, command: Command, seconds: float) -> Margins:
    """Return the margins of a command, each with the other quantities unchanged, by bisection."""

    def holds(changed: Mechanism) -> bool:
        return not drive(changed, command, seconds, torque=False).lost

    if not holds(mechanism):
        return Margins(True)
    has = mechanism.plant.names_with_role
    supply = torque = inertia = None
    if has(Role.SUPPLY):
        supply = _largest(lambda x: holds(scale_supply(mechanism, 1.0 - x)), 0.99)
    if has(Role.DRY_FRICTION):
        most = mechanism.scale(HOLDING)
        torque = _largest(lambda x: holds(add_friction(mechanism, x)), most) if most else None
    if has(Role.LOAD_INERTIA):
        found = _largest(lambda x: holds(scale_load(mechanism, math.exp(x))), math.log(100.0))
        inertia = math.exp(found) if found is not None else None
    return Margins(False, supply, torque, inertia)


def scale_supply(mechanism: Mechanism, factor: float) -> Mechanism:
    """Scale the supply of a mechanism, a voltage or a current depending on its drive."""
    return _scale_role(mechanism, Role.SUPPLY, factor)


def scale_load(mechanism: Mechanism, factor: float) -> Mechanism:
    """Scale the load inertia of a mechanism."""
    return _scale_role(mechanism, Role.LOAD_INERTIA, factor)


def _scale_role(mechanism: Mechanism, role: Role, factor: float) -> Mechanism:
    return mechanism.with_values(
        {name: factor * mechanism.value(name) for name in mechanism.plant.names_with_role(role)}
    )


def add_friction(mechanism: Mechanism, torque: float) -> Mechanism:
    """Add dry friction at the rotor, N m: a load torque that opposes motion."""
    names = mechanism.plant.names_with_role(Role.DRY_FRICTION)
    return mechanism.with_values({name: mechanism.value(name) + torque for name in names})


def _largest(holds: Callable[[float], bool], most: float) -> float | None:
    """Return the largest change below which all tried ones hold, None if `most` holds too."""
    good, bad = 0.0, most
    # A coarse search first: beyond a resonance a larger change may hold again, and bisection alone would find that end.
    steps = np.linspace(0.0, most, 9)[1:]
    for x in steps:
        if not holds(float(x)):
            bad = float(x)
            break
        good = float(x)
    else:
        return None
    while bad - good > RATE.resolution * most:
        middle = 0.5 * (good + bad)
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    return good
