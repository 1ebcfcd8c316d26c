"""Three phases in star, simulated on two axes. Truth: their equations phase by phase, integrated by SciPy."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from layouts import mechanism_of
from mechid.command import MeasuredCommand, RateProfile
from mechid.command.measured import InputChannel
from mechid.errors import InputFileError, UsageError
from mechid.simulation.repetition import repetition
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run
from runs import base, run_twin
from three_phases import FILE, QUANTITIES, SHIFTS, coupling, integrate, star, stepped, terminals

SIX_STATES = {"three on": 0.0, "two on": 30.0}
COMMANDS = {
    **{name: stepped(100.0, waveform="square", start_angle_deg=angle) for name, angle in SIX_STATES.items()},
    "twelve states": stepped(100.0, microsteps=2, waveform="square"),
    "microsteps": stepped(100.0, microsteps=8, start_angle_deg=17.0),
}


def run(command, time_base, substeps=32):
    m = star()
    return simulate_run(Simulator(m.plant, command, time_base).run(m.kernel_values(), substeps=substeps)).values


@pytest.mark.parametrize("name", COMMANDS)
def test_its_two_axes_are_its_three_phases(name):
    """Truth: three currents, a floating star point and the rotor, by DOP853 at 1e-13; equal to 1e-9 of each peak."""
    time_base = base(0.06)
    found, truth = run(COMMANDS[name], time_base), integrate(COMMANDS[name], time_base.times)
    for quantity, expected in zip(QUANTITIES[1:], truth.T, strict=True):
        assert np.abs(found[quantity] - expected).max() <= 1e-9 * np.abs(expected).max(), quantity
    angle, i = found["rotor_angle"], truth[:, :3]
    shape = np.array([coupling(a) for a in angle])
    made = 0.11 * np.sum(i * shape, axis=1) - 0.01 * np.sin(60.0 * angle + np.radians(25.0))
    expected = 2e-3 * found["rotor_rate"] - made
    assert np.abs(found["torque"] - expected).max() <= 1e-9 * np.abs(expected).max()


def test_its_energy_balances():
    """Truth: what the terminals supply is heat, friction, stored energy and the work of the magnets, to 1e-9."""
    command, time_base = COMMANDS["two on"], TimeBase(1e5, 6001)
    found, t = run(command, time_base, substeps=4), time_base.times
    i = np.stack([found[f"current_phase_{x}"] for x in "abc"])
    omega, angle = found["rotor_rate"], found["rotor_angle"]
    own, step = FILE["stepper"], 1000
    supplied = lost = 0.0
    for k in range(6):
        part = slice(k * step, (k + 1) * step + 1)
        u = own["peak_voltage"] * terminals(command, k)
        shape = np.array([coupling(a) for a in angle[part]]).T
        # k_v < k_m here: the magnets' torque is more than the back-EMF's power over the rate.
        made = np.sum(i[:, part] * shape, axis=0) * omega[part]
        supplied += integral(t[part], u @ i[:, part] + (own["torque_constant"] - own["back_emf_constant"]) * made)
        lost += integral(t[part], own["coil_resistance"] * np.sum(i[:, part] ** 2, axis=0) + 2e-3 * omega[part] ** 2)
    detent = -0.01 / 60.0 * np.cos(60.0 * angle + np.radians(25.0))
    stored = 0.5 * own["coil_inductance"] * np.sum(i**2, axis=0) + 0.5 * own["rotor_inertia"] * omega**2 + detent
    assert abs(supplied - lost - (stored[-1] - stored[0])) <= 1e-9 * supplied


def integral(t, y):
    """Return the integral of smooth samples, by a spline of the seventh degree."""
    return float(make_interp_spline(t, y, k=7).integrate(t[0], t[-1]))


def test_its_source_sags_by_the_power_of_three_phases():
    """Truth: settled currents of three phases, each from (U - R_s sum e i) e, solved by hand."""
    m, command = star({"supply": {"resistance": 2.0}}), stepped(1.0, microsteps=8, start_angle_deg=17.0)
    found = run_twin(m, command, base(2e-4)).y[0]
    e = terminals(command, 0)
    expected = np.linalg.solve(8.0 * np.eye(3) + 2.0 * np.outer(e, e), 12.0 * e)
    names = list(m.plant.outputs)
    own = [found[names.index(f"current_phase_{x}")] for x in "abc"]
    np.testing.assert_allclose(own, expected, rtol=1e-9)


@pytest.mark.parametrize("driven", ["voltage", "current"])
def test_measured_phases_drive_it(driven):
    """Truth: the same motor under the command that makes these voltages, or currents, of phases A and B."""
    command, time_base = stepped(250.0, microsteps=4), base(0.006)
    steps = np.floor(time_base.times * 1000.0 + 1e-9).astype(int)
    waves = np.array([terminals(command, k) for k in steps]).T
    peak = {"voltage": {"peak_voltage": 12.0}, "current": {"peak_current": 1.5}}[driven]
    size = next(iter(peak.values()))
    bare = {} if driven == "voltage" else dict.fromkeys(("coil_resistance", "coil_inductance", "back_emf_constant"))
    bare |= {"peak_voltage": None, "torque_harmonic": None}
    usual = star({"stepper": {**bare, "drive": driven, **peak}}, ("torque",))
    measured = star({"stepper": {**bare, "drive": f"measured_{driven}"}}, ("torque",))
    channels = tuple(
        InputChannel(quantity=f"{driven}_phase_{x}", held=True, samples=size * waves[k]) for k, x in enumerate("ab")
    )
    given = MeasuredCommand().driven_by(channels, 10_000.0, 0.0)
    expected = run_twin(usual, command, time_base).y[:, 0]
    found = run_twin(measured, given, time_base).y[:, 0]
    assert np.abs(found - expected).max() <= 1e-7 * np.abs(expected).max()


def test_currents_of_a_current_drive_are_those_of_its_phases():
    """Truth: I times the commanded waves of three phases."""
    bare = dict.fromkeys(("peak_voltage", "coil_resistance", "coil_inductance", "back_emf_constant"))
    names = tuple(f"current_phase_{x}" for x in "abc")
    m = star({"stepper": {"drive": "current", "peak_current": 1.5, **bare}}, names)
    command = stepped(1.0, microsteps=8, start_angle_deg=17.0)
    np.testing.assert_allclose(run_twin(m, command, base(2e-4)).y[0], 1.5 * terminals(command, 0), rtol=1e-12)
    assert SHIFTS.size == len(names)


@pytest.mark.parametrize(("order", "steps"), [(6, 3), (3, 6), (1, 6)])
def test_it_repeats_after_three_or_six_steps(order, steps):
    """Truth: half an electrical period mirrors a detent of even order; an odd one needs all of it."""
    detent = [{"period_deg": 36.0 / order, "amplitude": 0.01}]
    assert repetition(star({"stepper": {"detent": detent, "torque_harmonic": None}})).steps == steps


def test_it_turns_by_sixty_degrees_a_step():
    """Truth: the period of six states; a command's steps until a run begins."""
    command = stepped(10.0)
    assert command.begin_at(0.35).start_angle_rad == pytest.approx(np.pi)
    assert (command.mirrored_steps, command.full_step_deg, command.symmetry_deg) == (3, 60.0, 60.0)
    assert command.for_motor(2).begin_at(0.35).start_angle_rad == pytest.approx(1.5 * np.pi)


def test_a_table_of_two_phases_is_refused():
    """Truth: the message."""
    from mechid.command.phase_table import nominal_table

    rows = tuple(map(tuple, nominal_table(4).tolist()))
    command = replace(stepped(10.0, microsteps=4).for_motor(2), table=rows)
    with pytest.raises(UsageError, match="table: it has the values of two phases, the motor has 3; leave it out"):
        command.for_motor(3)
    assert RateProfile.constant(10.0) == command.rate


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"stepper": {"imbalance": {"torque_constant": 0.02}}}, "stepper.imbalance: is of two phases at right angles"),
        ({"stepper": {"saliency": {"share": 0.1}}}, "stepper.saliency: is of two phases"),
        (
            {"stepper": {"torque_harmonic": [{"order": 9, "amplitude": 0.02}]}},
            "three phases in star cancel every third",
        ),
        ({"stepper": {"phase_shift_deg": 90.0}}, "three phases in star are 120 deg apart; leave it out"),
    ],
)
def test_tables_of_two_phases_are_refused(changes, message):
    """Truth: the message."""
    with pytest.raises(InputFileError, match=message):
        star(changes)
    assert mechanism_of(FILE).phases == 3
