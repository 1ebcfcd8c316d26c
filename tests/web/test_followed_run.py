"""A run elsewhere, followed by its journal. Truth: what was noted."""

import math
import os
import time

import pytest

from mechid.identification.computation.journal import Journal
from mechid.web.fit_run import RunState
from mechid.web.followed_run import SILENT_S, FollowedRun

ENTRY = {"number": 1, "total": 4, "stage": "multi-start", "line": "9 of 2048 starts", "elapsed_s": 0.5}


@pytest.fixture
def path(tmp_path):
    return tmp_path / "journal.jsonl"


def test_it_follows_what_is_noted_as_it_is_noted(path):
    followed = FollowedRun(path)
    followed.poll()
    assert (followed.is_alive, followed.reports) == (False, [])
    journal = Journal.open(path, {"a": "b"})
    journal.note("progress", **ENTRY, cost=12.5, values={"gear.stiffness": 900.0})
    followed.poll()
    assert followed.state is RunState.RUNNING
    assert [(r.stage, r.cost, dict(r.values)) for r in followed.reports] == [
        ("multi-start", 12.5, {"gear.stiffness": 900.0})
    ]
    journal.note("progress", **ENTRY, cost=None, values={}, over_noise={"full_46": 3.5, "sweep": None})
    followed.poll()
    assert followed.reports.pop().over_noise == {"full_46": 3.5, "sweep": math.inf}
    with path.open("a") as file:
        file.write('{"event": "progress", "half')
    followed.poll()
    assert len(followed.reports) == 1
    with path.open("a") as file:
        file.write('"}\n[1]\n')
    journal.note("finished", outcome="converged", message="")
    followed.poll()
    assert (followed.state, followed.is_alive) == (RunState.FINISHED, True)
    assert not followed.has_written("estimate.json")
    path.with_name("estimate.json").write_text("{}")
    assert followed.has_written("estimate.json")


def test_a_run_that_ended_before_is_not_alive(path):
    Journal.open(path, {}).note("finished", outcome="converged", message="")
    followed = FollowedRun(path)
    followed.poll()
    assert (followed.state, followed.is_alive) == (RunState.FINISHED, False)


def test_a_run_that_is_silent_for_long_is_taken_for_dead(path):
    Journal.open(path, {})
    long_ago = time.time() - SILENT_S - 1.0
    os.utime(path, (long_ago, long_ago))
    followed = FollowedRun(path)
    followed.poll()
    assert (followed.state, followed.is_alive) == (RunState.CANCELLED, False)
