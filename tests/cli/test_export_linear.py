"""``mechid export --to linear`` from a shell, and the same from Python."""

import json

import pytest

from layouts import mechanism_of
from mechid.exports.document import PAGES
from paper_estimate import estimate_of, write_estimate_of_paper
from paper_estimate import write_estimate as write_signed

FEW = ("--option", "rates=none", "--option", "samples=2")


@pytest.fixture
def fit(tmp_path):
    """Return the folder of a finished fit of the paper's mechanism."""
    folder = tmp_path / "fit"
    folder.mkdir()
    write_estimate_of_paper(folder)
    return folder


def changed_grade(fit, grade):
    path = fit / "estimate.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    content["grade"] = grade
    path.write_text(json.dumps(content), encoding="utf-8")


def test_it_writes_and_says_what(run, fit, bench, tmp_path):
    """Truth: the files of the contract, the campaign's start angle, the check, and the grade."""
    out = tmp_path / "new" / "out"
    result = run("export", fit, "--campaign", bench / "campaign.toml", "--to", "linear", "--out", out, *FEW)
    assert result.exit_code == 0, result.stderr
    assert sorted(p.name for p in out.iterdir()) == sorted(
        ["linear.json", "linear.mat", "mechid_export.json", "mechid_uss.m", *PAGES]
    )
    said = " ".join(result.stdout.split())
    for part in ("Checked against the nonlinear equations", "45 electrical degrees", "The supply lets", "Grade A"):
        assert part in said
    data = json.loads((out / "linear.json").read_text(encoding="utf-8"))
    assert len(data["draws"]) == 2
    assert data["models"].keys() == {"stuck", "free"}


def test_a_fit_that_failed_is_handed_on_only_anyway(run, refused, fit, bench, tmp_path):
    """Truth: exit 5 in one line and nothing written; with --anyway the files, and the grade in them."""
    changed_grade(fit, "failed")
    asked = ("export", fit, "--campaign", bench / "campaign.toml", "--to", "linear", "--out", tmp_path / "out", *FEW)
    assert "--anyway" in refused(5, *asked)
    assert not (tmp_path / "out").exists()
    assert run(*asked, "--anyway").exit_code == 0
    said = json.loads((tmp_path / "out" / "mechid_export.json").read_text(encoding="utf-8"))
    assert said["provenance"]["grade"] == "failed"


def test_bad_input_in_one_line(refused, fit, bench, tmp_path):
    """Truth: usage is 2, a mechanism that no command steps 3; nothing is left behind."""
    asked = ("export", fit, "--campaign", bench / "campaign.toml", "--out", tmp_path / "out", "--to")
    assert 'did you mean "linear"' in refused(2, *asked, "liner")
    assert "samples: found -2" in refused(2, *asked, "linear", "--option", "samples=-2")
    assert "load.inertai" in refused(2, *asked, "linear", "--option", "load.inertai=2")
    (tmp_path / "file").write_text("", encoding="utf-8")
    there = tmp_path / "file" / "out"
    assert "is a file" in refused(2, "export", fit, "--to", "linear", "--out", there)
    table = {
        "assembly": "direct_torque_drive",
        "load": {"inertia": 0.01},
        "friction": {"static": 0.01, "coulomb": 0.005, "viscous": 0.01},
    }
    mechanism = mechanism_of(table)
    write_signed(fit, mechanism, estimate_of(mechanism, ["friction.coulomb"]))
    assert "follows a measured torque" in refused(3, *asked, "linear")
    out = tmp_path / "out"
    assert not out.exists() or not list(out.iterdir())
