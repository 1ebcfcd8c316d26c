"""The examples run as they stand. Truth: the synthetic bench's own values."""

import runpy
import sys
from pathlib import Path

import pytest

from mechid.campaign import RecordDraft, campaign_text, catalogue_mechanism, mechanism_text
from mechid.campaign.bench import TRUTH, write_bench

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
COMMAND = '{ stepping = "full", rate = 46.0, start_angle_deg = 45.0 }'
FREE = ("stepper.torque_constant", "gear.stiffness", "gear.damping")
STAGE = f"""
[[stage]]
records = ["full_46"]
window_s = [0.0, 0.1]
free = ["{'", "'.join(FREE)}"]
"""


@pytest.fixture
def folder(tmp_path):
    """Return a bench of one record, three parameters of its mechanism 3 % off, and a stage that fits them."""
    write_bench(tmp_path, seed=5, sweep_s=1.0)
    campaign = campaign_text([RecordDraft(name="full_46", file="full_46.csv", command=COMMAND)])
    (tmp_path / "campaign.toml").write_text(campaign + STAGE)
    near = {**TRUTH, **{name: 1.03 * TRUTH[name] for name in FREE}}
    (tmp_path / "mechanism.toml").write_text(mechanism_text(catalogue_mechanism().with_values(near)))
    return tmp_path


def test_identify_from_python(folder, monkeypatch, capsys):
    script = str(EXAMPLES / "identify_from_python.py")
    monkeypatch.setattr(sys, "argv", [script, str(folder)])
    runpy.run_path(script, run_name="__main__")
    printed = capsys.readouterr().out.splitlines()
    found = {cells[0]: cells for line in printed if len(cells := line.split()) > 3 and cells[2] == "+-"}
    assert tuple(found) == FREE
    for name, (_, value, _, sigma, *_) in found.items():
        assert abs(float(value) - TRUTH[name]) <= 5.0 * float(sigma) < 0.1 * TRUTH[name]
    assert printed[-1].startswith("full_46: fit 9")


def test_a_campaign_without_files(tmp_path, capsys):
    fit = runpy.run_path(str(EXAMPLES / "without_files.py"))["main"](tmp_path)
    found = fit.parameters["gear.stiffness"]
    assert abs(found.value - 2000.0) < 4.0 * found.std_error
    assert "gear" in capsys.readouterr().out
    assert {"full_46.png", "report.html", "estimate.json"} <= {path.name for path in tmp_path.iterdir()}
    assert "SYNTHETIC" in (tmp_path / "mechanism.toml").read_text()
