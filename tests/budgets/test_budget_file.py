"""Budget files. Truth: the example as it is written, and a line with place and remedy for every wrong entry."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.budgets.budget_file import read_budget_file
from mechid.budgets.example import BUDGET, STRUCTURE, write_example
from mechid.budgets.findings import findings
from mechid.budgets.flying_mechanism import flying_estimate
from mechid.errors import InputFileError
from mechid.identification.result.fit_file import read_fit
from paper_estimate import write_estimate_of_paper


@pytest.fixture
def folder(tmp_path):
    write_estimate_of_paper(tmp_path)
    write_example(tmp_path)
    return tmp_path


def changed(folder, old, new):
    assert old in BUDGET
    (folder / "budget.toml").write_text(BUDGET.replace(old, new, 1), encoding="utf-8")
    return folder / "budget.toml"


def test_the_example_is_read_as_it_stands(folder):
    file = read_budget_file(folder / "budget.toml")
    scan, slew, run_up = file.modes
    np.testing.assert_allclose(scan.rates, np.linspace(10.0, 60.0, 26))
    assert (scan.command.microsteps, slew.command.stepping, slew.rates.tolist()) == (16, "full", [92.0])
    assert scan.refined
    assert not slew.refined
    assert (run_up.is_profile, run_up.duration_s, run_up.highest_rate) == (True, 10.0, 60.0)
    assert [mode.duty for mode in file.modes] == [0.7, 0.02, 0.05]
    assert [(e.kind, e.axes.tolist()) for e in file.errors] == [
        ("bias", [True, False]),
        ("random", [True, True]),
        ("periodic", [True, True]),
    ]
    assert file.flight.values == {"load.inertia": 0.0105}
    assert file.flight.uncertain == {"load.inertia": 1e-4}
    assert file.flight.spread == {"stepper.peak_voltage": 0.06}
    assert file.structure.model.frequency_hz[0] == 0.02  # the rigid body under attitude control
    exposure, pointing = file.requirements
    assert (exposure.index.kind, exposure.index.window_s, pointing.axis) == ("RPE", 0.1, "cone")


def test_a_value_of_the_flight_that_looks_like_percent_is_asked_about(folder):
    mode = "[[flight.load_mode]]\nfrequency_hz = 3.0\ndamping = 0.01\ninertia = 0.001\n\n[structure]"
    file = read_budget_file(changed(folder, "[structure]", mode))
    values = {**file.flight.values, "load.mode.0.damping": 0.5}
    flight = replace(file.flight, values=values)
    told = list(findings(replace(file, flight=flight), flying_estimate(read_fit(file.estimate), flight), ()))
    (asked,) = (line for line in told if "percent" in line)
    assert asked.startswith("budget.toml: flight.values: load.mode.0.damping = 0.5: is this in percent?")
    assert not any(
        "percent" in line for line in findings(file, flying_estimate(read_fit(file.estimate), file.flight), ())
    )


def test_files_that_are_there_stay(folder):
    (folder / "structure.toml").write_text("mine", encoding="utf-8")
    assert write_example(folder) == []
    assert (folder / "structure.toml").read_text(encoding="utf-8") == "mine"
    assert STRUCTURE.startswith("# ASSUMED")


EXPORTED = """
[[requirement]]
name = "exported"
direction = "torque"
kind = "amplitude"
unit = "mN*m"
mask = [[10.0, 500.0], [400.0, 50.0]]
"""


def test_one_file_holds_requirements_on_line_of_sight_and_emission(folder):
    """Truth: the file; the limits in SI."""
    path = folder / "budget.toml"
    path.write_text(path.read_text(encoding="utf-8") + EXPORTED, encoding="utf-8")
    file = read_budget_file(path)
    assert len(file.requirements) == 2
    assert [one.name for one in file.emission] == ["exported"]
    assert file.emission[0].mask.limits.tolist() == [0.5, 0.05]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"mN*m"', '"mm"', 'requirement[2].unit: found "mm"; write a unit of N*m'),
        ("[400.0, 50.0]", "[4.0, 50.0]", "requirement[2].mask[1]: 4 Hz falls below 10 Hz"),
        ('kind = "amplitude"', 'limit_rad = 1e-6\nkind = "amplitude"', "requirement[2].direction: unknown key"),
    ],
)
def test_what_is_wrong_with_a_mask_is_said(folder, old, new, said):
    path = folder / "budget.toml"
    path.write_text(path.read_text(encoding="utf-8") + EXPORTED.replace(old, new), encoding="utf-8")
    with pytest.raises(InputFileError) as caught:
        read_budget_file(path)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("estimate =", "estimat =", 'estimat: unknown key; did you mean "estimate"'),
        ('axis = "rz"', 'axis = "z"', 'axis: found "z"'),
        ("load_inertia", "load_inertai", 'flight.load_inertai: unknown key; did you mean "load_inertia"'),
        ("peak_voltage = 0.06", "peak_voltage = -0.06", "flight.spread.stepper.peak_voltage: found -0.06"),
        ('kind = "bias"', 'kind = "bais"', 'error[0].kind: found "bais"; did you mean "bias"'),
        (
            "spread_rad = 2e-8",
            "frequency_hz = 2.0",
            "error[0].frequency_hz: belongs to a periodic error; this one is bias",
        ),
        ("bandwidth_hz = 2.0\n", "", "error[1].bandwidth_hz: missing; a random error needs it"),
        ("frequency_hz = 33.0", "frequency_hz = 0.0", "error[2].frequency_hz: found 0"),
        ("load.inertia = 1e-4 }", "load.inertia = -1 }", "flight.uncertain.load.inertia: found -1"),
        ('index = "RPE"', 'index = "RPEE"', 'requirement[0].index: found "RPEE"; did you mean "RPE"'),
        ("window_s = 0.1\n", "", "requirement[0].window_s: found 0; RPE needs window_s"),
        ('axis = "x"', 'axis = "los"', 'error[0].axis: found "los"; write one of "x", "y"'),
        ('axis = "cone"', 'axis = "los"', 'requirement[1].axis: found "los"; write one of "x", "y", "cone"'),
        ('"temporal"', '"temprl"', 'interpretation: found "temprl"; did you mean "temporal"'),
        ("confidence = 0.9973", "confidence = 99.73", "confidence: found 99.73; write a share"),
        ("limit_rad = 6e-7\n", "", "requirement[0].limit_rad: missing; write the limit in rad"),
        ("evaluation_period_s = 600.0", "evaluation_period_s = 0.05", "the windows take 0.1 s"),
        ('name = "slew"', 'name = "scan"', 'mode[1].name: "scan" is the name of another mode'),
    ],
)
def test_what_is_wrong_is_said(folder, old, new, said):
    with pytest.raises(InputFileError) as caught:
        read_budget_file(changed(folder, old, new))
    assert said in str(caught.value)
    assert str(caught.value).startswith("budget.toml: ")
