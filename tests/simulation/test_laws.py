"""Laws of nature and exact symmetries that a run must keep."""

import numpy as np
import pytest
from scipy.integrate import simpson

from kernel_state import twin_state
from paper import RECORDS, constant, mechanism
from runs import SUBSTEPS, base, rms, run_kernel, simulator


def states_along(m, command, time_base, substeps=SUBSTEPS):
    """Return the kernel's states at all samples, (n, 8), and their modes, (n,)."""
    run = simulator(m, command, time_base).run(m.kernel_values(), substeps=substeps, block=1)
    rows = [twin_state(run) for _ in run.blocks()]
    return np.array([r.s for r in rows]), np.array([r.modes[0] for r in rows])


def values(m):
    return dict(zip(map(str, m.plant.parameters), m.kernel_values(), strict=True))


def power_lost(s, q):
    """Return what heat takes, in W: copper, friction, the gear's damper."""
    twist_rate = s[:, 3] - q["G"] * s[:, 5]
    friction = q["T_frd"] * np.abs(s[:, 3]) + q["T_visc"] * s[:, 3] ** 2
    return q["R"] * np.sum(s[:, :2] ** 2, axis=1) + friction + q["D"] / q["G"] ** 2 * twist_rate**2


def energy_stored(s, q):
    """Return what coils, inertias, the gear's spring and the detents' potential hold, in J."""
    alpha, twist = s[:, 2], s[:, 2] - q["G"] * s[:, 4]
    potential = np.zeros(len(s))
    for a, b, waves in ((q["a_1"], q["b_1"], 200.0), (q["a_2"], q["b_2"], 100.0)):
        potential += (b * np.sin(waves * alpha) - a * np.cos(waves * alpha)) / waves
    kinetic = q["J_rot"] * s[:, 3] ** 2 + q["J_m"] * s[:, 5] ** 2
    coils = q["L"] * np.sum(s[:, :2] ** 2, axis=1)
    return potential + 0.5 * (coils + kinetic + q["K_s"] / q["G"] ** 2 * twist**2)


def test_energy_is_neither_made_nor_lost(note):
    """Truth: what the source gives is what is lost and what is stored more than before.

    With k_v = k_m what the coils' back-EMF takes is what their torque gives. Steps fall on samples, so that the
    source's power is smooth between them.
    """
    m, command, time_base = mechanism(), constant(50.0), base(0.2)
    q, excitation, per_step = values(m), command.excitation(0.2), 200
    s, modes = states_along(m, command, time_base)
    drawn = 0.0
    for k, e in enumerate([excitation.initial, *excitation.values[:-1]]):
        rows = slice(k * per_step, (k + 1) * per_step + 1)
        drawn += simpson(q["U"] * s[rows, :2] @ e, dx=1e-4)
    lost, stored = simpson(power_lost(s, q), dx=1e-4), energy_stored(s, q)
    copper = simpson(q["R"] * np.sum(s[:, :2] ** 2, axis=1), dx=1e-4)
    missing = drawn - lost - (stored[-1] - stored[0])
    note(f"{missing:.1e} J are missing of {drawn - copper:.1e} J that reached the mechanics")
    assert len(set(modes.tolist())) > 1
    assert abs(missing) <= 1e-5 * abs(drawn - copper)


@pytest.mark.parametrize("name", ["full_5", "full_46", "micro_46"])
def test_the_base_takes_what_the_mechanism_s_momentum_loses(name):
    """Truth: action = reaction. With a rigid housing the integral of y is minus J_rot omega + J_m omega_gear.

    Sums over samples at two rates are extrapolated; a sample is a jump's mean, so that the sums are exact there.
    """
    m, command, duration_s = mechanism(None), RECORDS[name], 0.25
    sums = {}
    for rate_hz in (10_000.0, 20_000.0):
        torque = run_kernel(m, command, base(duration_s, rate_hz=rate_hz)).torque
        sums[rate_hz] = (np.cumsum(torque) - torque[0])[:: round(rate_hz / 10_000)] / rate_hz
    impulse = 2 * sums[20_000.0] - sums[10_000.0]
    s, _ = states_along(m, command, base(duration_s))
    momentum = 8.9e-6 * s[:, 3] + 0.010534 * s[:, 5]
    assert np.abs(impulse + momentum).max() <= 1e-4 * np.abs(momentum).max()


def test_a_stuck_rotor_stands_still():
    """Truth: a stuck rotor's speed is zero, exactly."""
    s, modes = states_along(mechanism(), RECORDS["full_5"], base(0.5))
    assert np.count_nonzero(modes == 0) > 100
    assert not s[modes == 0, 3].any()


@pytest.mark.parametrize("housing", ["paper", None])
def test_the_mirrored_mechanism_exerts_the_opposite(housing):
    """Truth: an exact ambiguity of the equations: all signs reversed with phi -> -phi."""
    mirrored = {"stepper.detent.0.phase_deg": -35.0, "stepper.detent.1.phase_deg": 110.0}
    one = run_kernel(mechanism(housing), constant(46.0), base(0.3)).torque
    other = run_kernel(mechanism(housing, changes=mirrored), constant(-46.0, start_angle_deg=-45.0), base(0.3)).torque
    np.testing.assert_allclose(other, -one, rtol=0, atol=1e-9 * rms(one))


def test_turning_the_frame_with_the_detents_changes_nothing():
    """Truth: an exact ambiguity of the equations: theta_0 + delta with phi_1 - 4 delta, phi_2 - 2 delta."""
    delta = 20.0
    turned = {"stepper.detent.0.phase_deg": 35.0 - 4 * delta, "stepper.detent.1.phase_deg": -110.0 - 2 * delta}
    one = run_kernel(mechanism(), constant(46.0), base(0.3)).torque
    other = run_kernel(mechanism(changes=turned), constant(46.0, start_angle_deg=45.0 + delta), base(0.3)).torque
    np.testing.assert_allclose(other, one, rtol=0, atol=1e-8 * rms(one))


def test_voltage_cannot_be_told_from_the_coils():
    """Truth: the equations themselves: U -> c U, k_m -> c k_m, R, L -> c^2 changes nothing."""
    c = 1.3
    scaled = {
        "stepper.peak_voltage": 5.7 * c,
        "stepper.torque_constant": 0.384 * c,
        "stepper.back_emf_constant": 0.384 * c,
        "stepper.coil_resistance": 9.9 * c**2,
        "stepper.coil_inductance": 0.045 * c**2,
    }
    one = run_kernel(mechanism(), constant(46.0), base(0.3)).torque
    other = run_kernel(mechanism(changes=scaled), constant(46.0), base(0.3)).torque
    np.testing.assert_allclose(other, one, rtol=0, atol=1e-9 * rms(one))


def test_a_gear_that_reverses_turns_the_load_the_other_way():
    """Truth: G -> -G reverses T_applied and leaves T_res; with a rigid housing y = -(T_res + T_applied)."""
    m, reversed_m = (mechanism(None, changes={"gear.ratio": G}) for G in (50.0, -50.0))
    one, other = (run_kernel(each, constant(46.0), base(0.1)) for each in (m, reversed_m))
    (s, _), q = states_along(m, constant(46.0), base(0.1)), values(m)
    T_applied = q["K_s"] / 50 * (s[:, 2] - 50 * s[:, 4]) + q["D"] / 50 * (s[:, 3] - 50 * s[:, 5])
    clear = np.ones(s.shape[0], dtype=bool)
    clear[np.ceil(one.switching.time * 1e4).astype(int)] = False
    np.testing.assert_allclose((other.torque - one.torque)[clear], 2 * T_applied[clear], rtol=0, atol=1e-9)
