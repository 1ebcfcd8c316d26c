"""Step loss against closed forms of the two-phase motor on a voltage source, and against laws."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from mechid.campaign import catalogue_mechanism
from mechid.command import RateProfile
from mechid.designs.step_loss import (
    add_friction,
    drive,
    margins,
    pull_in,
    pull_out,
    scale_load,
    scale_supply,
    stop_after,
)
from paper import constant

NO_DETENT = {"stepper.detent.0.amplitude": 0.0, "stepper.detent.1.amplitude": 0.0}
MICRO = constant(0.0, microsteps=16, start_angle_deg=0.0)


def smooth(**changes):
    """Return the catalogue's mechanism without detents."""
    names = {"coulomb": "friction.coulomb", "static": "friction.static", "U": "stepper.peak_voltage"}
    return catalogue_mechanism().with_values({**NO_DETENT, **{names[k]: v for k, v in changes.items()}})


def largest_torque(mechanism, rate):
    """Return what a motor gives at most at a steady rate over its friction, N m.

    Both phases as one phasor in the rotor's frame, i = (U e^(j delta) - k omega) / (R + j p/2 omega L), torque k Re i;
    largest over the load angle delta: k U / Z - k^2 omega R / Z^2 (Acarnley, Stepping Motors, chapter 5).
    """
    k, U, R, L = (
        mechanism.value(f"stepper.{n}")
        for n in ("torque_constant", "peak_voltage", "coil_resistance", "coil_inductance")
    )
    omega = math.radians(1.8) * rate
    Z = math.hypot(R, 50.0 * omega * L)
    drag = mechanism.value("friction.coulomb") + mechanism.value("friction.viscous") * omega
    return k * U / Z - k**2 * omega * R / Z**2 - drag


@pytest.mark.parametrize("voltage", [3.4, 5.7, 8.0])
def test_the_pull_out_rate_is_where_the_torque_of_the_phasors_ends(voltage):
    """Truth: closed form. Microsteps are no pure sine and the resolution is half a percent: 2 %."""
    mechanism = smooth(U=voltage)
    expected = brentq(lambda rate: largest_torque(mechanism, rate), 10.0, 4000.0)
    assert pull_out(mechanism, MICRO).rate == pytest.approx(expected, rel=0.02)


def test_what_friction_a_slow_motor_bears_is_its_holding_torque():
    """Truth: k_m U / R less the friction that is there, to the resolution of half a percent of it, twice."""
    mechanism = smooth(coulomb=0.02, static=0.02)
    k_m, U, R = (mechanism.value(f"stepper.{n}") for n in ("torque_constant", "peak_voltage", "coil_resistance"))
    found = margins(mechanism, constant(2.0, microsteps=64, start_angle_deg=0.0), 4.0)
    assert found.torque_Nm == pytest.approx(k_m * U / R - 0.02, abs=0.01 * k_m * U / R)
    assert found.voltage == pytest.approx(1.0 - 0.02 * R / (k_m * U), abs=0.01)


@pytest.mark.slow
def test_a_rotor_that_friction_holds_loses_every_step():
    """Truth: 40 full steps commanded, none made: ten pole pairs behind."""
    stuck = smooth(static=0.5, coulomb=0.4)
    assert drive(stuck, constant(40.0), 1.0).pole_pairs_lost == -10


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_slow_command_loses_nothing_and_a_sudden_fast_one_falls_behind(sign):
    """Truth: the sign of the loss is against the command's direction."""
    mechanism = catalogue_mechanism()
    assert not drive(mechanism, constant(sign * 46.0), 1.0).lost
    assert sign * drive(mechanism, constant(sign * 1500.0), 1.0).pole_pairs_lost < 0


@pytest.mark.slow
def test_limits_move_as_physics_has_it():
    """Truth: what starts at once also follows slowly; inertia, friction, a lower voltage lower the start-stop rate."""
    mechanism, full = catalogue_mechanism(), constant(0.0)
    limit = pull_in(mechanism, full).rate
    assert limit < pull_out(mechanism, full).rate
    for worse in (scale_load(mechanism, 4.0), add_friction(mechanism, 0.03), scale_supply(mechanism, 0.7)):
        assert pull_in(worse, full).rate < 0.95 * limit
    assert not drive(mechanism, constant(0.98 * limit), 0.5).lost
    assert drive(mechanism, constant(1.02 * limit), 0.5).lost


def test_margins_end_where_steps_are_lost():
    """Truth: by the definition, simulated just within and just beyond each margin."""
    mechanism, command = catalogue_mechanism(), constant(92.0)
    found = margins(mechanism, command, 0.5)
    assert not found.lost
    for change, within, beyond in (
        (scale_supply, 1.0 - found.voltage + 0.002, 1.0 - found.voltage - 0.012),
        (add_friction, found.torque_Nm - 1e-4, found.torque_Nm + 0.012 * 0.166),
    ):
        assert not drive(change(mechanism, within), command, 0.5).lost
        assert drive(change(mechanism, beyond), command, 0.5).lost
    assert margins(mechanism, constant(1500.0), 0.5).lost


@pytest.mark.parametrize(
    ("profile", "seconds"),
    [([(0.0, 46.0)], 0.5), ([(0.0, 0.0), (2.0, 100.0)], 1.0), ([(0.0, 0.0), (0.5, 100.0)], 1.0)],
)
def test_a_command_stopped_is_as_it_was_until_then(profile, seconds):
    """Truth: the edges of the command itself up to that instant, and none after."""
    command = replace(constant(1.0), rate=RateProfile.through(profile))
    held = stop_after(command, seconds)
    before, after = command.excitation(seconds).times, held.excitation(seconds + 1.0).times
    np.testing.assert_allclose(after, before[before <= seconds], rtol=1e-12)
