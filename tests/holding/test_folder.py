"""A folder is held by one run; truth: the processes that are there."""

import json
import os
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import psutil
import pytest

from mechid.errors import UnwritableError, UsageError
from mechid.holding import LOCK_NAME, held, sweep
from mechid.holding.holder import Life, beginning, read_holder, this_process
from mechid.writing import atomic_file, staging_folder

HOLDER = """
    import sys, time
    from mechid.holding import held
    with held(sys.argv[1]):
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
    refused = pytest.raises(UsageError, match=rf"out: another run holds it: -c .*\(process {other.pid} on .*, since 2")
    with refused, held(tmp_path / "out"):
        raise AssertionError("not reached")
    assert other.poll() is None
    assert json.loads((tmp_path / "out" / LOCK_NAME).read_text())["pid"] == other.pid


def test_a_killed_run_holds_nothing(other, tmp_path):
    other.kill()
    other.wait()
    assert (tmp_path / "out" / LOCK_NAME).is_file()
    with held(tmp_path / "out"):
        assert json.loads((tmp_path / "out" / LOCK_NAME).read_text())["pid"] == os.getpid()
    assert not (tmp_path / "out" / LOCK_NAME).exists()


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
def test_a_killed_run_whose_end_nobody_has_asked_for_holds_nothing(other, tmp_path):
    """Truth: such a process keeps its number until its parent asks."""
    other.kill()
    while (state := Path(f"/proc/{other.pid}/stat").read_text().split()[2]) != "Z":
        assert state in "RSD"
        time.sleep(0.01)
    with held(tmp_path / "out"):
        pass


@pytest.mark.parametrize(
    ("fields", "is_taken"),
    [
        ({"began": "17"}, True),  # another process has the number now
        ({"system": "another-start/pid:[1]"}, True),
        ({"host": "elsewhere"}, False),
        ({"host": "elsewhere", "within": "fleet"}, True),  # who gave the work out gives it out again
        ({"host": "elsewhere", "within": "another fleet"}, False),
        ({"within": "fleet"}, False),  # at work, here
    ],
)
def test_a_stale_hold_is_told_from_one_at_work(other, tmp_path, fields, is_taken):
    changed(tmp_path / "out" / LOCK_NAME, **fields)
    if is_taken:
        with held(tmp_path / "out", within="fleet"):
            pass
        return
    remedy = "wait until it has ended, or give another folder" + (
        rf"; should it be gone, which cannot be seen from here, remove .*out/{LOCK_NAME}" if "host" in fields else ""
    )
    with pytest.raises(UsageError, match=f"{remedy}$"), held(tmp_path / "out", within="fleet"):
        raise AssertionError("not reached")


@pytest.mark.parametrize("text", ["", "junk", "[]", '{"pid": "x"}', "\0"])
def test_a_lock_file_that_tells_of_nobody_holds_nothing(tmp_path, text):
    (tmp_path / LOCK_NAME).write_text(text)
    with held(tmp_path):
        assert read_holder((tmp_path / LOCK_NAME).read_text()).pid == os.getpid()


def test_who_holds_a_folder_holds_it_on(tmp_path):
    with held(tmp_path / "out") as outer:
        with held(tmp_path / "out") as inner:
            assert inner == outer
        assert (tmp_path / "out" / LOCK_NAME).is_file()
    assert not (tmp_path / "out").exists()  # made for nothing


def test_a_folder_that_was_there_stays_and_what_was_written_too(tmp_path):
    (tmp_path / "there").mkdir()
    with held(tmp_path / "there"):
        pass
    with held(tmp_path / "made" / "with parents"):
        (tmp_path / "made" / "with parents" / "a.json").write_text("1")
    assert [path.name for path in (tmp_path / "there").iterdir()] == []
    assert [path.name for path in (tmp_path / "made" / "with parents").iterdir()] == ["a.json"]


RACER = """
    import sys, time
    from pathlib import Path
    from mechid.errors import UsageError
    from mechid.holding import held
    print("ready", flush=True)
    sys.stdin.readline()
    try:
        with held(sys.argv[1]):
            print("held", flush=True)
            sys.stdin.readline()
    except UsageError:
        print("refused", flush=True)
"""


@pytest.mark.parametrize("stale", [False, True])
def test_of_four_that_begin_at_once_one_holds(tmp_path, stale):
    if stale:
        gone = {**vars(this_process()), "began": "17"}
        (tmp_path / LOCK_NAME).write_text(json.dumps(gone))
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
    with held(out):
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


def test_when_a_process_began_is_the_same_however_it_is_asked(other, monkeypatch):
    """Truth: this process, one that it began later, and a number above the largest.

    Not its parent: a shell and what it runs may begin within one tick of the system's clock.
    """
    own = beginning(os.getpid())
    assert own
    assert own != beginning(other.pid)
    assert beginning(2**22 + 1) == ""
    monkeypatch.setattr(sys, "platform", "darwin")
    assert beginning(os.getpid()) == str(round(psutil.Process().create_time()))
    assert beginning(2**22 + 1) == ""
    assert this_process().life is Life.HERE


def test_a_folder_that_cannot_be_held_is_the_users_error(tmp_path):
    (tmp_path / "file").write_text("")
    for name in ("file/x", "x" * 300):
        refused = pytest.raises(UnwritableError, match=r"cannot be written to \(.+\); give another folder$")
        with refused, held(tmp_path / name):
            raise AssertionError("not reached")
