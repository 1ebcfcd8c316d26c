"""Step loss: whether the rotor comes out of a command in the pole pair that was commanded, and how near it is to not.

The motor's torque over the rotor's angle repeats every electrical period, a pole pair or four full steps, and pulls
the rotor to the commanded angle of its own period. A step is lost when the rotor leaves that period for good: after
the command it is held until at rest, and

    N = round((p/2 alpha - theta) / 2 pi)

pole pairs are lost (N < 0) or gained, 4 |N| full steps. A swing past the edge and back loses nothing and does not
count. Pull-in (start-stop) rates: those at which the motor starts and stops at once without loss. Pull-out rates: the
same where the rate is raised and lowered slowly (Acarnley, Stepping Motors, 4th ed. 2002, chapter 5).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from mechid.command import Command, RateProfile
from mechid.command.edges import step_edges
from mechid.designs.rate_limit import RateLimit, rate_limit, rates_tried
from mechid.designs.settings import RATE
from mechid.parameter import Role
from mechid.plant.mechanism import Mechanism
from mechid.plant.plant import Plant
from mechid.plant.stepper import HOLDING
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run
from mechid.simulation.trajectory import SimulationOutcome


@dataclass(frozen=True)
class Driven:
    """How a mechanism came through a command.

    Attributes
    ----------
    pole_pairs_lost : int or None
        Negative where the rotor fell behind; None where the simulation failed.
    peak_torque : float
        Largest magnitude of the measured torque during the command, N m.
    """

    pole_pairs_lost: int | None
    peak_torque: float

    @property
    def lost(self) -> bool:
        """Whether steps were lost."""
        return self.pole_pairs_lost != 0


def driven(mechanism: Mechanism, command: Command, seconds: float, *, torque: bool = True) -> Driven:
    """Return how a mechanism comes through a command of some seconds that then stops at once.

    Parameters
    ----------
    mechanism : Mechanism
        A stepper, its rotor's angle among what can be measured.
    command : Command
    seconds : float
    torque : bool
        Whether the peak torque is wanted.
    """
    measured = ("rotor_angle", "torque") if torque else ("rotor_angle",)
    watched = replace(mechanism, plant=_watched(mechanism.plant, measured))
    held = stopped(command, seconds)
    base = TimeBase(RATE.sample_rate_hz, round((seconds + RATE.hold_s) * RATE.sample_rate_hz) + 1)
    simulator = Simulator(watched.plant, held, base)
    trajectory = simulate_run(simulator.run(watched.kernel_values()))
    if trajectory.outcome is not SimulationOutcome.COMPLETE:
        return Driven(None, math.inf)
    resting = round(RATE.at_rest_share * RATE.hold_s * RATE.sample_rate_hz)
    angle = (mechanism.electrical_periods or 1.0) * float(np.mean(trajectory.values["rotor_angle"][-resting:]))
    _, index = step_edges(held.rate, held.steps_per_full_step, seconds + RATE.hold_s)
    wanted = held.start_angle_rad + (index[-1] if index.size else 0) * 0.5 * math.pi / held.steps_per_full_step
    during = trajectory.values["torque"][: round(seconds * RATE.sample_rate_hz) + 1] if torque else np.zeros(1)
    return Driven(round((angle - wanted) / (2.0 * math.pi)), float(np.max(np.abs(during))))


@lru_cache(maxsize=16)
def _watched(plant: Plant, measured: tuple[str, ...]) -> Plant:
    return plant.with_outputs(measured)


def stopped(command: Command, seconds: float) -> Command:
    """Return a command that stops at once after some seconds."""
    profile = command.rate
    kept = [(t, r) for t, r in zip(profile.times_s, profile.rates, strict=True) if t < seconds]
    last = float(np.interp(seconds, profile.times_s, profile.rates))
    first = [] if kept else [(0.0, last)]
    return replace(command, rate=RateProfile.through([*first, *kept, (seconds, last), (seconds, 0.0)]))


def is_stepper(mechanism: Mechanism) -> bool:
    """Whether step loss has a meaning for a mechanism: driven step by step, its rotor's angle known."""
    inputs = {str(s) for s in mechanism.plant.inputs}
    return {"e_A", "e_B"} <= inputs and mechanism.electrical_periods is not None


def pull_in(mechanism: Mechanism, command: Command) -> RateLimit:
    """Return the rates at which the motor starts and stops at once without loss."""

    def holds(rate: float) -> bool:
        return not driven(mechanism, _at(command, rate), RATE.started_s, torque=False).lost

    return rate_limit(holds, rates_tried(mechanism, command))


def pull_out(mechanism: Mechanism, command: Command, started: RateLimit | None = None) -> RateLimit:
    """Return the rates at which the motor follows, once it is brought there slowly.

    It is brought there from rest, or, where the widest range of rates at which it starts at once lies above a hole,
    from the middle of that range: a slow start from rest would dwell in the hole, and what is lost there tells
    nothing of higher rates. At rates of that range it follows, as it starts there at once.

    Parameters
    ----------
    mechanism : Mechanism
    command : Command
    started : RateLimit or None
        Where it starts at once, as `pull_in` found it; None finds it anew.
    """
    started = started or pull_in(mechanism, command)
    first, last = started.widest or (RATE.lowest, RATE.lowest)
    begin = math.sqrt(first * last) if first > RATE.lowest else 0.0
    up, down = RATE.ramp_s + RATE.started_s, 2.0 * RATE.ramp_s + RATE.started_s

    def holds(rate: float) -> bool:
        if begin <= rate < last:
            return True
        slow = RateProfile.through([(0.0, begin), (RATE.ramp_s, rate), (up, rate), (down, begin)])
        return not driven(mechanism, replace(command, rate=slow), down, torque=False).lost

    steps = math.ceil(math.log(RATE.highest / last) / math.log(RATE.slow_ratio))
    rates = [begin or RATE.lowest, *np.geomspace(last, RATE.highest, steps + 1).tolist()]
    return rate_limit(holds, sorted(set(rates)), begin)


def _at(command: Command, rate: float) -> Command:
    return replace(command, rate=RateProfile.constant(rate))


@dataclass(frozen=True)
class Margins:
    """How much a command may change for the worse before steps are lost; None where nothing within reach does it.

    Attributes
    ----------
    lost : bool
        Whether they are lost as it is; then there is no margin.
    voltage : float or None
        Share of the peak voltage that may be missing.
    torque_Nm : float or None
        Further dry friction at the rotor, N m.
    inertia_factor : float or None
        Factor on the load's inertia.
    """

    lost: bool
    voltage: float | None = None
    torque_Nm: float | None = None
    inertia_factor: float | None = None


def margins(mechanism: Mechanism, command: Command, seconds: float) -> Margins:
    """Return the margins of a command, each with the rest as it is, by bisection."""

    def holds(changed: Mechanism) -> bool:
        return not driven(changed, command, seconds, torque=False).lost

    if not holds(mechanism):
        return Margins(True)
    has = mechanism.plant.names_with_role
    supply = torque = inertia = None
    if has(Role.SUPPLY):
        supply = _largest(lambda x: holds(weaker(mechanism, 1.0 - x)), 0.99)
    if has(Role.DRY_FRICTION):
        most = mechanism.scale(HOLDING)
        torque = _largest(lambda x: holds(rubbing(mechanism, x)), most) if most else None
    if has(Role.LOAD_INERTIA):
        found = _largest(lambda x: holds(heavier(mechanism, math.exp(x))), math.log(100.0))
        inertia = math.exp(found) if found is not None else None
    return Margins(False, supply, torque, inertia)


def weaker(mechanism: Mechanism, factor: float) -> Mechanism:
    """Return the mechanism at another supply, voltage or current as its drive has it."""
    return _scaled(mechanism, Role.SUPPLY, factor)


def heavier(mechanism: Mechanism, factor: float) -> Mechanism:
    """Return the mechanism with another load."""
    return _scaled(mechanism, Role.LOAD_INERTIA, factor)


def _scaled(mechanism: Mechanism, role: Role, factor: float) -> Mechanism:
    return mechanism.with_values(
        {name: factor * mechanism.value(name) for name in mechanism.plant.names_with_role(role)}
    )


def rubbing(mechanism: Mechanism, torque: float) -> Mechanism:
    """Return the mechanism with further dry friction at the rotor, N m: a load torque that opposes motion."""
    names = mechanism.plant.names_with_role(Role.DRY_FRICTION)
    return mechanism.with_values({name: mechanism.value(name) + torque for name in names})


def _largest(holds: Callable[[float], bool], most: float) -> float | None:
    """Return the largest change below which all that were tried hold, None where `most` holds too."""
    good, bad = 0.0, most
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
