"""Campaigns in which one record, or all, was not recorded as it is declared."""

from dataclasses import replace

import numpy as np

from mechid.command import RateProfile
from synthetic import (
    COMMANDS,
    campaign,
    displaced,
    measured,
    record,
    truth,
)

FACTORS = {"gear.stiffness": 1.25, "gear.damping": 0.6, "stepper.torque_constant": 0.9}


NAMES = ("full_46", "full_23", "micro_46")


SECONDS = 0.15


def backward(command):
    """Return a command with its rate of the other sign."""
    return replace(command, rate=RateProfile.constant(-command.rate.rates[0]))


def turned(command, turn_deg):
    """Return a command from another start angle."""
    return replace(command, start_angle_deg=command.start_angle_deg + turn_deg)


def half_steps(command):
    """Return a command in half steps at the same rate."""
    return replace(command, stepping="half", microsteps=2)


def made(
    odd=None,
    *,
    names=NAMES,
    start=None,
    driven=lambda c: c,
    polarity=1.0,
    late_s=0.0,
    by=None,
    sensed=lambda y: y,
    seed=61,
):
    """Return a campaign whose record `odd` (or all, where that is "all") was not made as it is declared."""
    rng = np.random.default_rng(seed)
    records = []
    for name in names:
        is_odd = odd in (name, "all")
        command = driven(COMMANDS[name]) if is_odd else COMMANDS[name]
        maker = by if is_odd and by else truth()
        y = measured(maker, command, rng, seconds=SECONDS, time_offset_s=late_s if is_odd else 0.0)
        records.append(record(name, sensed(polarity * y) if is_odd else y, COMMANDS[name]))
    return campaign(start or displaced(truth(), FACTORS), *records)


def bending(y):
    """Return what a transducer gives that comes to 0.8 of the largest torque at most."""
    most = 0.8 * np.abs(y).max()
    return most * np.tanh(y / most)
