"""Sticking and slipping: the situations of set-valued friction, each against a closed form or a law."""

import numpy as np
import pytest

from hand_typed import gear_torque, motor_torque, right_hand_side
from mechid.simulation.simulator import TimeBase
from mechid.simulation.trajectory import SimulationOutcome
from paper import ESTIMATED, RECORDS, constant, mechanism
from runs import base, rms, run_kernel, run_twin, state_after

STUCK, FORWARD, BACKWARD = 0, 1, 2
MODE_NAMES = ("stuck", "forward", "backward")
NO_DETENTS = {"stepper.detent.0.amplitude": 0.0, "stepper.detent.1.amplitude": 0.0}


def parameters(m):
    return dict(zip(map(str, m.plant.parameters), m.kernel_values(), strict=True))


def drive_of(s, q):
    """Return T_mot - T_rg, what friction has to hold, typed by hand."""
    return motor_torque(s[:6], q, (4, 2)) - gear_torque(s[:6], q)


def state_at(m, command, time, substep_s=2e-6):
    """Return the kernel's state at one instant, by a record of two samples that ends there."""
    steps = max(1, int(np.ceil(time / substep_s)))
    return state_after(m, command, TimeBase(1.0 / time, 2), substeps=steps).s


def test_friction_above_every_torque_holds_for_ever():
    """Truth: a rotor that never moves exerts nothing (but what rounding winds up in the gear)."""
    m = mechanism(changes={"friction.static": 1.0})
    run = run_kernel(m, RECORDS["full_46"], base(0.3))
    assert np.abs(run.torque).max() < 1e-15
    assert run.switching.time.size == 0


def test_a_stuck_rotor_leaves_the_load_swinging_freely():
    """Truth: J_m a'' + D a' + K_s a = 0, whose samples obey y_n+1 = 2 e^(-s h) cos(w h) y_n - e^(-2 s h) y_n-1."""
    m, command = mechanism(None), RECORDS["full_5"]
    run = run_kernel(m, command, base(1.0))
    last = run.switching.time[-1]
    assert run.switching.after[-1] == STUCK
    y = run.torque[int(last * 1e4) + 2 :]
    J_m, D, K_s, h = 0.010534, 0.39, 913.47, 1e-4
    s = D / (2 * J_m)
    w = np.sqrt(K_s / J_m - s**2)
    free = 2 * np.exp(-s * h) * np.cos(w * h) * y[1:-1] - np.exp(-2 * s * h) * y[:-2]
    assert y.size > 1000
    np.testing.assert_allclose(y[2:], free, rtol=0, atol=1e-9 * np.abs(y).max())


LAWFUL = {
    "full_5": ({}, constant(5.0)),
    "full_46": ({}, constant(46.0)),
    "static is coulomb": ({"friction.coulomb": 0.008}, constant(46.0)),
    "little friction": ({"friction.static": 1e-3, "friction.coulomb": 8e-4}, constant(20.0)),
    "little friction, mirrored": (
        {"friction.static": 1e-3, "friction.coulomb": 8e-4}
        | {"stepper.detent.0.phase_deg": -35.0, "stepper.detent.1.phase_deg": 110.0},
        constant(-20.0, start_angle_deg=-45.0),
    ),
    "much friction": ({"friction.static": 0.05, "friction.coulomb": 0.03}, constant(20.0)),
}


@pytest.mark.parametrize("case", LAWFUL)
def test_every_switch_obeys_the_law_of_friction(case):
    """Truth: the paper's friction. Break-away: |T_mot - T_rg| = T_frs; sliding ends at rest, sticks where it holds

    and else goes on the other way.
    """
    changes, command = LAWFUL[case]
    m = mechanism(changes=changes)
    q, switching = parameters(m), run_kernel(m, command, base(0.5), substeps=50).switching
    assert switching.time.size >= 2
    for time, before, after in zip(switching.time, switching.before, switching.after, strict=True):
        s = state_at(m, command, time)
        drive = drive_of(s, q)
        if before == STUCK:
            assert abs(drive) == pytest.approx(q["T_frs"], rel=1e-6)
            assert after == (FORWARD if drive > 0 else BACKWARD)
        else:
            assert abs(s[3]) < 1e-5 * ESTIMATED["gear.ratio"]
            assert after != before
            assert after == (STUCK if abs(drive) <= q["T_frs"] else FORWARD if drive > 0 else BACKWARD)


def test_the_cases_above_hold_every_kind_of_switch():
    """Truth: a count; else the law would be tested on nothing."""
    kinds = set()
    for changes, command in LAWFUL.values():
        run = run_kernel(mechanism(changes=changes), command, base(0.5)).switching
        kinds |= set(zip(run.before.tolist(), run.after.tolist(), strict=True))
    assert kinds >= {(STUCK, FORWARD), (FORWARD, STUCK), (BACKWARD, STUCK), (FORWARD, BACKWARD), (BACKWARD, FORWARD)}


@pytest.mark.parametrize("case", ["static is coulomb", "little friction", "much friction"])
def test_other_friction_agrees_with_the_twin(case):
    """Truth: the twin."""
    changes, command = LAWFUL[case]
    m = mechanism(changes=changes)
    kernel, twin = run_kernel(m, command, base(0.3)), run_twin(m, command, base(0.3))
    assert rms(kernel.torque - twin.y[:, 0]) <= 1e-5 * rms(twin.y)
    assert kernel.switching.after.tolist() == [s.after for s in twin.switching]


def test_switches_within_one_sample_are_averaged_over_its_interval():
    """Truth: y(t_n) less what each jump, typed by hand on either side, has too much of its mean."""
    m, command = mechanism(None), RECORDS["full_46"]
    q, h = parameters(m), 0.01
    time_base = TimeBase(1.0 / h, 31)
    run = run_kernel(m, command, time_base, substeps=200)
    expected = np.array([0.0, *(torque(m, command, t, 0, q, run.switching) for t in time_base.times[1:])])
    for k, time in enumerate(run.switching.time):
        n = int(np.ceil(time / h))
        jump = torque(m, command, time, 1, q, run.switching, k) - torque(m, command, time, 0, q, run.switching, k)
        expected[n] -= jump * (time - (n - 1) * h) / h
    per_sample = np.bincount(np.ceil(run.switching.time / h).astype(int))
    assert per_sample.max() >= 2
    np.testing.assert_allclose(run.torque[1:], expected[1:], rtol=0, atol=1e-6 * np.abs(expected).max())


def torque(m, command, time, side, q, switching, k=None):
    """Return y at an instant, typed by hand, in the mode before or after switch k, or else in the mode there."""
    e = command.excitation(1.0)
    inputs = e.values[np.searchsorted(e.times, time) - 1] if time > e.times[0] else e.initial
    if k is None:
        k = int(np.searchsorted(switching.time, time))
        mode = switching.before[k] if k < switching.time.size else switching.after[-1]
    else:
        mode = (switching.before, switching.after)[side][k]
    return right_hand_side(state_at(m, command, time)[:6], (), inputs, MODE_NAMES[mode], q, None, (4, 2))[2]


def test_a_record_that_begins_late_is_the_rest_of_one_that_began_in_time():
    """Truth: the same mechanism under the same command; what jumped before the first sample's interval is past."""
    m, command = mechanism(None), RECORDS["full_46"]
    late, whole = run_kernel(m, command, base(0.05, start_s=0.03)), run_kernel(m, command, base(0.08))
    np.testing.assert_allclose(late.torque, whole.torque[300:], rtol=0, atol=1e-5 * rms(whole.torque))


def test_without_friction_and_torque_nothing_moves_and_then_all_moves():
    """Truth: the twin; and the rest before the first step, where friction's two limits and the torque are all zero."""
    m = mechanism(changes={**NO_DETENTS, "friction.static": 0.0, "friction.coulomb": 0.0})
    command = constant(10.0, start_angle_deg=0.0)
    run, twin = run_kernel(m, command, base(0.3)), run_twin(m, command, base(0.3))
    assert run.outcome is SimulationOutcome.COMPLETE
    assert np.abs(run.torque[:1000]).max() < 1e-15
    assert rms(run.torque - twin.y[:, 0]) <= 1e-5 * rms(twin.y)
