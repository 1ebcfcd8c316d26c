"""One campaign of a fleet, as a task. Truth: the files that are there before and after."""

import pickle

import pytest

from estimates import free
from mechid.fleets.unit_run import EstimateOrigin, UnitRun, run_unit, task_of
from synthetic_fleet import write_fit


@pytest.fixture
def task(member, tmp_path):
    """Return a function that makes the task of what is in a folder."""

    def make(folder):
        return task_of(member(str(folder)), tmp_path / "out", 0, 1, complete=False, hold="")

    return make


def test_a_finished_fit_without_a_campaign_is_taken_as_it_is(task, tmp_path):
    """Truth: nothing is written, and its own folder is named."""
    folder = write_fit(tmp_path / "a", {"gear.stiffness": free(900.0, 1.0)})
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    run = run_unit(task(folder))
    assert (run.how, run.folder, run.said) == (EstimateOrigin.GIVEN, str(folder.resolve()), "")
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    assert not (tmp_path / "out").exists()


def test_what_is_wrong_with_one_campaign_is_said_and_not_raised(task, tmp_path):
    """Truth: the campaign file's own error, in one line."""
    folder = tmp_path / "a"
    folder.mkdir()
    (folder / "campaign.toml").write_text("mechanism = 5\n", encoding="utf-8")
    run = run_unit(task(folder))
    assert run.how is EstimateOrigin.NONE
    assert run.said.startswith("campaign.toml: ")
    assert "\n" not in run.said
    assert run.words.startswith("no estimate (campaign.toml: ")


def test_a_task_is_plain_values(task, tmp_path):
    """Truth: what any other process gets of it."""
    made = task(tmp_path / "a")
    assert pickle.loads(pickle.dumps(made)) == made
    assert made.source == str((tmp_path / "a").resolve())
    assert made.folder.startswith(str((tmp_path / "out").resolve()))


def test_how_an_estimate_came_about_is_a_line():
    assert UnitRun(how=EstimateOrigin.IDENTIFIED, folder="a", seconds=2.04).words == "identified, 2.0 s"
    changed = UnitRun(how=EstimateOrigin.CHANGED, folder="a", said="changed: mechanism.toml", seconds=1.0)
    assert changed.words == "identified anew (changed: mechanism.toml), 1.0 s"
