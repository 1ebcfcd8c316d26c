"""``mechid design`` from a campaign without files to a proposed one, and after a fit."""

import csv
import json

import numpy as np
import pytest

from mechid.campaign import load_campaign

SMALL = """
[recording]
noise_Nm = 0.002
[candidates]
steppings = ["full"]
rates = [23.0, 46.0, 600.0]
start_angles_deg = [45.0]
sweeps_s = []
[limits]
between_s = 1.0
total_s = 6.0
[prior]
mechanisms = 2
"""
PLANNED = """
mechanism = "mechanism.toml"
[[record]]
name = "micro_46"
command = { stepping = "micro", microsteps = 16, rate = 46.0 }
"""


@pytest.fixture
def planned(folder):
    """Return a folder with a campaign of one record that has no file, and a small design file."""
    for path in folder.glob("*.csv"):
        path.unlink()
    (folder / "campaign.toml").write_text(PLANNED, encoding="utf-8")
    (folder / "design.toml").write_text(SMALL, encoding="utf-8")
    return folder


def read(folder):
    return json.loads((folder / "design.json").read_text(encoding="utf-8"))


def test_a_design_of_records_without_files(run, planned, tmp_path):
    """Truth: laws between the numbers of the files, and what no motor of this kind can do: start at 600 steps/s."""
    out = tmp_path / "out"
    result = run("design", planned, "--out", out)
    assert result.exit_code == 0, result.stderr
    data = read(out)
    objections = {c["name"]: c["objection"] for c in data["candidates"]}
    assert objections["full_600"] == "loses steps at the values believed"
    assert not objections["full_46"]
    chosen = data["chosen"]
    assert {r["name"] for r in chosen["records"]} == {name for name, why in objections.items() if not why}
    assert chosen["seconds"] == pytest.approx(2.0 * len(chosen["records"]))
    assert np.all(np.diff(data["trail"]) < 0.0)
    assert data["gain_factor"] == pytest.approx(np.exp(data["planned"]["criterion"] - chosen["criterion"]))
    assert data["gain_factor"] > 1.0
    for p in data["parameters"]:
        assert p["chosen"] is None or p["chosen"] < p["planned"], p["name"]
    assert "left out: full_600: loses steps" in result.stdout
    assert f"{len(chosen['records'])} records in" in result.stdout
    assert {row["stepping"] for row in data["step_loss"]} == {"full"}
    rows = list(csv.DictReader((out / "torque_over_rate.csv").read_text(encoding="utf-8").splitlines()))
    assert [float(r["micro_Nm"]) for r in rows] == pytest.approx(
        data["torque_over_rate"][2]["amplitude_Nm"], rel=1e-5)  # fmt: skip
    for name in ("torque_over_rate", "standard_errors", "step_loss"):
        for suffix in ("svg", "png"):
            assert (out / "figures" / f"{name}.{suffix}").stat().st_size > 1000


def test_the_proposed_campaign_can_be_driven_and_looked_at_again(run, planned, tmp_path):
    """Truth: the proposal read back has the commands chosen, and a design of it predicts the same errors."""
    out, again = tmp_path / "out", tmp_path / "again"
    assert run("design", planned, "--out", out).exit_code == 0
    proposal = load_campaign(out, read_records=False)
    data = read(out)
    assert [r.name for r in proposal.records] == [r["name"] for r in data["chosen"]["records"]]
    assert proposal.record("full_46").command.start_angle_deg == 45.0
    (out / "design.toml").write_text(
        (out / "design.toml").read_text(encoding="utf-8")
        + '[candidates]\nsteppings = ["full"]\nrates = [46.0]\nsweeps_s = []\n[prior]\nmechanisms = 1\n',
        encoding="utf-8",
    )
    result = run("design", out, "--out", again)
    assert result.exit_code == 0, result.stderr
    for now, before in zip(read(again)["parameters"], data["parameters"], strict=True):
        assert now["planned"] == (before["chosen"] and pytest.approx(before["chosen"], rel=1e-6)), now["name"]


def test_after_a_fit_its_records_are_there_already(run, staged, tmp_path):
    """Truth: what is known now is what the fit reports; what it held because no record told it is open again."""
    fit, out = tmp_path / "fit", tmp_path / "out"
    (staged / "design.toml").write_text(SMALL, encoding="utf-8")
    assert run("identify", staged, "--out", fit).exit_code == 0
    result = run("design", staged, "--fit", fit, "--out", out)
    assert result.exit_code == 0, result.stderr
    data = read(out)
    assert data["after_fit"]
    assert data["planned"]["records"] == []
    assert "What to measure next, by the D-criterion" in result.stdout
    known = {p["name"]: p for p in data["parameters"]}
    assert len(known) == 15
    assert known["housing.gain"]["chosen"] is not None
    assert known["gear.stiffness"]["chosen"] < 0.9 * known["gear.stiffness"]["planned"]


def test_one_parameter_can_be_the_aim(run, planned, tmp_path):
    """Truth: the criterion of a parameter chooses a set whose error of it is no larger than D's."""
    sets = {}
    text = SMALL.replace("total_s = 6.0", "total_s = 2.0")
    (planned / "design.toml").write_text(text, encoding="utf-8")
    for kind in ("D", "friction.static"):
        out = tmp_path / kind.replace(".", "_")
        assert run("design", planned, "--out", out, "--criterion", kind).exit_code == 0
        sets[kind] = {p["name"]: p["chosen_spread"][0] for p in read(out)["parameters"]}
    assert sets["friction.static"]["friction.static"] <= sets["D"]["friction.static"]


@pytest.mark.parametrize(
    ("change", "code", "message"),
    [
        (("campaign.toml", '[[record]]', '[[record]]\nuse = "validate"'), 2, 'no record has use = "estimate"'),
        (("design.toml", "[limits]", '[limits]\nkeep = ["micro_64"]'), 2, 'no record "micro_64"; did you mean'),
        (("design.toml", "[limits]", "[criterion]\nkind = \"gear.stifness\"\n[limits]"), 2, 'did you mean "gear.stiff'),
        (("design.toml", "[limits]", "[limmits]"), 3, 'limmits: unknown key; did you mean "limits"'),
    ],
)  # fmt: skip
def test_what_is_wrong_is_one_line(refused, planned, tmp_path, change, code, message):
    name, old, new = change
    path = planned / name
    path.write_text(path.read_text(encoding="utf-8").replace(old, new, 1), encoding="utf-8")
    assert message in refused(code, "design", planned, "--out", tmp_path / "out")


def test_a_design_does_not_replace_its_own_campaign(refused, planned):
    assert "holds the campaign itself" in refused(2, "design", planned, "--out", planned)
