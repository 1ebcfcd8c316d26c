"""How runs go: resumed block by block, failing without losing their shape, and as accurate as promised."""

from dataclasses import replace

import numpy as np
import pytest

from hand_typed import motor_torque
from kernel_state import places
from layouts import LAYOUTS, changed, mechanism_of, paper_table
from mechid.command import Command, RateProfile, Timing
from mechid.errors import FitError
from mechid.kernel.equilibrium import equilibrium
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run
from mechid.simulation.trajectory import SimulationOutcome
from paper import RECORDS, constant, indices, mechanism
from runs import base, rms, run_kernel, simulator

EXPLOSIVE = {"gear.damping": -2.0}
"""A damper that feeds energy in."""


@pytest.mark.parametrize("sensitive", [False, True])
def test_a_mechanism_that_diverges_is_nan_from_there_on_and_says_so(sensitive):
    """Truth: negative damping; the shape of the arrays stays, and what came before is the same as alone."""
    m, command, time_base = mechanism(changes=EXPLOSIVE), RECORDS["full_46"], base(1.0)
    chosen = indices(m, ("R", "K_s")) if sensitive else ()
    run = run_kernel(m, command, time_base, sensitive=chosen)
    lost = np.flatnonzero(np.isnan(run.torque))
    assert run.outcome is SimulationOutcome.DIVERGED
    assert run.torque.shape == (10001,)
    assert 0 < lost[0] < 10000
    np.testing.assert_array_equal(lost, np.arange(lost[0], 10001))
    before = run_kernel(m, command, time_base.truncate(int(lost[0])), sensitive=chosen)
    assert before.outcome is SimulationOutcome.COMPLETE
    np.testing.assert_array_equal(before.torque, run.torque[: lost[0]])
    if sensitive:
        assert run.jacobian["torque"].shape == (10001, 2)
        assert run.rate["torque"].shape == (10001,)


def test_the_filter_flows_on_through_a_switch_that_comes_at_once():
    """Truth: continuity. A break-away 1e-15 of the way into a step must not touch the housing's state.

    The rotor is stuck at friction's limit but for a part `gap`; the housing swings. Whatever the gap, the next
    sample is the same.
    """
    m, command = mechanism(), constant(1.0)
    q = dict(zip(map(str, m.plant.parameters), m.kernel_values(), strict=True))

    def second_sample(gap):
        run = simulator(m, command, TimeBase(1e4, 2)).run(m.kernel_values())
        at, w = places(run.simulator.kernel), run.buffers.w
        held = -motor_torque(np.zeros(6), q, (4, 2))
        x = [0.0, (q["T_frs"] * (1.0 - gap) + held) / q["k_m"], 0.0, 0.0, 0.0, 0.0]
        w[at["AT_X"] : at["END_X"]], w[at["AT_Z"] : at["END_Z"]] = x, [0.1, 0.0]
        w[at["AT_U"] : at["END_U"]] = [0.0, 1.0]
        run.buffers.discrete[at["MODE"]], run.buffers.discrete[at["ARMED"] :] = 0, 1
        return simulate_run(run).torque[1]

    for gap in (1e-9, 1e-11, 1e-13, 1e-15, -1e-15, -1e-13):
        assert second_sample(gap) == pytest.approx(second_sample(1e-7), abs=1e-8), gap


@pytest.mark.parametrize("static", [0.008, 0.0])
def test_started_at_its_equilibrium_nothing_moves_before_the_first_step(static):
    """Truth: no torque, no motion; and sensitivities of the start itself by differences."""
    m = mechanism(changes={"friction.static": static, "friction.coulomb": static / 2})
    command = Command(
        stepping="full", microsteps=1, rate=RateProfile.constant(20.0), start_angle_deg=45.0, start="equilibrium"
    )
    run = run_kernel(m, command, base(0.2), sensitive=indices(m))
    assert np.abs(run.torque[:500]).max() < 1e-9
    assert rms(run.torque) > 0.01
    for name in ("k_m", "a_2", "R"):
        index, column = indices(m, (name,))[0], indices(m).index(indices(m, (name,))[0])
        p, h = m.kernel_values(), np.zeros(len(m.plant.parameters))
        h[index] = 1e-5 * abs(p[index])
        up, down = (run_kernel(m, command, base(0.2), p=q).torque for q in (p + h, p - h))
        quotient = (up - down) / (2 * h[index])
        J = run.jacobian["torque"][:, column]
        assert np.linalg.norm(J - quotient) <= 1e-4 * np.linalg.norm(quotient), name


def test_a_run_without_equilibrium_is_lost_from_its_first_sample():
    """Truth: a detent of nearly half the holding torque, near whose flank Newton's method goes back and forth."""
    changes = {"stepper.detent.0.amplitude": 0.1, "stepper.detent.0.phase_deg": 50.0, "stepper.detent.1.amplitude": 0.0}
    m, command = mechanism(changes=changes), replace(constant(20.0), start="equilibrium")
    with pytest.raises(FitError, match="no mechanical equilibrium"):
        equilibrium(m.plant, m.kernel_values(), np.array([-1.0, 1.0]) / np.sqrt(2.0), np.pi / 4.0)
    run = Simulator(m.plant, command, base(0.01)).run(m.kernel_values(), timing=Timing(5e-3))
    assert np.isnan(simulate_run(run).torque).all()
    assert run.outcome is SimulationOutcome.NO_EQUILIBRIUM


@pytest.mark.parametrize("drive", ["voltage", pytest.param("current", marks=pytest.mark.slow)])
def test_currents_and_angles_before_the_command_are_those_of_the_start(drive):
    """Truth: u/R and I e at the start angle, the angle theta_0/(p/2); derivatives by differences."""
    table = paper_table()
    if drive == "current":
        table = changed(table, LAYOUTS["current drive"])
    m = mechanism_of(table)
    m = replace(m, plant=m.plant.with_outputs(("torque", "current_phase_a", "rotor_angle")))
    command, peak = constant(46.0, start_angle_deg=30.0), "stepper.peak_current"
    own = "stepper.coil_resistance" if drive == "voltage" else peak
    size = 5.7 / 9.9 if drive == "voltage" else 0.5
    time_base = TimeBase(1e4, 40)
    at = [str(s) for s in m.plant.parameters].index(m.plant.declarations[own].symbol)
    made = Simulator(m.plant, command, time_base, ((at,),), latest_s=2e-3)
    p = m.kernel_values()
    found = simulate_run(made.run(p, timing=Timing(2e-3)))
    np.testing.assert_allclose(found.values["current_phase_a"][:20], -size * np.cos(np.radians(30.0)), rtol=1e-12)
    np.testing.assert_allclose(found.values["rotor_angle"][:20], np.radians(30.0) / 50.0, rtol=1e-12)
    np.testing.assert_array_equal(found.torque[:20], 0.0)
    h = np.zeros(p.size)
    h[at] = 1e-6 * p[at]
    ahead, behind = (simulate_run(made.run(p + s * h, timing=Timing(2e-3))) for s in (1, -1))
    for quantity, J in found.jacobian.items():
        slope = (ahead.values[quantity] - behind.values[quantity]) / (2.0 * h[at])
        np.testing.assert_allclose(J[:20, 0], slope[:20], rtol=1e-6, atol=1e-9)
