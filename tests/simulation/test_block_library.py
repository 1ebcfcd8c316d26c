"""The library's blocks in the kernel: against the slow twin, differences and closed forms; several switches at once.

Truth: the twin, whose equations tests/plant/test_block.py holds against right-hand sides typed by hand.
"""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from scipy.linalg import expm

from layouts import BRUSHED_DC, LAYOUTS, changed, mechanism_of, paper_with
from mechid.command import InputChannel, MeasuredCommand
from mechid.parameter import Declaration, Parameter
from mechid.plant.block import Block
from mechid.plant.drive import measured_drive
from mechid.plant.friction import Site, coulomb
from mechid.plant.mechanism import Mechanism
from mechid.plant.plant import assemble
from paper import constant
from runs import base, rms, run_kernel, run_twin

COMMAND = constant(46.0)
TOGETHER = {
    "backlash between two frictions, by direction": {
        **LAYOUTS["three switches"],
        **LAYOUTS["friction by direction"],
        **LAYOUTS["detent hysteresis"],
    },
    "catalogue gear, flexible load, phases apart": {
        "friction": {"law": "directional", "coulomb": 0.004, "asymmetry": 0.2, "viscous_asymmetry": -0.1},
        **{table: LAYOUTS[name][table] for name, table in (("piecewise_linear", "gear"), ("flexible load", "load"))},
        "stepper": LAYOUTS["imbalance"]["stepper"] | LAYOUTS["torque_harmonic"]["stepper"],
    },
    "load-dependent, kinematic error, test stand": {
        **LAYOUTS["load_dependent"],
        **LAYOUTS["kinematic_error"],
        **LAYOUTS["test stand"],
    },
    "cables, friction and weight on a load": {
        **LAYOUTS["friction position"],
        "load": LAYOUTS["cable"]["load"] | LAYOUTS["unbalance"]["load"],
        **LAYOUTS["output_friction"],
        **LAYOUTS["second mode"],
    },
    "LuGre on a current drive with a table, tooth meshes": {
        **LAYOUTS["lugre"],
        **LAYOUTS["tooth mesh"],
        "stepper": LAYOUTS["current drive"]["stepper"] | LAYOUTS["microstep table"]["stepper"],
    },
}
"""Every block of the library once, in few mechanisms: each is a kernel to compile."""
ALONE = [pytest.param(LAYOUTS[name], id=name, marks=pytest.mark.slow) for name in LAYOUTS if name != "three switches"]
QUICK = ("backlash between two frictions, by direction", "LuGre on a current drive with a table, tooth meshes")
EVERY = [
    *(
        pytest.param(changes, id=name, marks=[] if name in QUICK else [pytest.mark.slow])
        for name, changes in TOGETHER.items()
    ),
    *ALONE,
]


def estimable(m, count=16):
    """Return the places of the last parameters that are estimated: those of blocks behind the motor come last."""
    return [i for i, s in enumerate(m.plant.parameters) if s in m.plant.estimable][-count:]


def events(switching):
    return [(s.switch, s.before, s.after) for s in switching]


@pytest.mark.parametrize("changes", EVERY)
def test_the_kernel_keeps_its_promise(changes, note):
    """Truth: the twin; 1e-5 of the RMS torque, the same switches in the same order.

    An unwound gear transmits nothing, and the sign of this nothing is rounding: what it switches is left out.
    """
    m, time_base = paper_with(changes), base(0.25)
    kernel, twin = run_kernel(m, COMMAND, time_base), run_twin(m, COMMAND, time_base)
    error, size = rms(kernel.torque - twin.y[:, 0]), rms(twin.y)
    note(f"RMS error {error / size:.1e}, {len(twin.switching)} switches")
    assert error <= 1e-5 * size
    found = kernel.switching
    switched = [s for s in twin.switching if s.time > 1e-15]
    assert events(switched) == list(zip(found.switch, found.before, found.after, strict=True))
    np.testing.assert_allclose(found.time, [s.time for s in switched], rtol=0, atol=1e-6)


@pytest.mark.parametrize("changes", EVERY)
def test_sensitivities_are_those_of_the_twin_and_of_differences(changes):
    """Truth: the twin's variational equations to 1e-5 of each RMS; central differences of finer runs, across switches.

    Where a switch passes a sample between the two runs a difference is no derivative: a few samples may be off.
    """
    m, time_base = paper_with(changes), base(0.06)
    chosen = estimable(m)
    kernel = run_kernel(m, COMMAND, time_base, sensitive=chosen, substeps=8).jacobian["torque"]
    twin = run_twin(m, COMMAND, time_base, sensitive=chosen).jacobian[:, 0]
    assert np.all(np.linalg.norm(kernel - twin, axis=0) <= 1e-5 * np.linalg.norm(twin, axis=0))
    p = m.kernel_values()
    for j, i in enumerate(chosen):
        step = np.zeros_like(p)
        step[i] = 1e-5 * (abs(p[i]) or 1e-3)
        up, down = (run_kernel(m, COMMAND, time_base, p=p + way * step, substeps=8).torque for way in (1, -1))
        difference = (up - down) / (2 * step[i])
        off = np.abs(difference - kernel[:, j]) > 1e-4 * np.abs(difference).max()
        assert off.sum() <= 5, m.plant.parameters[i]


@pytest.mark.slow
def test_switches_of_different_blocks_fall_into_one_sample():
    """Truth: the twin, at 1 kHz, where many samples hold several switches."""
    m, time_base = paper_with(LAYOUTS["three switches"]), base(0.25, rate_hz=1e3)
    kernel, twin = run_kernel(m, COMMAND, time_base, substeps=20), run_twin(m, COMMAND, time_base)
    sample = np.ceil(kernel.switching.time * 1e3)
    shared = [len(set(kernel.switching.switch[sample == n])) for n in np.unique(sample)]
    assert max(shared) >= 2
    assert rms(kernel.torque - twin.y[:, 0]) <= 1e-5 * rms(twin.y)


def twins_on_one_torque():
    """Return two equal bodies on equal friction under one torque, and the same body alone."""

    def body(suffix):
        site = Site(table=f"friction{suffix}", suffix=suffix, omega=sp.Symbol(f"omega{suffix}"))
        x, v, J, drive, a = sp.symbols(f"x{suffix} omega{suffix} J{suffix} T_drive{suffix} a{suffix}")
        T, T_fr, free = sp.symbols(f"T_mot_in T_fr{suffix}_in free{suffix}_in")
        inertia = Declaration(key="inertia", symbol=J.name, unit="kg m2", meaning="inertia", lower=0.0)
        mass = Block(
            name=f"body{suffix}",
            table=f"body{suffix}",
            declarations=(inertia,),
            inputs=(T, T_fr, free),
            terms={drive: T, a: free * (drive - T_fr) / J},
            rates={x: v, v: a},
            initial={x: 0, v: 0},
            outputs={f"x{suffix}": x, f"T_drive{suffix}": drive},
        )
        return [mass, coulomb(site)]

    drive = measured_drive((("torque", "T_mot"),), "drive")
    both = assemble(
        "two",
        [drive, *body(""), *body("_b")],
        {},
        {"rotor_angle": "body.x", "output_angle": "body_b.x_b"},
        ("rotor_angle", "output_angle"),
    )
    alone = assemble("one", [drive, *body("")], {}, {"rotor_angle": "body.x"})
    return [Mechanism(plant, _values(plant), {}) for plant in (both, alone)]


def _values(plant):
    named = {"inertia": 1e-3, "static": 0.05, "coulomb": 0.03, "viscous": 2e-3}
    return {
        name: Parameter(name=name, value=named[name.rpartition(".")[2]], declaration=d)
        for name, d in plant.declarations.items()
    }


@pytest.mark.slow
def test_two_switches_at_one_instant_are_both_taken():
    """Truth: the same body alone. Both stick, slip and turn at the very same instants, and do not know one another."""
    both, alone = twins_on_one_torque()
    time_base = base(0.3, rate_hz=1e3)
    torque = 0.1 * np.sin(2 * np.pi * 12.0 * time_base.times)
    command = MeasuredCommand().driven_by((InputChannel(quantity="torque", samples=torque),), 1e3, 0.0)
    pairs, single = (run_kernel(m, command, time_base, sensitive=range(4)) for m in (both, alone))
    assert single.switching.time.size >= 6
    np.testing.assert_allclose(pairs.switching.time, np.repeat(single.switching.time, 2), rtol=0, atol=1e-12)
    x, x_b = pairs.values["rotor_angle"], pairs.values["output_angle"]
    np.testing.assert_allclose(x, single.measured, rtol=0, atol=1e-12 * np.abs(x).max())
    np.testing.assert_allclose(x_b, x, rtol=0, atol=1e-12 * np.abs(x).max())
    for own, expected in zip(pairs.jacobian["rotor_angle"].T, single.jacobian["rotor_angle"].T, strict=True):
        np.testing.assert_allclose(own, expected, rtol=0, atol=1e-9 * np.abs(expected).max())
    np.testing.assert_allclose(pairs.jacobian["output_angle"], 0.0, rtol=0, atol=1e-12 * np.abs(own).max())
    twin = run_twin(both, command, time_base)
    assert rms(twin.y[:, 0] - x) <= 1e-5 * rms(x)


@pytest.mark.slow
def test_an_edge_that_throws_a_stuck_body_releases_it_at_that_instant():
    """Truth: x = (F - T_c)(t - t_0)^2/2J from the edge at t_0 on; static friction moves neither x nor the instant."""
    m = mechanism_of(
        {
            "assembly": "direct_torque_drive",
            "load": {"inertia": 2e-3},
            "drive": {},
            "friction": {"static": 0.05, "coulomb": 0.03, "viscous": 0.0},
        }
    )
    time_base = base(0.1, rate_hz=1e3)
    torque = np.where(time_base.times < 0.0295, 0.02, 0.08)
    command = MeasuredCommand().driven_by((InputChannel(quantity="torque", held=True, samples=torque),), 1e3, 0.0)
    chosen = [list(map(str, m.plant.parameters)).index(name) for name in ("T_frs", "T_frd", "J_rot")]
    since = np.maximum(time_base.times - 0.030, 0.0)
    x = 0.05 * since**2 / 2 / 2e-3
    kernel = run_kernel(m, command, time_base, sensitive=chosen)
    np.testing.assert_allclose(kernel.measured, x, rtol=0, atol=1e-13)
    expected = np.stack([0.0 * x, -(since**2) / 2 / 2e-3, -x / 2e-3], axis=1)
    np.testing.assert_allclose(kernel.jacobian["output_angle"], expected, rtol=0, atol=1e-9)
    assert kernel.switching.time == pytest.approx([0.030], abs=1e-12)
    twin = run_twin(m, command, time_base, sensitive=chosen)
    np.testing.assert_allclose(twin.y[:, 0], x, rtol=0, atol=1e-10)
    np.testing.assert_allclose(twin.jacobian[:, 0], expected, rtol=0, atol=1e-6)


@pytest.mark.slow
def test_a_body_that_begins_in_motion_runs_out():
    """Truth: J w' = -T_v w from w(0) = v: x = v tau (1 - exp(-t/tau)), tau = J/T_v, and dx/dv = x/v."""
    m = mechanism_of(
        {
            "assembly": "direct_torque_drive",
            "load": {"inertia": 2e-3, "start_rate": 3.0},
            "drive": {},
            "friction": {"coulomb": 0.0, "viscous": 0.05},
        }
    )
    time_base = base(0.1, rate_hz=1e3)
    nothing = InputChannel(quantity="torque", samples=np.zeros(time_base.samples))
    command = MeasuredCommand().driven_by((nothing,), 1e3, 0.0)
    chosen = [list(map(str, m.plant.parameters)).index("omega_start")]
    x = 3.0 * 0.04 * -np.expm1(-time_base.times / 0.04)
    kernel = run_kernel(m, command, time_base, sensitive=chosen, substeps=4)
    np.testing.assert_allclose(kernel.measured, x, rtol=0, atol=1e-9)
    np.testing.assert_allclose(kernel.jacobian["output_angle"][:, 0], x / 3.0, rtol=0, atol=1e-9)
    twin = run_twin(m, command, time_base, sensitive=chosen)
    np.testing.assert_allclose(twin.y[:, 0], x, rtol=0, atol=1e-10)
    np.testing.assert_allclose(twin.jacobian[:, 0, 0], x / 3.0, rtol=0, atol=1e-7)


@pytest.mark.slow
def test_a_brushed_motor_answers_a_voltage_as_its_linear_equations():
    """Truth: the matrix exponential of winding, shaft and spring without dry friction; and the twin's sensitivities."""
    table = changed(
        {"assembly": "brushed_dc_drive", **BRUSHED_DC},
        {
            "friction": {"static": 0.0, "coulomb": 0.0, "viscous": 2e-4},
            "spring": {"stiffness": 0.3},
            "drive": {"offset": 0.0},
        },
    )
    m = mechanism_of(table)
    m = replace(m, plant=m.plant.with_outputs(("current", "rotor_rate")))
    time_base = base(0.05)
    voltage = np.where(time_base.times < 0.02, 0.0, 6.0)
    command = MeasuredCommand().driven_by((InputChannel(quantity="voltage", held=True, samples=voltage),), 1e4, 0.0)
    A = np.array([[-2.3 / 1.5e-3, 0.0, -0.045 / 1.5e-3], [0.0, 0.0, 1.0], [0.045 / 4e-5, -0.3 / 4e-5, -2e-4 / 4e-5]])
    settled = np.linalg.solve(A, [-6.0 / 1.5e-3, 0.0, 0.0])
    since = np.maximum(time_base.times - 0.02, 0.0)
    expected = np.array([settled - expm(A * t) @ settled for t in since])
    kernel = run_kernel(m, command, time_base, sensitive=range(5))
    np.testing.assert_allclose(kernel.values["current"], expected[:, 0], rtol=0, atol=1e-6)
    np.testing.assert_allclose(kernel.values["rotor_rate"], expected[:, 2], rtol=0, atol=1e-5)
    twin = run_twin(m, command, time_base, sensitive=range(5))
    for k, quantity in enumerate(("current", "rotor_rate")):
        off = np.linalg.norm(kernel.jacobian[quantity] - twin.jacobian[:, k], axis=0)
        assert np.all(off <= 1e-5 * np.linalg.norm(twin.jacobian[:, k], axis=0))
    resting = MeasuredCommand(start="equilibrium").driven_by(
        (InputChannel(quantity="voltage", held=True, samples=np.full_like(voltage, 6.0)),), 1e4, 0.0
    )
    still = run_kernel(m, resting, time_base)
    np.testing.assert_allclose(still.values["current"], settled[0], rtol=1e-9)
    np.testing.assert_allclose(still.values["rotor_rate"], 0.0, atol=1e-9)
