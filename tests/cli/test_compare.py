"""`mechid compare`. Truth: a bench made with a gear of its own, fitted with that gear free and held wrong."""

import json
import shutil

import pytest

HELD_OUT = ('name = "micro_46"', 'name = "micro_46"\nuse = "validate"')


@pytest.fixture
def identified(run, staged, changed, tmp_path, without_reports):
    """Return a function that identifies a campaign into a folder; the staged one has a record held out."""
    changed("campaign.toml", *HELD_OUT)

    def identify(folder, name):
        out = tmp_path / "fit" / name
        result = run("identify", folder, "--out", out, "--workers", 1)
        assert result.exit_code == 0, result.stderr
        return out

    return identify


@pytest.fixture
def fits(identified, staged, tmp_path):
    """Return the folders of two fits of the same records: stiffness and damping free, and damping held 30 % off."""
    other = shutil.copytree(staged, tmp_path / "held")
    campaign = (other / "campaign.toml").read_text()
    (other / "campaign.toml").write_text(campaign.replace(', "gear.damping"]', "]"))
    mechanism = (other / "mechanism.toml").read_text()
    line = next(line for line in mechanism.splitlines() if line.startswith("damping = { value = 0.48"))
    (other / "mechanism.toml").write_text(mechanism.replace(line, "damping = 0.507"))
    return [identified(staged, "both_free"), identified(other, "held_wrong")]


def test_the_hypothesis_that_made_the_records_is_preferred(run, fits, tmp_path):
    result = run("compare", *fits, "--out", tmp_path / "verdict")
    assert result.exit_code == 0, result.stderr
    said = result.stdout.splitlines()
    assert said[0] == "SYNTHETIC: the records were simulated, nothing of this was measured."
    assert said[1].endswith("Preferred: both_free.")
    data = json.loads((tmp_path / "verdict" / "comparison.json").read_text())
    assert data["outcome"]["code"] == "agreed"
    assert next(r for r in data["records"] if r["name"] == "micro_46")["use"] == "validate"
    assert f"written: {tmp_path / 'verdict' / 'comparison.json'}" in result.stdout


def test_other_records_are_refused(refused, identified, staged):
    before = identified(staged, "before")
    path = staged / "full_46.csv"
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:-1], lines[-1].split(",")[0] + ",0.0"]) + "\n")
    line = refused(2, "compare", before, identified(staged, "other"))
    assert 'record "full_46": other samples' in line


def test_what_is_no_result_folder_is_refused(refused, staged):
    assert 'there is no such file; "mechid identify" writes it' in refused(3, "compare", staged, staged / "elsewhere")
    assert "give two or more" in refused(2, "compare", staged)
