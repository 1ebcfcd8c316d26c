"""``mechid design`` from a campaign without files to a proposed one, and after a fit."""

import csv
import json
import shutil

import numpy as np
import pytest

from mechid.campaign import load_campaign
from small_design import SMALL, design, plan


@pytest.fixture
def planned(bench, tmp_path):
    """Return a folder with a small plan."""
    shutil.copy(bench / "mechanism.toml", tmp_path)
    return plan(tmp_path)


@pytest.fixture(scope="session")
def designed(bench, tmp_path_factory):
    """Return the folder of a design of the small plan, and what the shell showed; not to be changed."""
    return design(bench, tmp_path_factory)


def read(folder):
    return json.loads((folder / "design.json").read_text(encoding="utf-8"))


def test_a_design_of_records_without_files(designed):
    """Truth: the dict of its numbers, whose laws tests/designs/test_numbers.py holds."""
    out, stdout = designed
    data = read(out)
    assert "left out: full_600: loses steps" in stdout
    assert f"{len(data['chosen']['records'])} records in" in stdout
    assert "Between two ranges is a hole" in " ".join(stdout.split())
    rows = list(csv.DictReader((out / "torque_over_rate.csv").read_text(encoding="utf-8").splitlines()))
    assert [float(r["micro_Nm"]) for r in rows] == pytest.approx(data["torque_over_rate"][2]["amplitude_Nm"], rel=1e-5)
    picture = (out / "figures" / "torque_over_rate.svg").read_text(encoding="utf-8")
    assert picture.count("least to largest of 2 mechanisms that may be true") == 3
    assert picture.count("at the values believed") == 3
    for name in ("torque_over_rate", "standard_errors", "step_loss"):
        for suffix in ("svg", "png"):
            assert (out / "figures" / f"{name}.{suffix}").stat().st_size > 1000


@pytest.mark.slow
def test_the_proposed_campaign_can_be_driven_and_looked_at_again(run, designed, tmp_path):
    """Truth: the proposal read back has the commands chosen, and a design of it predicts the same errors."""
    out, again = shutil.copytree(designed[0], designed[0].parent / "copy"), tmp_path / "again"
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


@pytest.mark.slow
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


@pytest.mark.slow
def test_one_parameter_can_be_the_aim(run, planned, tmp_path):
    """Truth: of one mechanism the criterion is the logarithm of that parameter's error over its value."""
    text = SMALL.replace("mechanisms = 2", "mechanisms = 1")
    (planned / "design.toml").write_text(text, encoding="utf-8")
    out = tmp_path / "out"
    result = run("design", planned, "--out", out, "--criterion", "friction.static", "--total-s", "4.0")
    assert result.exit_code == 0, result.stderr
    data = read(out)
    assert data["criterion"]["is_parameter"]
    (static,) = [p for p in data["parameters"] if p["name"] == "friction.static"]
    for which in ("planned", "chosen"):
        expected = np.exp(data[which]["criterion"]) * static["value"]
        assert static[f"{which}_spread"][0] == pytest.approx(expected, rel=1e-6)
    assert data["chosen"]["criterion"] < data["planned"]["criterion"]
    assert "by the standard error of friction.static" in result.stdout.lower()


@pytest.mark.parametrize(
    ("change", "code", "message"),
    [
        (("campaign.toml", "[[record]]", '[[record]]\nuse = "validate"'), 2, 'no record has use = "estimate"'),
        (("design.toml", "[limits]", '[limits]\nkeep = ["micro_64"]'), 2, 'no record "micro_64"; did you mean'),
        (("design.toml", "[limits]", '[criterion]\nkind = "gear.stifness"\n[limits]'), 2, 'did you mean "gear.stiff'),
        (("design.toml", "[limits]", "[limmits]"), 3, 'limmits: unknown key; did you mean "limits"'),
    ],
)
def test_what_is_wrong_is_one_line(refused, planned, tmp_path, change, code, message):
    name, old, new = change
    path = planned / name
    path.write_text(path.read_text(encoding="utf-8").replace(old, new, 1), encoding="utf-8")
    assert message in refused(code, "design", planned, "--out", tmp_path / "out")


def test_a_design_does_not_replace_its_own_campaign(refused, planned):
    assert "holds the campaign itself" in refused(2, "design", planned, "--out", planned)


@pytest.mark.slow
def test_lent_out_it_is_the_same_to_the_last_bit(lent, planned):
    """Truth: the files of the run in threads."""
    lent("design", planned, files=["design.json", "campaign.toml"], least=20)
