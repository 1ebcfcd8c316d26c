"""Six components from the records to the line of sight; all of it is SYNTHETIC, its truth known."""

import csv
import json
import re
import runpy
from pathlib import Path

import numpy as np
import pytest

from mechid.analysis.components_file import FILE_NAME, components_text
from mechid.budgets.example import BUDGET, STRUCTURE
from mechid.identification.result.estimate_file import json_text
from paper_estimate import write_estimate_of_paper
from table_of_six import side_records

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "six_components.py"
DIRECTIONS = "directions = { tx = 0.05, ty = 0.1, tz = -0.1, rx = 0.2, ry = 0.1 }"
WITHOUT_DUTY = re.sub(r"duty = .*\n", "", BUDGET)
SMALL = WITHOUT_DUTY[: WITHOUT_DUTY.index('[[mode]]\nname = "slew"')].replace(
    "rate_range = { from = 10.0, to = 60.0, count = 26 }", "rates = [20.0]"
)


def exerted(rate):
    return {"moment_z": {1.0: 0.1}, "force_x": {1.0: 0.5, 2.0: 0.1}, "moment_x": {1.0: 0.02j}}


@pytest.fixture
def folder(tmp_path):
    """Return the folder of a budget on a structure of six directions, beside an estimate with components."""
    estimate = write_estimate_of_paper(tmp_path)
    provenance = json.loads(estimate.read_text(encoding="utf-8"))["provenance"]
    records = side_records(exerted, (20.0,), np.random.default_rng(0), seconds=3.0)
    (tmp_path / FILE_NAME).write_text(json_text(components_text(records, provenance)), encoding="utf-8")
    (tmp_path / "budget.toml").write_text(SMALL, encoding="utf-8")
    structure = re.sub(r"(line_of_sight = \[[-0-9].*\n)", rf"\1{DIRECTIONS}\n", STRUCTURE)
    (tmp_path / "structure.toml").write_text(structure, encoding="utf-8")
    return tmp_path


def test_a_budget_of_six_components(run, folder):
    """Truth: closed forms between the files. A force of 0.5 N at order 1 flies as far as the modes carry it."""
    result = run("budget", folder / "budget.toml", "--out", folder / "out")
    assert result.exit_code == 0, result.stderr
    data = json.loads((folder / "out" / "budget.json").read_text(encoding="utf-8"))
    (mode,) = data["modes"]
    rows = list(csv.DictReader((folder / "out" / "components.csv").read_text(encoding="utf-8").splitlines()))
    by = {(r["component"], float(r["order"])): r for r in rows}
    assert set(by) == {("force_x", 1.0), ("force_x", 2.0), ("moment_x", 1.0)}
    one = by["force_x", 1.0]
    assert float(one["amplitude"]) == pytest.approx(0.5, rel=1e-2)
    assert float(one["phase_deg"]) == pytest.approx(0.0, abs=2.0)
    assert (one["how"], one["unit"]) == ("coherent", "N")
    assert by["force_x", 2.0]["how"] == "magnitude"  # the bench's torque had no line there
    wk = 2.0 * np.pi * np.array([0.02, 21.0, 47.5, 112.0])
    zeta, x = np.array([0.7, 0.005, 0.005, 0.01]), np.array([0.1, -0.04, 0.05, 0.03])
    w = 2.0 * np.pi * np.array([20.0, 40.0])[:, None]
    transfer = np.abs(np.sum(0.05 * x / (wk**2 - w**2 + 2j * zeta * wk * w), axis=1))
    rms = np.sqrt(0.5 * np.sum((transfer * [0.5, 0.1]) ** 2))
    force = next(c for c in mode["side"]["components"] if c["name"] == "force_x")
    assert force["line_of_sight_rms_rad"][0] == pytest.approx(rms, rel=1e-2)
    assert (force["coherent"], force["by_magnitude"]) == (1, 1)
    assert mode["side"]["together_rms_rad"] == pytest.approx(mode["line_of_sight_rms_rad"])
    assert mode["line_of_sight_rms_rad"][0] != pytest.approx(mode["side"]["drive_rms_rad"][0], rel=0.05)
    assert "Forces and moments beside the torque" in result.stdout
    page = (folder / "out" / "budget.html").read_text(encoding="utf-8")
    assert "moved to the mounting point at [0.02, -0.03, 0.06] m, " in page
    assert "| force x | 1 | 1 |" in (folder / "out" / "budget.md").read_text(encoding="utf-8")


def test_a_structure_of_one_direction_takes_the_torque_alone(run, folder):
    """Truth: the budget of an estimate that has no components; what is left out is said."""
    (folder / "structure.toml").write_text(STRUCTURE, encoding="utf-8")
    result = run("budget", folder / "budget.toml", "--out", folder / "one")
    assert result.exit_code == 0, result.stderr
    said = "force_x, force_y, force_z, moment_x, moment_y: measured beside the torque and not counted"
    assert said in " ".join(result.stdout.split())
    (folder / FILE_NAME).unlink()
    assert run("budget", folder / "budget.toml", "--out", folder / "none").exit_code == 0
    for name in ("line_of_sight.csv", "harmonics.csv", "emission.csv"):
        one, none = ((folder / out / name).read_bytes() for out in ("one", "none"))
        assert one == none
    assert not (folder / "one" / "components.csv").exists()


@pytest.mark.parametrize(
    ("frame", "said"),
    [
        ("{ x = [0, 0, 1], y = [1, 0, 0], z = [0, 1, 0] }", "structure.frame: the bench's drive axis z points along"),
        ("{ x = [0, 1, 0], y = [1, 0, 0], z = [0, 0, 1] }", "structure.frame: the axes are left-handed"),
        ("{ x = [1, 1, 0], y = [0, 1, 0], z = [0, 0, 1] }", "structure.frame: the axes are not of length 1"),
        ("{ x = [1, 0, 0], y = [0, 1, 0] }", "structure.frame.z: missing; write frame ="),
        ("{ x = [1, 0], y = [0, 1, 0], z = [0, 0, 1] }", "structure.frame.x: found [1, 0]; write three cosines"),
        ("[1, 0, 0]", "structure.frame: found [1, 0, 0]; write frame ="),
    ],
)
def test_a_wrong_frame_is_one_line_and_exit_code_3(refused, folder, frame, said):
    text = SMALL.replace('file = "structure.toml"', f'file = "structure.toml"\nframe = {frame}\n#')
    (folder / "budget.toml").write_text(text, encoding="utf-8")
    line = refused(3, "budget", folder / "budget.toml", "--out", folder / "out")
    assert said in line


@pytest.mark.slow
def test_from_the_records_to_the_line_of_sight(run, tmp_path):
    """Truth: the example's own lines; what it says of the table stands in its head."""
    runpy.run_path(str(EXAMPLE))["main"](tmp_path, (20.0, 21.0))
    assert run("identify", tmp_path / "campaign.toml", "--out", tmp_path / "fit").exit_code == 0
    assert (tmp_path / "fit" / FILE_NAME).exists()
    assert "## Forces and moments beside the torque" in (tmp_path / "fit" / "report.md").read_text(encoding="utf-8")
    assert 'id="side"' in (tmp_path / "fit" / "report.html").read_text(encoding="utf-8")
    assert run("budget", tmp_path / "budget.toml", "--out", tmp_path / "budget").exit_code == 0
    rows = list(csv.DictReader((tmp_path / "budget" / "components.csv").read_text(encoding="utf-8").splitlines()))
    at = {(r["component"], float(r["order"])): r for r in rows if float(r["rate_steps_per_s"]) == 20.0}
    torque = {
        float(r["order"]): float(r["torque_amplitude_Nm"])
        for r in csv.DictReader((tmp_path / "budget" / "harmonics.csv").read_text(encoding="utf-8").splitlines())
        if float(r["rate_steps_per_s"]) == 20.0
    }
    for name, order, amplitude in (("moment_y", 2.0, 2e-3), ("force_x", 1.0, 0.04), ("force_y", 1.0, 0.03)):
        assert float(at[name, order]["amplitude"]) == pytest.approx(amplitude, rel=0.02)
        assert at[name, order]["how"] == "coherent"
    turned = float(at["force_y", 1.0]["phase_deg"]) - float(at["force_x", 1.0]["phase_deg"])
    assert turned == pytest.approx(90.0, abs=1.0)
    assert at["force_z", 1.25]["how"] == "magnitude"
    assert float(at["moment_x", 1.0]["amplitude"]) == pytest.approx(0.06 * torque[1.0], abs=4e-5)
    assert float(at["moment_x", 1.0]["phase_deg"]) == pytest.approx(0.0, abs=15.0)
