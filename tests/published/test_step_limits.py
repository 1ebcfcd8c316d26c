"""Rates that a small hybrid stepper followed, in full steps and in eighths.

A motor 28SH32 (0.67 A, 3.8 V, 5.6 ohm, 3.4 mH, 60 mN m holding, 5 mN m detent, 9 g cm2 by its data sheet) on a student
bench (2024): full steps followed at 3000 per second, lost at 3400; eighths followed at 2206 full steps per second and
at rest at 2213. Start procedure, driver and supply are not written down, so the voltage is free, set by the limit of
full steps. Case H of docs/validation.md.
"""

import math
from functools import partial

import numpy as np
import pytest

import mechid
from mechid.command import Command, RateProfile
from mechid.designs.step_loss import drive

pytestmark = pytest.mark.slow
FIRST = 1000.0
"""Rate at which the motor starts, full steps/s: the lowest of the published ones."""
FULL = partial(Command, stepping="full", microsteps=1, start_angle_deg=45.0, waveform="square")
EIGHTHS = partial(Command, stepping="micro", microsteps=8)


def motor(supply, viscous):
    """Return the motor without load, on a given drive."""
    stepper = {
        "poles": 100,
        "rotor_inertia": 9e-7,
        "torque_constant": 0.06 / (math.sqrt(2.0) * 0.67),
        "detent": [{"period_deg": 1.8, "amplitude": 0.005, "phase_deg": 0.0}],
    }
    friction = {"static": 5e-4, "coulomb": 5e-4, "viscous": viscous}
    return mechid.make_mechanism(
        {"assembly": "current_driven_stepper", "stepper": stepper | supply, "friction": friction}
    )


def voltage(volts):
    """Return a plain bridge."""
    return {"drive": "voltage", "peak_voltage": volts, "coil_resistance": 5.6, "coil_inductance": 3.4e-3}


def chopper(volts):
    """Return a chopper that keeps the rated current while a supply suffices."""
    limit = {"voltage": volts, "resistance": 5.6, "inductance": 3.4e-3}
    return {"drive": "current", "peak_current": 0.67, "current_limit": limit}


def switched(volts):
    """Return the same chopper switch by switch: a clock of 30 kHz, and a current that falls with L/R alone."""
    return {**chopper(volts), "chop": {"frequency_hz": 30e3, "decay": "slow"}}


def last_followed(mechanism, command):
    """Return the last of the rates 1000, 1100, ... full steps/s before the first that is lost; 0 for none.

    Each is reached in 1 s from the first, held 0.3 s, and left in 1 s.
    """

    def is_lost(rate):
        profile = RateProfile.through([(0.0, FIRST), (1.0, rate), (1.3, rate), (2.3, FIRST)])
        return drive(mechanism, command(rate=profile), 2.3, torque=False).lost

    rates = np.arange(FIRST, 4001.0, 100.0)
    return next((rate - 100.0 for rate in rates if is_lost(rate)), rates[-1])


def limits(supply, viscous, volts):
    """Return the voltage with which full steps are lost where they were, and the last rates in full and in eighths."""
    for tried in volts:
        found = last_followed(motor(supply(tried), viscous), FULL)
        if found >= 3000.0:
            return tried, found, last_followed(motor(supply(tried), viscous), EIGHTHS)
    raise AssertionError(f"full steps are lost below 3000 with {volts[-1]} V")


@pytest.mark.parametrize(("viscous", "volts"), [(1e-5, range(24, 40)), (1e-4, np.arange(3.0, 5.0, 0.1))])
def test_a_plain_bridge_loses_eighths_before_full_steps(viscous, volts, note):
    """Published: 3000 to 3400 before 2206 to 2213. The motor's damping is not on the data sheet: two values."""
    used, full, eighths = limits(voltage, viscous, volts)
    note(f"28SH32, bridge at {used:.1f} V, {1e6 * viscous:g} uN m s/rad: full {full:g}, eighths {eighths:g} steps/s")
    assert 3000.0 <= full < 3400.0
    assert FIRST < eighths < full


def test_a_chopper_of_slow_decay_loses_eighths_before_full_steps(note):
    """Published: 3000 to 3400 before 2206 to 2213. The driver's decay is not: slow is the usual default."""
    used, full, eighths = limits(switched, 1e-5, np.arange(9.0, 12.0, 0.5))
    note(f"28SH32, chopper with slow decay at {used:.1f} V: full {full:g}, eighths {eighths:g} steps/s")
    assert 3000.0 <= full < 3400.0
    assert FIRST < eighths < full


@pytest.mark.xfail(reason="the average of a chopper follows a falling command at once, which slow decay does not")
def test_the_average_of_a_chopper_loses_eighths_before_full_steps(note):
    """Published: 3000 to 3400 before 2206 to 2213."""
    used, full, eighths = limits(chopper, 1e-5, np.arange(8.0, 12.0, 0.5))
    note(f"28SH32, chopper at {used:.1f} V: full {full:g}, eighths {eighths:g} steps/s")
    assert full < 3400.0
    assert eighths < full
