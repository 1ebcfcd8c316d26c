"""A folder is held by one run; truth: the processes that are there."""

import contextvars
import errno
import json
import os
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

from mechid.errors import UnwritableError, UsageError
from mechid.locks import LOCK_NAME, hold_folder, sweep
from mechid.locks.folder import GUARD_NAME
from mechid.locks.holder import read_holder, this_process
from mechid.writing import atomic_file, staging_folder

HOLDER = """
    import sys, time
    from mechid.locks import hold_folder
    with hold_folder(sys.argv[1]):
        print("held", flush=True)
        time.sleep(600)
"""


@pytest.fixture
def other(tmp_path):
    """Return a process that holds ``tmp_path / "out"``."""
    command = [sys.executable, "-c", textwrap.dedent(HOLDER), str(tmp_path / "out")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "held\n"
        yield process
        process.kill()


def changed(lock, **fields):
    lock.write_text(json.dumps({**json.loads(lock.read_text()), **fields}))


def test_a_second_run_is_refused_with_who_holds_the_folder(other, tmp_path):
    refused = pytest.raises(
        UsageError, match=rf"out: another run is using it: -c .*\(process {other.pid} on .*, since 2"
    )
    with refused, hold_folder(tmp_path / "out"):
        raise AssertionError("not reached")
    assert other.poll() is None
    assert json.loads((tmp_path / "out" / LOCK_NAME).read_text())["pid"] == other.pid


def test_a_killed_run_holds_nothing(other, tmp_path):
    other.kill()
    other.wait()
    assert (tmp_path / "out" / LOCK_NAME).is_file()
    with hold_folder(tmp_path / "out"):
        assert json.loads((tmp_path / "out" / LOCK_NAME).read_text())["pid"] == os.getpid()
    assert not (tmp_path / "out" / LOCK_NAME).exists()


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
def test_a_killed_run_whose_end_nobody_has_asked_for_holds_nothing(other, tmp_path):
    """Truth: such a process keeps its number until its parent asks."""
    other.kill()
    while (state := Path(f"/proc/{other.pid}/stat").read_text().split()[2]) != "Z":
        assert state in "RSD"
        time.sleep(0.01)
    with hold_folder(tmp_path / "out"):
        pass


@pytest.mark.parametrize(
    ("fields", "is_taken"),
    [
        ({"host": "elsewhere"}, False),
        ({"host": "elsewhere", "within": "fleet"}, True),  # who gave the work out gives it out again
        ({"host": "elsewhere", "within": "another fleet"}, False),
        ({"within": "fleet"}, False),  # at work, here
    ],
)
@pytest.mark.parametrize("is_locked", [False, True], ids=["seen here alone", "locked for all machines"])
def test_a_hold_of_another_machine_counts_until_its_work_is_given_out(other, tmp_path, fields, is_taken, is_locked):
    """A file system may lock for all machines or for one alone, where this process then gets the lock."""
    changed(tmp_path / "out" / LOCK_NAME, **fields)
    if "host" in fields and not is_locked:
        (tmp_path / "out" / GUARD_NAME).unlink()
    if is_taken:
        with hold_folder(tmp_path / "out", within="fleet"):
            assert json.loads((tmp_path / "out" / LOCK_NAME).read_text())["pid"] == os.getpid()
        return
    remedy = "wait until it has ended, or give another folder"
    if "host" in fields:
        remedy += r"; if that run no longer exists, which this machine cannot check, remove .*out/\.mechid\.\*lock"
    with pytest.raises(UsageError, match=f"{remedy}$"), hold_folder(tmp_path / "out", within="fleet"):
        raise AssertionError("not reached")


@pytest.mark.skipif(sys.platform == "win32", reason="for file systems of Unix")
@pytest.mark.parametrize("number", [errno.ENOSYS, errno.ENOLCK])
def test_a_file_system_that_locks_no_files_is_held_too(tmp_path, monkeypatch, number):
    """Truth: some network file systems answer so; a file that is there or not stands for the lock."""

    def unable(*_):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr("fcntl.flock", unable)
    with hold_folder(tmp_path / "out"):
        copied = contextvars.Context()  # which does not know that this process has it
        with pytest.raises(UsageError, match="another run is using it"):
            copied.run(lambda: hold_folder(tmp_path / "out").__enter__())
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("text", ["", "junk", "[]", '{"pid": "x"}', "\0"])
def test_a_lock_file_that_tells_of_nobody_holds_nothing(tmp_path, text):
    (tmp_path / LOCK_NAME).write_text(text)
    with hold_folder(tmp_path):
        assert read_holder((tmp_path / LOCK_NAME).read_text()).pid == os.getpid()


def test_who_holds_a_folder_holds_it_on(tmp_path):
    with hold_folder(tmp_path / "out") as outer:
        with hold_folder(tmp_path / "out") as inner:
            assert inner == outer
        assert (tmp_path / "out" / LOCK_NAME).is_file()
    assert not (tmp_path / "out").exists()  # made for nothing


def test_a_folder_that_was_there_stays_and_what_was_written_too(tmp_path):
    (tmp_path / "there").mkdir()
    with hold_folder(tmp_path / "there"):
        pass
    with hold_folder(tmp_path / "made" / "with parents"):
        (tmp_path / "made" / "with parents" / "a.json").write_text("1")
    assert [path.name for path in (tmp_path / "there").iterdir()] == []
    assert [path.name for path in (tmp_path / "made" / "with parents").iterdir()] == ["a.json"]


RACER = """
    import sys, time
    from pathlib import Path
    from mechid.errors import UsageError
    from mechid.locks import hold_folder
    print("ready", flush=True)
    sys.stdin.readline()
    try:
        with hold_folder(sys.argv[1]):
            print("held", flush=True)
            sys.stdin.readline()
    except UsageError:
        print("refused", flush=True)
"""


@pytest.mark.parametrize("stale", [False, True])
def test_of_four_that_begin_at_once_one_holds(tmp_path, stale):
    if stale:
        (tmp_path / LOCK_NAME).write_text(this_process().text())
    command = [sys.executable, "-c", textwrap.dedent(RACER), str(tmp_path)]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    racers = [subprocess.Popen(command, **pipes) for _ in range(4)]
    for word in ("ready\n",):
        assert [racer.stdout.readline() for racer in racers] == [word] * 4
    for racer in racers:
        racer.stdin.write("go\n")
        racer.stdin.flush()
    assert sorted(racer.stdout.readline() for racer in racers) == ["held\n", *["refused\n"] * 3]
    for racer in racers:
        racer.communicate("end\n")


def test_what_a_killed_run_left_half_written_goes(other, tmp_path):
    out = tmp_path / "out"
    (out / "figures").mkdir()
    (out / "units" / "a").mkdir(parents=True)
    other.kill()
    other.wait()
    gone = [out / f".report.json.{other.pid}.part", out / "figures" / f".torque.svg.{other.pid}.part"]
    kept = [
        out / f".report.html.{os.getpid()}.part",
        out / ".part",
        out / "notes.part",
        out / ".notes.part",
        out / "units" / "a" / f".estimate.json.{other.pid}.part",
    ]
    for path in (*gone, *kept):
        path.write_text("half")
    (out / f".export.{other.pid}.part").mkdir()
    (out / f".export.{other.pid}.part" / "mechanism.c").write_text("half")
    with hold_folder(out):
        assert sorted(path for path in out.rglob("*part") if path.exists()) == sorted(kept)


def test_what_is_being_written_beside_its_place_has_a_name_that_is_swept(tmp_path):
    with atomic_file(tmp_path / "a.json") as beside, staging_folder(tmp_path, "export") as folder:
        beside.write_text("half")
        assert sweep(tmp_path) == []  # this process is at work on them
        for path in (beside, folder):
            path.rename(path.with_name(path.name.replace(str(os.getpid()), str(2**22 + 1))))
        assert len(sweep(tmp_path)) == 2
        assert list(tmp_path.iterdir()) == []
        beside.write_text("whole")


def test_folders_held_by_themselves_are_not_swept(tmp_path):
    (tmp_path / "budget").mkdir()
    (tmp_path / "budget" / LOCK_NAME).write_text("{}")
    (tmp_path / "budget" / f".a.json.{2**22 + 1}.part").write_text("half")
    assert sweep(tmp_path) == []


def test_a_folder_that_cannot_be_held_is_the_users_error(tmp_path):
    (tmp_path / "file").write_text("")
    for name in ("file/x", "x" * 300):
        refused = pytest.raises(UnwritableError, match=r"cannot be written to \(.+\); give another folder$")
        with refused, hold_folder(tmp_path / name):
            raise AssertionError("not reached")
