"""Laws of nature and exact symmetries that a run must keep."""

import numpy as np
import pytest
from kernel_state import twin_state
from paper import RECORDS, constant, mechanism
from runs import SUBSTEPS, base, rms, run_kernel, simulator
from scipy.integrate import simpson


def states_along(m, command, time_base, substeps=SUBSTEPS):
    """Return the kernel's states at all samples, (n, 8), and their modes, (n,)."""
    run = simulator(m, command, time_base).run(m.kernel_values(), substeps=substeps, block=1)
    rows = [twin_state(run) for _ in run.blocks()]
    return np.array([r.s for r in rows]), np.array([r.modes[0] for r in rows])


def test_energy_is_neither_made_nor_lost():
    """Truth: electrical input = copper loss + friction + gear damping + what is stored.

    Stored: coils L i^2/2, both inertias, the gear's spring, the detents' potential. With k_v = k_m what the
    coils' back-EMF takes is what their torque gives. Edges lie on samples, so that the powers are smooth between.
    """
    m, command, time_base = mechanism(), constant(50.0), base(0.2)
    q = dict(zip(map(str, m.plant.parameters), m.kernel_values(), strict=True))
    s, _ = states_along(m, command, time_base)
    i, alpha, omega, alpha_gear, omega_gear = s[:, :2], s[:, 2], s[:, 3], s[:, 4], s[:, 5]
    twist, twist_rate = alpha - q["G"] * alpha_gear, omega - q["G"] * omega_gear
    excitation, per_step = command.excitation(0.2), 200
    drawn = 0.0
    for k, e in enumerate([excitation.initial, *excitation.values[:-1]]):
        rows = slice(k * per_step, (k + 1) * per_step + 1)
        drawn += simpson(q["U"] * i[rows] @ e, dx=1e-4)
    lost = simpson(
        q["R"] * np.sum(i**2, axis=1)
        + q["T_frd"] * np.abs(omega)
        + q["T_visc"] * omega**2
        + q["D"] / q["G"] ** 2 * twist_rate**2,
        dx=1e-4,
    )
    potential = sum(
        -np.hypot(q[f"a_{k}"], q[f"b_{k}"]) / (order * 50) * np.cos(order * 50 * alpha + np.arctan2(q[f"b_{k}"], q[f"a_{k}"]))
        for k, order in ((1, 4), (2, 2))
    )
    stored = potential + 0.5 * (
        q["L"] * np.sum(i**2, axis=1)
        + q["J_rot"] * omega**2
        + q["J_m"] * omega_gear**2
        + q["K_s"] / q["G"] ** 2 * twist**2
    )
    exchanged = drawn - simpson(q["R"] * np.sum(i**2, axis=1), dx=1e-4)
    assert abs(drawn - lost - (stored[-1] - stored[0])) <= 1e-5 * abs(exchanged)


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
    """Truth: an exact ambiguity of DESIGN 1: all signs reversed with phi -> -phi."""
    mirrored = {"stepper.detent.0.phase_deg": -35.0, "stepper.detent.1.phase_deg": 110.0}
    one = run_kernel(mechanism(housing), constant(46.0), base(0.3)).torque
    other = run_kernel(mechanism(housing, changes=mirrored), constant(-46.0, start_angle_deg=-45.0), base(0.3)).torque
    np.testing.assert_allclose(other, -one, rtol=0, atol=1e-9 * rms(one))


def test_turning_the_frame_with_the_detents_changes_nothing():
    """Truth: an exact ambiguity of DESIGN 1: theta_0 + delta with phi_1 - 4 delta, phi_2 - 2 delta."""
    delta = 20.0
    turned = {"stepper.detent.0.phase_deg": 35.0 - 4 * delta, "stepper.detent.1.phase_deg": -110.0 - 2 * delta}
    one = run_kernel(mechanism(), constant(46.0), base(0.3)).torque
    other = run_kernel(mechanism(changes=turned), constant(46.0, start_angle_deg=45.0 + delta), base(0.3)).torque
    np.testing.assert_allclose(other, one, rtol=0, atol=1e-8 * rms(one))


def test_voltage_cannot_be_told_from_the_coils():
    """Truth: DESIGN 1: U -> c U, k_m -> c k_m, R, L -> c^2 changes nothing."""
    c = 1.3
    scaled = {
        "stepper.peak_voltage": 5.7 * c, "stepper.torque_constant": 0.384 * c, "stepper.back_emf_constant": 0.384 * c,
        "stepper.coil_resistance": 9.9 * c**2, "stepper.coil_inductance": 0.045 * c**2,
    }  # fmt: skip
    one = run_kernel(mechanism(), constant(46.0), base(0.3)).torque
    other = run_kernel(mechanism(changes=scaled), constant(46.0), base(0.3)).torque
    np.testing.assert_allclose(other, one, rtol=0, atol=1e-9 * rms(one))


def test_a_gear_that_reverses_turns_the_load_the_other_way():
    """Truth: G -> -G reverses T_applied and leaves T_res; with a rigid housing y = -(T_res + T_applied)."""
    one, other = (run_kernel(mechanism(None, changes={"gear.ratio": G}), constant(46.0), base(0.1)) for G in (50.0, -50.0))
    s, modes = states_along(mechanism(None), constant(46.0), base(0.1))
    q = dict(zip(map(str, mechanism(None).plant.parameters), mechanism(None).kernel_values(), strict=True))
    T_applied = q["K_s"] / 50 * (s[:, 2] - 50 * s[:, 4]) + q["D"] / 50 * (s[:, 3] - 50 * s[:, 5])
    clear = np.ones(s.shape[0], dtype=bool)
    clear[np.ceil(one.switching.time * 1e4).astype(int)] = False
    np.testing.assert_allclose((other.torque - one.torque)[clear], 2 * T_applied[clear], rtol=0, atol=1e-9)
