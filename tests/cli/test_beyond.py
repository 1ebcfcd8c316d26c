"""``mechid profile`` and ``mechid bootstrap``. Truth: the standard errors of a nearly linear fit, and earlier draws."""

import csv
import json
import shutil

import pytest

FREE = ("housing.gain", "housing.damping")


def rows(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_profile_leaves_its_interval_and_its_points(fitted, run, tmp_path):
    """Truth: with two nearly linear unknowns the interval is that of the standard error, to 2 %."""
    result = run("profile", fitted / "fit", "--parameter", "housing.gain", "--out", tmp_path / "p")
    assert result.exit_code == 0, result.stderr
    content = json.loads((tmp_path / "p" / "profile.json").read_text())["profiles"]["housing.gain"]
    width, local = (b - a for a, b in (content["ci95"], content["ci95_local"]))
    assert width == pytest.approx(
        local * content["level"] ** 0.5 / 1.959964 * content["std_error_white"] / content["std_error"], rel=0.02
    )
    points = rows(tmp_path / "p" / "profile.csv")
    assert [float(p["value"]) for p in points] == [p["value"] for p in content["points"]]
    assert "profile from" in result.stdout
    assert "cost rises by" in result.stderr


def test_a_resumed_profile_works_nothing_out_twice(fitted, run, tmp_path):
    arguments = ("profile", fitted / "fit", "--parameter", "housing.damping", "--out", tmp_path)
    assert run(*arguments).exit_code == 0
    first = (tmp_path / "profile.json").read_text()
    steps = (tmp_path / "profile.jsonl").read_text().count('"event": "step"')
    assert run(*arguments, "--resume").exit_code == 0
    assert (tmp_path / "profile.json").read_text() == first
    assert (tmp_path / "profile.jsonl").read_text().count('"event": "step"') == steps


def test_a_bootstrap_leaves_a_line_for_each_draw_and_may_grow(fitted, run, tmp_path):
    """Truth: the draws of the first run are the first of the second."""
    arguments = ("bootstrap", fitted / "bench" / "campaign.toml", "--out", tmp_path)
    shutil.copy(fitted / "fit" / "estimate.json", fitted / "bench")
    assert run(*arguments, "--draws", 4).exit_code == 0
    first = rows(tmp_path / "bootstrap.csv")
    result = run(*arguments, "--draws", 6, "--resume")
    assert result.exit_code == 0, result.stderr
    second = rows(tmp_path / "bootstrap.csv")
    assert (len(first), len(second)) == (4, 6)
    assert second[:4] == first
    content = json.loads((tmp_path / "bootstrap.json").read_text())
    assert sum(content["tally"].values()) == content["draws"] == 6
    assert set(content["parameters"]) == set(FREE)


def test_what_the_fit_did_not_move_is_a_usage_error(fitted, refused, tmp_path):
    line = refused(2, "profile", fitted / "fit", "--parameter", "gear.stifness", "--out", tmp_path)
    assert "--parameter gear.stifness: is not in the fit" in line


def test_a_folder_without_a_fit_is_refused(refused, tmp_path):
    assert f"{tmp_path}/estimate.json: there is no such file" in refused(3, "bootstrap", tmp_path, "--out", tmp_path)


def test_a_folder_that_is_not_there_is_named_itself(refused, tmp_path):
    """Not an estimate.json of the folder above, which nobody gave."""
    away = tmp_path / "fit"
    for arguments in (("diagnose",), ("bootstrap",), ("profile", "--parameter", "housing.gain")):
        line = refused(3, *arguments, away, "--out", tmp_path / "out")
        assert f"{away}: there is no such folder or file; give the result folder of mechid identify" in line
    assert not (tmp_path / "out").exists()


def test_a_campaign_that_has_changed_since_is_refused(fitted, refused, tmp_path):
    other = shutil.copytree(fitted / "bench", tmp_path / "bench")
    (other / "campaign.toml").write_text((other / "campaign.toml").read_text() + "\n# later\n")
    line = refused(
        3, "profile", fitted / "fit", "--campaign", other, "--parameter", "housing.gain", "--out", tmp_path / "p"
    )
    assert "campaign.toml is not the file that was identified; identify anew" in line


def test_a_fit_that_does_not_say_its_campaign_wants_it(fitted, refused, tmp_path):
    shutil.copy(fitted / "fit" / "estimate.json", tmp_path)
    line = refused(3, "bootstrap", tmp_path, "--out", tmp_path / "b")
    assert "give it as --campaign" in line
