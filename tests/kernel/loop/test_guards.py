"""Which guard fires, and when. Truth: closed forms of the instant, and the law of friction."""

import numpy as np
import pytest

from hand_typed import motor_torque
from mechid.command import Command, RateProfile
from mechid.simulation.trajectory import SimulationOutcome
from paper import constant, indices, mechanism
from runs import base, rms, run_kernel


def test_a_free_rotor_at_rest_goes_where_it_will_be_pulled():
    """Truth: one push, one direction. Where no torque acts at the instant of an edge, neither way is right yet."""
    m = mechanism(changes={"friction.static": 0.0, "friction.coulomb": 0.0})
    command = Command(
        stepping="full", microsteps=1, rate=RateProfile.constant(20.0), start_angle_deg=45.0, start="equilibrium"
    )
    [R] = indices(m, ("R",))
    for k in range(30):
        p = m.kernel_values()
        p[R] -= k * 1e-6 * p[R]
        run = run_kernel(m, command, base(0.08), p=p)
        assert run.outcome is SimulationOutcome.COMPLETE
        assert len(run.switching.time) <= 1
        assert run.torque[700] != 0.0


def test_many_switches_before_a_record_begins_are_no_chatter():
    """Truth: the record from the start. A rotor without friction swings through rest a hundred times."""
    no_friction = {"friction.static": 0.0, "friction.coulomb": 0.0, "friction.viscous": 1e-5}
    m = mechanism(changes={**no_friction, "gear.damping": 0.01})
    hold = Command(stepping="full", microsteps=1, rate=RateProfile.through([(0.0, 20.0), (0.06, 20.0), (0.06, 0.0)]))
    whole = run_kernel(m, hold, base(2.0))
    assert whole.switching.time.size > 100
    late = run_kernel(m, hold, base(0.5, start_s=1.5))
    assert late.outcome is SimulationOutcome.COMPLETE
    assert rms(late.torque - whole.torque[15000:]) <= 1e-4 * rms(whole.torque)


STUCK, FORWARD, BACKWARD = 0, 1, 2
NO_DETENTS = {"stepper.detent.0.amplitude": 0.0, "stepper.detent.1.amplitude": 0.0}


def parameters(m):
    return dict(zip(map(str, m.plant.parameters), m.kernel_values(), strict=True))


@pytest.mark.parametrize(("static", "held"), [(0.008, False), (0.05, True)])
def test_detents_release_the_rotor_at_the_start_unless_friction_holds_it(static, held):
    """Truth: |T_mot| at the commanded angle against T_frs, and then y = -(T_mot -+ T_frd), typed by hand."""
    m = mechanism(None, changes={"friction.static": static})
    command, q = constant(5.0), parameters(m)
    theta = command.start_angle_rad
    x = np.array([-np.cos(theta), np.sin(theta), 0, 0, 0, 0]) * q["U"] / q["R"]
    x[2], x[4] = theta / 50, theta / 50 / 50
    drive = motor_torque(x, q, (4, 2))
    assert bool(abs(drive) <= static) == held
    y = run_kernel(m, command, base(0.1)).torque
    assert y[0] == pytest.approx(0.0 if held else -(drive - np.sign(drive) * q["T_frd"]), abs=1e-15)
    assert (np.abs(y[1:]).max() < 1e-15) == held


def test_a_blocked_rotor_breaks_away_at_the_closed_form_instant():
    """Truth: i_B = U/R (1 - exp(-R t/L)) after the first full step from 0 deg, so that k_m i_B = T_frs at

    t = -(L/R) ln(1 - T_frs R / (k_m U)), and its derivatives to R, L, k_m, T_frs.
    """
    m = mechanism(changes={**NO_DETENTS, "friction.static": 0.05})
    sensitive = indices(m, ("R", "L", "k_m", "T_frs"))
    run = run_kernel(m, constant(10.0, start_angle_deg=0.0), base(0.2), substeps=32, sensitive=sensitive)
    R, L, k_m, U, T_frs = 9.9, 0.045, 0.384, 5.7, 0.05
    share = T_frs * R / (k_m * U)
    t = -L / R * np.log(1 - share)
    slope = L / R / (1 - share) * share
    expected = [-t / R + slope / R, t / L, -slope / k_m, slope / T_frs]
    assert run.switching.time[0] == pytest.approx(0.1 + t, abs=1e-11)
    assert (run.switching.before[0], run.switching.after[0]) == (STUCK, FORWARD)
    np.testing.assert_allclose(run.switching.sensitivity[0], expected, rtol=1e-7)
    assert np.abs(run.torque[: int((0.1 + t) * 1e4)]).max() < 1e-15
