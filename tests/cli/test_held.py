"""A command is refused, with exit code 2, a folder that another run holds. Truth: what was in the folder before."""

import json
import shutil
import subprocess
import sys

import pytest

from held_by import hold_by_parent
from mechid.budgets.example import write_example
from mechid.locks import LOCK_NAME, hold_folder
from mechid.locks.folder import GUARD_NAME

VERBS = {
    "identify": ["bench"],
    "demo": [],
    "diagnose": ["fit"],
    "profile": ["fit", "--parameter", "housing.gain"],
    "bootstrap": ["fit"],
    "budget": ["fit/budget.toml"],
    "design": ["bench"],
    "fleet": ["fit"],
    "export": ["fit", "--to", "c"],
    "simulate": ["bench"],
    "look": ["bench/full_46.csv"],
    "compare": ["fit", "other"],
    "check": ["bench"],
}


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture
def there(fitted, tmp_path):
    """Return a folder with a campaign, two fits of it and a budget file."""
    folder = shutil.copytree(fitted, tmp_path / "there")
    shutil.copytree(folder / "fit", folder / "other")
    write_example(folder / "fit")
    return folder


@pytest.mark.parametrize("verb", VERBS)
def test_a_folder_that_another_run_holds_is_2(refused, there, tmp_path, verb):
    out, places = tmp_path / "out", ("bench", "fit", "other")
    pid = hold_by_parent(out)
    before = contents(out)
    arguments = [there / one if one.startswith(places) else one for one in VERBS[verb]]
    line = refused(2, verb, *arguments, "--out", out)
    assert f"{out}: another run is using it: mechid identify bench (process {pid} on " in line
    assert line.endswith("wait until it has ended, or give another folder")
    assert contents(out) == before


def test_a_report_of_a_folder_that_another_run_holds_is_2(refused, there):
    hold_by_parent(there / "fit")
    assert "another run is using it" in refused(2, "report", there / "fit")


def test_a_new_campaign_in_a_folder_that_another_run_holds_is_2(refused, tmp_path):
    hold_by_parent(tmp_path)
    assert "another run is using it" in refused(2, "new", tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {LOCK_NAME, GUARD_NAME}


def test_a_campaign_of_a_fleet_whose_folder_is_held_is_named(run, fitted, tmp_path):
    pid = hold_by_parent(tmp_path / "units" / "bench")
    result = run("fleet", fitted / "bench", "--out", tmp_path)
    assert result.exit_code == 5
    assert f"units/bench: another run is using it: mechid identify bench (process {pid} on " in result.stderr
    assert not (tmp_path / LOCK_NAME).exists()


SECOND = "import sys; from mechid.cli import main; sys.argv[0] = 'mechid'; main()"


@pytest.mark.slow
def test_of_two_runs_into_one_folder_one_is_refused_and_the_other_undisturbed(fitted, tmp_path):
    """Truth: the estimate of a run alone, to the last digit."""
    command = [sys.executable, "-c", SECOND, "identify", str(fitted / "bench"), "--out", str(tmp_path)]
    pipes = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True}
    running = [subprocess.Popen(command, **pipes) for _ in range(2)]
    said = [run.communicate()[1] for run in running]
    codes = [run.returncode for run in running]
    assert sorted(codes) == [0, 2], said
    (one,) = said[codes.index(2)].splitlines()
    assert f"another run is using it: mechid identify {fitted / 'bench'} " in one
    assert f"(process {running[codes.index(0)].pid} on " in one
    alone, here = (json.loads((at / "estimate.json").read_text()) for at in (fitted / "fit", tmp_path))
    assert here["parameters"] == alone["parameters"]
    assert not (tmp_path / LOCK_NAME).exists()


def test_the_folder_is_free_after_every_end(run, refused, fitted, tmp_path):
    assert "is not in the fit" in refused(2, "profile", fitted / "fit", "--parameter", "no", "--out", tmp_path / "out")
    with hold_folder(tmp_path / "out"):
        pass
    assert not (tmp_path / "out").exists()
