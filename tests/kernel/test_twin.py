"""The twin itself, against closed forms and laws: it is the truth of the other tests."""

import numpy as np
import pytest

from hand_typed import motor_torque
from paper import RECORDS, constant, indices, mechanism
from runs import base, rms, run_twin

STUCK, FORWARD = 0, 1
NO_DETENTS = {"stepper.detent.0.amplitude": 0.0, "stepper.detent.1.amplitude": 0.0}


def test_a_blocked_rotor_breaks_away_at_the_closed_form_instant():
    """Truth: k_m U/R (1 - exp(-R t/L)) = T_frs after the first full step from 0 deg, and its derivatives."""
    m = mechanism(changes={**NO_DETENTS, "friction.static": 0.05})
    R, L, k_m, U, T_frs = 9.9, 0.045, 0.384, 5.7, 0.05
    share = T_frs * R / (k_m * U)
    t = -L / R * np.log(1 - share)
    slope = L / R / (1 - share) * share
    run = run_twin(m, constant(10.0, start_angle_deg=0.0), base(0.11), sensitive=indices(m, ("R", "L", "k_m", "T_frs")))
    first = run.switching[0]
    assert (first.before, first.after) == (STUCK, FORWARD)
    assert first.time == pytest.approx(0.1 + t, abs=1e-12)
    np.testing.assert_allclose(first.sensitivity, [-t / R + slope / R, t / L, -slope / k_m, slope / T_frs], rtol=1e-8)


def test_a_stuck_rotor_leaves_the_load_swinging_freely():
    """Truth: J_m a'' + D a' + K_s a = 0 in closed form, from the last switch of the record on."""
    m, command = mechanism(None), RECORDS["full_5"]
    run = run_twin(m, command, base(0.4))
    assert run.switching[-1].after == STUCK
    y = run.y[int(run.switching[-1].time * 1e4) + 2 :, 0]
    s = 0.39 / (2 * 0.010534)
    w = np.sqrt(913.47 / 0.010534 - s**2)
    free = 2 * np.exp(-s * 1e-4) * np.cos(w * 1e-4) * y[1:-1] - np.exp(-2 * s * 1e-4) * y[:-2]
    np.testing.assert_allclose(y[2:], free, rtol=0, atol=1e-8 * np.abs(y).max())


def test_the_start_is_stuck_where_friction_holds_and_else_released():
    """Truth: |T_mot| at the commanded angle, typed by hand, against T_frs."""
    q = dict(zip(map(str, mechanism().plant.parameters), mechanism().kernel_values(), strict=True))
    theta = np.deg2rad(45.0)
    x = np.array([-np.cos(theta) * 5.7 / 9.9, np.sin(theta) * 5.7 / 9.9, theta / 50, 0.0, theta / 2500, 0.0])
    held_by = abs(motor_torque(x, q, (4, 2)))
    for static, modes in ((1.01 * held_by, (0,)), (0.99 * held_by, (1, 2))):
        run = run_twin(mechanism(changes={"friction.static": static}), constant(1.0), base(0.0002))
        assert run.end.modes[0] in modes


def test_the_samples_do_not_depend_on_the_tolerance():
    """Truth: convergence. A hundred times tighter changes less than 1e-7 of the record's RMS."""
    m, command = mechanism(), RECORDS["full_46"]
    usual, tight = run_twin(m, command, base(0.1)), run_twin(m, command, base(0.1), tolerance=1e-12)
    assert len(usual.switching) == len(tight.switching) > 5
    assert rms(usual.y - tight.y) <= 1e-7 * rms(tight.y)


def test_a_run_goes_on_from_where_another_ended():
    """Truth: the run in one piece; with sensitivities."""
    m, command, sensitive = mechanism(), RECORDS["full_46"], indices(mechanism(), ("R", "T_frs", "omega_0"))
    whole = run_twin(m, command, base(0.06), sensitive=sensitive)
    first = run_twin(m, command, base(0.03), sensitive=sensitive)
    second = run_twin(m, command, base(0.03, start_s=0.03), sensitive=sensitive, begin=first.end)
    np.testing.assert_allclose(second.y, whole.y[300:], rtol=0, atol=1e-8 * rms(whole.y))
    scale = np.abs(whole.jacobian).max(axis=0)
    np.testing.assert_allclose(second.jacobian / scale, whole.jacobian[300:] / scale, rtol=0, atol=1e-7)


def test_a_jump_within_an_interval_is_its_mean():
    """Truth: at break-away T_res jumps by T_frs - T_frd; samples so dense that this one's interval has no jump."""
    m, command = mechanism(None), RECORDS["full_46"]
    coarse, dense = run_twin(m, command, base(0.03, rate_hz=1e3)), run_twin(m, command, base(0.03, rate_hz=1e5))
    released = coarse.switching[1]
    assert (released.before, released.after) == (STUCK, FORWARD)
    n = int(np.ceil(released.time * 1e3))
    passed = released.time * 1e3 - (n - 1)
    assert coarse.y[n, 0] == pytest.approx(dense.y[100 * n, 0] + (0.008 - 0.0013) * passed, abs=1e-9)


def test_nothing_is_measured_before_the_command_begins():
    """Truth: docs/files.md: before 0 the coils hold theta_0, and the mechanism rests."""
    run = run_twin(mechanism(None), RECORDS["full_46"], base(0.01), offset_s=0.0042)
    assert not run.y[:42].any()
    assert run.y[43:].all()
