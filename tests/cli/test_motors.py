"""Motors, drives and meshes through every command: star, unipolar halves, pulses. Truth: the values simulated."""

import csv
import json
import re

import numpy as np
import pytest

MECHANISM = """
[stepper]
{motor}
peak_voltage = 12.0
coil_resistance = {{ value = 9.0, min = 5.0, max = 20.0 }}
coil_inductance = {{ value = 0.02, min = 0.005, max = 0.1 }}
torque_constant = {{ value = 0.3, min = 0.1, max = 1.0 }}
rotor_inertia = 2e-5
[[stepper.detent]]
period_deg = {period}
amplitude = {{ value = 0.01, min = 0.0, max = 0.1 }}
phase_deg = {{ value = 0.0, min = -180.0, max = 180.0 }}
{drive}
[friction]
static = 0.012
coulomb = {{ value = 0.01, min = 0.001, max = 0.05 }}
viscous = {{ value = 1e-3, min = 0.0, max = 0.01 }}
[gear]
ratio = 50
stiffness = {{ value = 1000.0, min = 200.0, max = 5000.0 }}
damping = {{ value = 0.5, min = 0.05, max = 3.0 }}
{gear}
[load]
inertia = 0.0105
"""
PULSES = """[stepper.pulses]
on_s = 0.008
between = "open"
clamp_V = { value = 3.0, min = 0.5, max = 10.0 }"""
HYSTERESIS = """[stepper.detent_hysteresis]
torque = 0.01
angle_deg = 12.0
"""
ERROR = """[[gear.kinematic_error]]
order = "mesh 2"
amplitude = { value = 2e-4, min = 0.0, max = 2e-3 }
phase_deg = { value = 40.0, min = -180.0, max = 180.0 }
"""
MESH = f"""[[gear.mesh]]
teeth = [20, 52]
[[gear.mesh]]
teeth = [23, 69]
ratio_behind = 6.41025641025641
{ERROR}[[gear.stiffness_variation]]
order = "mesh 1"
amplitude = {{ value = 0.15, min = 0.0, max = 0.5 }}
phase_deg = -30.0
"""
MOTORS = {
    "star": {"motor": "poles = 20\nphases = 3", "period": 6.0, "drive": "", "gear": ""},
    "unipolar": {"motor": "poles = 100\nphases = 4", "period": 1.8, "drive": "", "gear": ""},
    "pulses": {"motor": "poles = 100", "period": 1.8, "drive": PULSES, "gear": ""},
    "mesh": {"motor": "poles = 100", "period": 1.8, "drive": "", "gear": MESH},
    "hysteresis": {"motor": "poles = 100", "period": 1.8, "drive": HYSTERESIS, "gear": ""},
}
TRUTH = {
    "pulses": {"stepper.pulses.clamp_V": 3.0},
    "mesh": {
        "gear.kinematic_error.0.amplitude": 2e-4,
        "gear.kinematic_error.0.phase_deg": 40.0,
        "gear.stiffness_variation.0.amplitude": 0.15,
    },
}
"""Beside the values that all have."""
START = {"unipolar": 'start_angle_deg = 0.0, waveform = "square"'}
OFF = {"coil_resistance": 1.2, "torque_constant": 0.85, "stiffness": 1.4, "clamp_V": 1.4}
"""Catalogue over truth."""
BUDGET = """
estimate = "estimate.json"
axis = "rz"
[structure]
file = "structure.toml"
[[mode]]
name = "slew"
command = {{ stepping = "full", {start} }}
rates = [19.0, 21.0]
[[requirement]]
name = "stability"
index = "RPE"
window_s = 0.1
axis = "x"
limit_rad = 1e-4
interpretation = "temporal"
confidence = 0.95
evaluation_period_s = 60.0
"""
STRUCTURE = """
line_of_sight = ["x"]
[[mode]]
frequency_hz = 21.0
damping = 0.005
interface = 0.15
line_of_sight = [-0.04]
"""


def write_campaign(folder, start, *, measured=False):
    """Write a campaign of three records, whose files are those simulated or none."""
    text = f'mechanism = "{"start" if measured else "mechanism"}.toml"\nsynthetic = true\n'
    for name, stepping, rate in (("full_20", "full", 20.0), ("full_45", "full", 45.0), ("half_30", "half", 30.0)):
        file = f'file = "sim/{name}.csv"\n' if measured else ""
        command = f'{{ stepping = "{stepping}", rate = {rate}, {start} }}'
        text += f'[[record]]\nname = "{name}"\n{file}command = {command}\n'
    (folder / "campaign.toml").write_text(text, encoding="utf-8")


def add_noise(folder, rng):
    """Leave time and torque of the simulated records, with 2 mN m of noise."""
    for path in folder.glob("*.csv"):
        with path.open(encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        torque = np.array([float(row["torque_Nm"]) for row in rows]) + rng.normal(0.0, 2e-3, len(rows))
        lines = [f"{row['time_s']},{y:.9g}" for row, y in zip(rows, torque, strict=True)]
        path.write_text("time_s,torque_Nm\n" + "\n".join(lines) + "\n", encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("motor", MOTORS)
def test_a_motor_goes_through_every_command(run, tmp_path, motor):
    """Truth: the values that made the records, within four standard errors; each export is held against the kernel."""
    start = START.get(motor, "start_angle_deg = 45.0")
    true = MECHANISM.format(**MOTORS[motor])
    (tmp_path / "mechanism.toml").write_text(true, encoding="utf-8")

    def done(*words):
        result = run(*words)
        assert result.exit_code == 0, (words, result.stderr)
        return result

    write_campaign(tmp_path, start)
    done("check", tmp_path)
    done("simulate", tmp_path, "--out", tmp_path / "sim")
    add_noise(tmp_path / "sim", np.random.default_rng(5))
    off = true
    for key, factor in OFF.items():
        off = re.sub(
            rf"{key} = {{ value = ([\d.e-]+)", lambda m, f=factor, k=key: f"{k} = {{ value = {float(m[1]) * f}", off
        )
    (tmp_path / "start.toml").write_text(off, encoding="utf-8")
    write_campaign(tmp_path, start, measured=True)
    fit = tmp_path / "fit"
    done("identify", tmp_path, "--out", fit, "--workers", 1)
    found = json.loads((fit / "estimate.json").read_text(encoding="utf-8"))
    assert found["grade"] == "A"
    truth = {"stepper.coil_resistance": 9.0, "stepper.torque_constant": 0.3, "gear.stiffness": 1000.0}
    truth |= TRUTH.get(motor, {})
    for name, value in truth.items():
        one = found["parameters"][name]
        assert abs(one["value"] - value) < 4.0 * one["std_error"], name
    (fit / "budget.toml").write_text(BUDGET.format(start=start), encoding="utf-8")
    (fit / "structure.toml").write_text(STRUCTURE, encoding="utf-8")
    done("budget", fit / "budget.toml", "--out", tmp_path / "budget")
    done("look", tmp_path, "--out", tmp_path / "look")
    for target, more in (("c", ()), ("fmu", ()), ("tables", ("--option", "rates=20"))):
        done("export", fit, "--to", target, "--out", tmp_path / target, *more)
        told = json.loads((tmp_path / target / "mechid_export.json").read_text(encoding="utf-8"))
        assert told["checked"] is not None


HELD = """[stepper.pulses]
on_s = 0.008
between = "held"
hold = 0.0"""
INCOMPLETE = {
    "gear.kinematic_error:mesh 2": ("mesh", ERROR, ""),
    "stepper.pulses.open": ("pulses", PULSES, HELD),
    "stepper.detent_hysteresis": ("hysteresis", HYSTERESIS, ""),
}
"""Of each effect the motor that has it, and what stands in its file and in the one that lacks it."""
SIZES = {
    "gear.kinematic_error:mesh 2": {
        "gear.kinematic_error.0.amplitude": 2e-4,
        "gear.kinematic_error.0.phase_deg": 40.0,
    },
    "stepper.pulses.open": {"stepper.pulses.clamp_V": 3.0},
    "stepper.detent_hysteresis": {
        "stepper.detent_hysteresis.torque": 0.01,
        "stepper.detent_hysteresis.angle_deg": 12.0,
    },
}


@pytest.mark.slow
@pytest.mark.parametrize("effect", INCOMPLETE)
def test_an_effect_that_the_file_lacks_is_named(run, tmp_path, effect):
    """Truth: the effect and its values that made the records."""
    motor, has, lacks = INCOMPLETE[effect]
    start, true = "start_angle_deg = 45.0", MECHANISM.format(**MOTORS[motor])
    (tmp_path / "mechanism.toml").write_text(true, encoding="utf-8")
    write_campaign(tmp_path, start)
    assert run("simulate", tmp_path, "--out", tmp_path / "sim").exit_code == 0
    add_noise(tmp_path / "sim", np.random.default_rng(5))
    assert has in true
    (tmp_path / "start.toml").write_text(true.replace(has, lacks), encoding="utf-8")
    write_campaign(tmp_path, start, measured=True)
    run("identify", tmp_path, "--out", tmp_path / "fit", "--workers", 1)
    (missing,) = json.loads((tmp_path / "fit" / "estimate.json").read_text(encoding="utf-8"))["missing"]
    assert missing["name"] == effect
    for name, value in SIZES[effect].items():
        one = missing["parameters"][name]
        assert abs(one["value"] - value) < 4.0 * one["std_error"], name


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("rate = 45.0", "rate = 145.0", "record[1].command.rate: a step every 0.00689655 s is shorter than"),
        ('between = "open"', 'between = "open"\nhold = 0.3', "stepper.pulses.hold: unknown key; it belongs to"),
        ("on_s = 0.008", "on_s = 0.008\ndiode_drop_V = -0.3", "stepper.pulses.diode_drop_V: found -0.3"),
        ('between = "open"\nclamp_V = { value = 3.0, min = 0.5, max = 10.0 }', 'between = "held"\nhold = 1.5', "1.5"),
        ('between = "open"', 'between = "held"\nhold = 0.5', "stepper.pulses.clamp_V: unknown key"),
        ("poles = 100", 'poles = 100\nphases = 3', "open phases are of two or four, the motor has 3"),
    ],
    ids=["longer than a step", "hold of open phases", "drop below zero", "share above 1", "clamp", "three phases"],
)  # fmt: skip
def test_pulses_that_cannot_be_are_one_line(refused, tmp_path, old, new, words):
    """Truth: the exit code of a wrong file; nothing is written."""
    (tmp_path / "mechanism.toml").write_text(MECHANISM.format(**MOTORS["pulses"]), encoding="utf-8")
    write_campaign(tmp_path, "start_angle_deg = 45.0")
    changed = False
    for path in tmp_path.glob("*.toml"):
        text = path.read_text(encoding="utf-8")
        changed |= old in text
        path.write_text(text.replace(old, new), encoding="utf-8")
    assert changed
    assert words in refused(3, "simulate", tmp_path, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()
