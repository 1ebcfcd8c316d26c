"""``--scheduler``: a real Dask scheduler and real worker processes. Truth: the run in threads of one process."""

import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

import chores
from dask_cluster import cluster
from mechid.errors import WorkersError
from mechid.identification.computation import workforce
from mechid.identification.computation.parallel import map_tasks
from mechid.identification.computation.settings import WORK
from mechid.identification.computation.workforce import working_on_scheduler

WAIT_S = 120.0
DRAWS = 400
"""So many that they last for seconds."""


@pytest.fixture(scope="module")
def workers(tmp_path_factory):
    """Return a cluster of two workers; not to be harmed."""
    with cluster(tmp_path_factory.mktemp("cluster"), workers=2) as here:
        yield here


@pytest.fixture(scope="module")
def local(fitted, tmp_path_factory):
    """Return the folder of the same bootstrap in threads."""
    out = tmp_path_factory.mktemp("local")
    assert ended(begun(fitted, out)) == 0
    return out


def begun(fitted, out, *further, draws=DRAWS):
    """Start the bootstrap of a fit as a shell would."""
    command = ["-m", "mechid", "bootstrap", fitted / "fit", "--out", out, "--draws", draws, *further]
    return subprocess.Popen(
        [sys.executable, *map(str, command)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
    )


def ended(process):
    """Return how a process ends, its standard error kept as its attribute."""
    watchdog = threading.Timer(WAIT_S, process.kill)
    watchdog.start()
    try:
        _, process.said = process.communicate()
    finally:
        watchdog.cancel()
    return process.returncode


def at_work(process, out, steps=10):
    """Wait until the journal of a process has so many steps."""
    journal = Path(out) / "bootstrap.jsonl"
    until = time.monotonic() + WAIT_S
    while not journal.is_file() or journal.read_text().count('"event": "step"') < steps:
        assert process.poll() is None, process.communicate()[1]
        assert time.monotonic() < until
        time.sleep(0.02)


def test_a_bootstrap_on_two_workers_is_the_same_to_the_last_bit(fitted, run, workers, tmp_path):
    found = {}
    for name, further in (("here", ()), ("there", ("--scheduler", workers.address))):
        result = run("bootstrap", fitted / "fit", "--out", tmp_path / name, "--draws", 8, *further)
        assert result.exit_code == 0, result.stderr
        found[name] = (tmp_path / name / "bootstrap.csv").read_bytes()
    assert found["here"] == found["there"]


def test_no_scheduler_at_the_address(fitted, refused, tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr(workforce, "WORK", replace(WORK, scheduler_patience_s=0.5))
    line = refused(2, "bootstrap", fitted / "fit", "--out", tmp_path, "--scheduler", "tcp://127.0.0.1:1")
    assert "--scheduler tcp://127.0.0.1:1: no Dask scheduler answers there" in line


def test_without_dask_it_is_named(fitted, refused, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    line = refused(2, "bootstrap", fitted / "fit", "--out", tmp_path, "--scheduler", "tcp://127.0.0.1:1")
    assert 'pip install "mechid[cluster]"' in line


@pytest.mark.slow
def test_a_worker_that_is_killed_costs_under_a_batch(tmp_path):
    """Truth: who was asked for what, as the workers noted it; tasks of 0.2 s, so five to a batch."""
    (tmp_path / "log").mkdir()
    tasks = range(60)
    with cluster(tmp_path, workers=2) as here, working_on_scheduler(here.address):
        victim = here.workers[0].pid
        threading.Thread(target=_killed_at_work, args=(tmp_path / "log", victim)).start()
        assert map_tasks(partial(chores.logged, tmp_path / "log", 0.2), tasks, 1) == [n**2 for n in tasks]
        done = chores.executions(tmp_path / "log")
    assert len(done[victim]) >= 10, "it had been at work"
    numbers = [number for each in done.values() for number in each]
    assert set(numbers) == set(tasks)
    assert 1 <= len(numbers) - len(tasks) <= 5


def _killed_at_work(folder, victim):
    while len(chores.executions(folder).get(victim, ())) < 10:
        time.sleep(0.01)
    os.kill(victim, signal.SIGKILL)


@pytest.mark.slow
def test_a_scheduler_that_is_lost_keeps_the_journal(fitted, local, tmp_path):
    """Truth: the same draws in threads, of which the resumed run works out only those that are left."""
    out = tmp_path / "out"
    with cluster(tmp_path, workers=1) as here:
        process = begun(fitted, out, "--scheduler", here.address)
        at_work(process, out)
        here.scheduler.kill()
        assert ended(process) == 2
    last = process.said.strip().splitlines()[-1]
    assert last.startswith("mechid: error: the workers are lost (their scheduler is gone)")
    assert "--resume goes on" in last
    assert "Traceback" not in process.said
    steps = (out / "bootstrap.jsonl").read_text().count('"event": "step"')
    assert 10 <= steps < DRAWS
    assert ended(begun(fitted, out, "--resume")) == 0
    assert (out / "bootstrap.csv").read_bytes() == (local / "bootstrap.csv").read_bytes()
    assert (out / "bootstrap.jsonl").read_text().count('"event": "step"') == DRAWS


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT to send to another process")
def test_ctrl_c_leaves_the_workers_free(fitted, local, workers, tmp_path):
    """Truth: the exit code of an interrupted command; another map on the same workers; the draws in threads."""
    process = begun(fitted, tmp_path, "--scheduler", workers.address)
    at_work(process, tmp_path)
    process.send_signal(signal.SIGINT)
    assert ended(process) == 130
    assert process.said.strip().splitlines()[-1] == "mechid: interrupted"
    assert "Traceback" not in process.said
    with working_on_scheduler(workers.address):
        assert map_tasks(partial(chores.squared, 1), range(5), 1) == [1, 4, 9, 16, 25]
    assert ended(begun(fitted, tmp_path, "--resume", "--scheduler", workers.address)) == 0
    assert (tmp_path / "bootstrap.csv").read_bytes() == (local / "bootstrap.csv").read_bytes()


@pytest.mark.slow
def test_a_worker_with_another_mechid_is_refused_by_name(tmp_path):
    """Truth: a copy of mechid with one line more, beside one that is the same."""
    import mechid

    shutil.copytree(Path(mechid.__file__).parent, tmp_path / "other" / "mechid")
    with (tmp_path / "other" / "mechid" / "errors.py").open("a") as file:
        file.write("\n# Another version.\n")
    with cluster(tmp_path, workers=1) as here:
        paths = os.pathsep.join([str(tmp_path / "other"), str(Path(chores.__file__).parent)])
        odd = here.add_worker(PYTHONPATH=paths)
        with (
            working_on_scheduler(here.address),
            pytest.raises(WorkersError, match=rf":{odd.pid} is refused: it has mechid 0"),
        ):
            map_tasks(partial(chores.logged, tmp_path, 0.1), range(200), 1)
