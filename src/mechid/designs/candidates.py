"""Candidate records of a design: steppings, rates, start angles, durations, and sweeps."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.command import Command, RateProfile
from mechid.command.stepping import FIXED_MICROSTEPS, STEPPINGS, Stepping
from mechid.designs.planned_record import PlannedRecord
from mechid.designs.settings import DESIGN
from mechid.errors import UsageError
from mechid.plant.load import LOAD_ON_GEAR
from mechid.plant.mechanism import Mechanism
from mechid.simulation.resonances import resonances


@dataclass(frozen=True, kw_only=True)
class CandidateChoice:
    """Values from which candidates are formed; every combination becomes one candidate.

    Parameters
    ----------
    steppings : tuple of {"full", "half", "micro"}
    microsteps : int
    rates : tuple of float
        Full steps/s; empty for 12 rates up to beyond twice the load's resonance on the gear.
    start_angles_deg : tuple of float
        Electrical angles.
    durations_s : tuple of float
        Durations of the records at constant rate.
    sweeps_s : tuple of float
        Durations of sweeps from 0 to `sweep_to`.
    sweep_to : float or None
        Full steps/s; None is the highest of the rates.
    """

    steppings: tuple[Stepping, ...] = STEPPINGS
    microsteps: int = 16
    rates: tuple[float, ...] = ()
    start_angles_deg: tuple[float, ...] = (0.0, 45.0)
    durations_s: tuple[float, ...] = (1.0,)
    sweeps_s: tuple[float, ...] = (5.0, 10.0, 20.0)
    sweep_to: float | None = None


def candidates(choice: CandidateChoice, mechanism: Mechanism, like: PlannedRecord) -> tuple[PlannedRecord, ...]:
    """Return every combination of a choice, with the sampling and noise of the record `like`.

    Those with a step shorter than a pulse of the mechanism's driver are left out.

    Raises
    ------
    UsageError
        None is left.
    """
    rates = choice.rates or usual_rates(mechanism)
    every = [one for one in _combinations(choice, rates, mechanism) if _fits_pulses(one[1])]
    if not every:
        raise UsageError("candidates: every step is shorter than a pulse of the mechanism; write slower rates")
    return tuple(replace(like, name=name, command=c, duration_s=s) for name, c, s in every)


def usual_rates(mechanism: Mechanism) -> tuple[float, ...]:
    """Return rates in full steps/s, evenly spaced on a logarithmic scale, to beyond twice the load's resonance."""
    # Records beyond the load's resonance determine the gear's stiffness and damping; a mechanism without a load has
    # none.
    found = [r.frequency_hz for r in resonances(mechanism) if r.name == LOAD_ON_GEAR]
    highest = DESIGN.above_resonance * found[0] if found else DESIGN.highest_rate
    return tuple(float(f"{rate:.2g}") for rate in np.geomspace(DESIGN.lowest_share * highest, highest, DESIGN.rates))


def _combinations(
    choice: CandidateChoice, rates: Sequence[float], mechanism: Mechanism
) -> Iterator[tuple[str, Command, float]]:
    for stepping in choice.steppings:
        n = FIXED_MICROSTEPS.get(stepping, choice.microsteps)
        for angle in choice.start_angles_deg:
            still = RateProfile.constant(0.0)
            plain = Command(stepping=stepping, microsteps=n, rate=still, start_angle_deg=angle)
            command = mechanism.command_for(plain)
            turned = f"_{_text(angle)}deg" if len(choice.start_angles_deg) > 1 else ""
            for rate in rates:
                driven = replace(command, rate=RateProfile.constant(rate))
                for seconds in choice.durations_s:
                    long = f"_{_text(seconds)}s" if len(choice.durations_s) > 1 else ""
                    yield f"{stepping}_{_text(rate)}{turned}{long}", driven, seconds
            top = choice.sweep_to or max(rates)
            for seconds in choice.sweeps_s:
                swept = replace(command, rate=RateProfile.through([(0.0, 0.0), (seconds, top)]))
                yield f"{stepping}_sweep_{_text(top)}{turned}_{_text(seconds)}s", swept, seconds


def _fits_pulses(command: Command) -> bool:
    """Return whether every step of a command is as long as a pulse."""
    try:
        command.for_motor(command.phases, command.pulse)
    except UsageError:
        return False
    return True


def _text(number: float) -> str:
    """Return a number as part of a file name."""
    return f"{number:g}".replace(".", "p").replace("-", "m").replace("+", "")
