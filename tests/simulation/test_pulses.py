"""A drive in pulses. Truth: exponentials of a coil, the twin, central differences, the balance of energy, ngspice."""

import shutil
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from foreign import pulsed_drive
from layouts import changed, mechanism_of, paper_with
from mechid.command import Command, RateProfile
from runs import base, rms, run_kernel, run_twin

OPEN = {"on_s": 0.008, "clamp_V": 1.5, "diode_drop_V": 0.3}
MOTORS = {
    "held": ({"between": "held", "on_s": 0.008, "hold": 0.3}, 2),
    "open": (OPEN, 2),
    "open halves": (OPEN, 4),
    "open halves, both ways": ({"between": "open_both_ways", **OPEN}, 4),
}
OUTPUTS = ("torque", "current_phase_a", "voltage_phase_a", "rotor_angle", "rotor_rate")
HELD_FAST = {"friction": {"static": 50.0, "coulomb": 50.0}}
"""Friction that nothing moves."""


def motor(name, changes=None, outputs=OUTPUTS):
    """Return the paper's mechanism on a rigid housing with a pulsed drive, and its command."""
    own, phases = MOTORS[name]
    table = {"housing": None, "stepper": {"pulses": own, "phases": phases}}
    m = paper_with(changed(table, changes or {}))
    angle, waveform = (45.0, "cosine") if phases == 2 else (0.0, "square")
    plain = Command(
        stepping="full", microsteps=1, rate=RateProfile.constant(46.0), start_angle_deg=angle, waveform=waveform
    )
    return replace(m, plant=m.plant.with_outputs(outputs)), m.command_for(plain)


@pytest.mark.parametrize("name", [pytest.param(n, marks=[] if n == "open" else pytest.mark.slow) for n in MOTORS])
def test_kernel_and_derivatives_are_those_of_the_twin(name):
    """Truth: the slow twin and its variational equations, over steps in which coils conduct against their clamps."""
    m, command = motor(name)
    time_base = base(0.15)
    names = ("R", "L", "V_clamp") if name != "held" else ("R", "L")
    chosen = [list(map(str, m.plant.parameters)).index(q) for q in names]
    kernel = run_kernel(m, command, time_base, sensitive=chosen, substeps=8)
    twin = run_twin(m, command, time_base, sensitive=chosen)
    assert len(kernel.switching.time) == len(twin.switching)
    for j, quantity in enumerate(OUTPUTS):
        assert rms(np.asarray(kernel.values[quantity]) - twin.y[:, j]) <= 1e-8 * rms(twin.y[:, j]), quantity
    found, slopes = kernel.jacobian["rotor_angle"], twin.jacobian[:, OUTPUTS.index("rotor_angle")]
    assert np.all(np.linalg.norm(found - slopes, axis=0) <= 1e-5 * np.linalg.norm(slopes, axis=0))


def test_a_coil_at_rest_fills_and_empties_by_its_exponentials():
    """Truth: U/R (1 - exp(-t R/L)) while it is fed, then the exponential towards -V/R, and zero from there on."""
    m, command = motor("open", HELD_FAST)
    time_base = base(0.04)
    found = np.asarray(run_kernel(m, command, time_base).values["current_phase_a"])
    R, L = m.value("stepper.coil_resistance"), m.value("stepper.coil_inductance")
    fed, clamp = m.value("stepper.peak_voltage") * np.sqrt(0.5) / R, 1.8 / R
    since = time_base.times - 1.0 / 46.0
    rise = fed * (1.0 - np.exp(-np.clip(since, 0.0, 0.008) * R / L))
    after = np.maximum(since - 0.008, 0.0)
    expected = np.maximum((rise + clamp) * np.exp(-after * R / L) - clamp, 0.0)
    np.testing.assert_allclose(found, np.where(since > 0.0, expected, 0.0), atol=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["open", pytest.param("open halves", marks=pytest.mark.slow)])
def test_its_energy_balances(name):
    """Truth: what the terminals take is heat, friction, energy stored and work, to 1e-9 of what they take."""
    coils = "ab" if name == "open" else "abcd"
    outputs = ("rotor_rate", "rotor_angle", *(f"{q}_phase_{x}" for q in ("current", "voltage") for x in coils))
    m, command = motor(name, {"stepper": {"detent": None}}, outputs)
    time_base = base(0.08, rate_hz=1e5)
    run = run_kernel(m, command, time_base, substeps=4)
    got = {q: np.asarray(v) for q, v in run.values.items()}
    i, u = (np.stack([got[f"{q}_phase_{x}"] for x in coils]) for q in ("current", "voltage"))
    angle, omega, t = got["rotor_angle"], got["rotor_rate"], time_base.times
    R, L, k_v = (m.value(f"stepper.{key}") for key in ("coil_resistance", "coil_inductance", "back_emf_constant"))
    shape = np.sin(50.0 * angle[None, :] + 0.5 * np.pi * np.arange(len(coils))[:, None])
    emf = k_v * omega * shape
    edges = command.excitation(0.08).times
    ends = np.unique(np.concatenate([[0.0], edges, run.switching.time, [0.08]]))
    taken = lost = 0.0
    for begin, end in pairwise(ends):
        inside = (t > begin + 1.5e-5) & (t < end - 1.5e-5)
        if inside.sum() < 16:
            continue
        first, last = np.flatnonzero(inside)[[0, -1]]
        part = slice(first, last + 1)
        stored = 0.5 * L * np.sum(i[:, [first, last]] ** 2, axis=0)
        in_, out = (integral(t[part], np.sum(x[:, part], axis=0)) for x in (u * i, R * i**2 + emf * i))
        assert abs(in_ - out - (stored[1] - stored[0])) <= 1e-9 * max(abs(in_), 1e-4), (begin, end)
        taken, lost = taken + abs(in_), lost + out
    assert taken > 1e-3
    assert lost > 0.0
    clamped = (u * i).min()
    assert clamped < 0.0  # the clamps take energy while coils empty


@pytest.mark.skipif(shutil.which("ngspice") is None, reason="ngspice is not installed")
@pytest.mark.parametrize("phases", [2, 4])
def test_ngspice_has_the_same_currents_and_swings(phases):
    """Truth: a circuit of switches and diodes, in which nothing says what a coil does."""
    v = pulsed_drive.VALUES
    table = {
        "assembly": "current_driven_stepper",
        "stepper": {
            "drive": "voltage",
            "phases": phases,
            "poles": 2.0 * v["half_poles"],
            "peak_voltage": v["U"],
            "coil_resistance": v["R"],
            "coil_inductance": v["L"],
            "torque_constant": v["k"],
            "rotor_inertia": v["J"],
            "pulses": {
                "on_s": pulsed_drive.PULSE_S,
                "clamp_V": pulsed_drive.CLAMP_V[phases],
                "diode_drop_V": pulsed_drive.DIODE_DROP_V,
            },
        },
        "friction": {"static": 0.0, "coulomb": 0.0, "viscous": v["viscous"]},
    }
    m = mechanism_of(table)
    start, waveform = (45.0, "cosine") if phases == 2 else (0.0, "square")
    rate = RateProfile.constant(1.0 / pulsed_drive.STEP_S)
    plain = Command(stepping="full", microsteps=1, rate=rate, start_angle_deg=start, waveform=waveform)
    found = pulsed_drive.run(phases)
    m = replace(m, plant=m.plant.with_outputs(tuple(found)))
    own = run_kernel(m, m.command_for(plain), base(pulsed_drive.SECONDS, rate_hz=pulsed_drive.RATE_HZ), substeps=4)
    for quantity, theirs in found.items():
        ours = np.asarray(own.values[quantity])
        # A sample at a jump of the voltage is one of its sides here and their mean there.
        off = np.sort(np.abs(ours - theirs))[: -theirs.size // 100]
        assert rms(off) < 3e-4 * rms(theirs - theirs.mean()), quantity


def integral(t, y):
    """Return the integral of smooth samples, by a spline of the seventh degree."""
    return float(make_interp_spline(t, y, k=7).integrate(t[0], t[-1]))


@pytest.mark.slow
def test_a_share_between_pulses_is_the_command_of_a_lower_voltage():
    """Truth: a hold of 1 is the drive without pulses."""
    _, command = motor("held")
    m = paper_with({"housing": None})
    whole = replace(command, pulse=replace(command.pulse, hold=1.0))
    found = run_kernel(m, whole, base(0.1), substeps=8).torque
    expected = run_kernel(m, replace(command, pulse=None), base(0.1), substeps=8).torque
    assert rms(found - expected) <= 1e-8 * rms(expected)


def test_a_run_that_begins_within_a_pulse_goes_on():
    """Truth: the edges of the whole command, from there on."""
    _, command = motor("held")
    whole, late = command.excitation(0.1), command.begin_at(0.046).excitation(0.054)
    later = whole.times > 0.046
    np.testing.assert_allclose(late.times, whole.times[later] - 0.046, atol=1e-12)
    np.testing.assert_array_equal(late.values, whole.values[later])
    np.testing.assert_array_equal(late.initial, whole.values[~later][-1])
