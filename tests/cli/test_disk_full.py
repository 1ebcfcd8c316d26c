"""A disk that is full is exit code 2, with what was saved in the line. Truth: the files that are there afterwards.

The system itself refuses to write: the most bytes a file of this process may have stand for the room on the disk.
"""

import errno
import json
import os
import shutil
import subprocess
import sys
from contextlib import contextmanager

import pytest

from mechid.budgets.example import BUDGET, BUDGET_NAME, write_example
from mechid.errors import UnwritableError
from mechid.locks import hold_folder
from mechid.writing import creating_folder, write_together

resource = pytest.importorskip("resource")

HEAD, _, SLEW, _ = BUDGET.split("[[mode]]\n")
ONE_RATE = f"{HEAD}[[mode]]\n{SLEW}[[error]]{BUDGET.partition('[[error]]')[2]}"
"""The example budget with one operating mode at one rate."""


@contextmanager
def room(most):
    """Let no file of this process, or of those that it starts, be longer."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.fixture
def there(fitted, tmp_path):
    folder = shutil.copytree(fitted, tmp_path / "there")
    (folder / "fit" / BUDGET_NAME).write_text(ONE_RATE)
    write_example(folder / "fit")
    return folder


def parts(folder):
    return [path for path in folder.rglob("*") if path.name.endswith(".part") or path.name.startswith(".")]


VERBS = {
    "simulate": ["bench"],
    "look": ["bench/full_46.csv"],
    "check": ["bench"],
    "diagnose": ["fit", "--consider", "gear.backlash"],
    "export c": ["fit", "--to", "c"],
    "export tables": ["fit", "--to", "tables", "--option", "rates=46"],
    "export linear": ["fit", "--to", "linear"],
    "profile": ["fit", "--parameter", "housing.gain"],
    "bootstrap": ["fit", "--draws", "2"],
    "budget": ["fit/budget.toml"],
}


SLOW = ("diagnose", "export linear", "budget")


@pytest.mark.parametrize(
    "verb", [pytest.param(verb, marks=pytest.mark.slow) if verb in SLOW else verb for verb in VERBS]
)
def test_a_full_disk_is_2_and_leaves_nothing_half_written(run, refused, there, tmp_path, verb):
    arguments = [there / one if one.startswith(("bench", "fit")) else one for one in VERBS[verb]]
    out = tmp_path / "out"
    with room(900):
        line = refused(2, verb.split()[0], *arguments, "--out", out)
    if "the kernel cannot be kept there" in line:  # none was compiled on this machine yet: with it there, once more
        run(verb.split()[0], *arguments, "--out", tmp_path / "before")
        with room(900):
            line = refused(2, verb.split()[0], *arguments, "--out", out)
    assert f"{out}: cannot be written to (File too large); make room, or give another folder; " in line
    saved = line.partition("folder; ")[2]
    there = sorted(path.name for path in out.rglob("*") if path.is_file()) if out.exists() else []
    assert saved == (f"saved before: {', '.join(there)}" if there else "nothing was saved")


def test_a_full_disk_under_the_journal_stops_the_identification(refused, there, tmp_path):
    with room(500):
        line = refused(2, "identify", there / "bench", "--out", tmp_path / "out")
    assert line.endswith("make room, or give another folder; saved before: journal.jsonl")
    lines = (tmp_path / "out" / "journal.jsonl").read_text().splitlines(keepends=True)
    assert parts(tmp_path / "out") == []
    assert all(json.loads(one) for one in lines if one.endswith("\n"))


def test_a_full_disk_under_the_report_is_2_and_says_that_the_estimate_is_saved(refused, run, there, tmp_path):
    """Truth: the estimate of a disk with room; with room again, report and --resume go on from there."""
    out = tmp_path / "out"
    largest = max((there / "fit" / name).stat().st_size for name in ("estimate.json", "report.json", "journal.jsonl"))
    assert (there / "fit" / "report.html").stat().st_size > 2 * largest
    with room(2 * largest):
        line = refused(2, "identify", there / "bench", "--out", out)
    saved = line.partition("make room, or give another folder; saved before: ")[2]
    assert "estimate.json" in saved
    assert "report.html" not in saved
    estimate, whole = (json.loads((at / "estimate.json").read_text()) for at in (out, there / "fit"))
    assert estimate["parameters"] == whole["parameters"]
    assert parts(out) == []
    assert run("report", out).exit_code == 0
    assert (out / "report.html").is_file()


def test_an_earlier_result_stays_whole_where_there_is_no_room_for_the_new(refused, there):
    before = {path.name: path.read_bytes() for path in (there / "fit").glob("*.json")}
    with room(1000):
        line = refused(2, "report", there / "fit")
    assert "saved before: " not in line or ".json" not in line
    assert {path.name: path.read_bytes() for path in (there / "fit").glob("*.json")} == before


def test_what_fails_within_a_target_is_not_called_a_folder_that_cannot_be_written_to(tmp_path):
    """Truth: the errors of what is elsewhere: a program that is missing, a port that is taken."""
    elsewhere = FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), "/usr/bin/no-such-compiler")
    for error in (elsewhere, OSError(errno.EADDRINUSE, "port"), TimeoutError("slow")):
        with pytest.raises(type(error)) as raised, hold_folder(tmp_path / "out"), creating_folder(tmp_path / "out"):
            raise error
        assert raised.value is error


@pytest.mark.parametrize(
    "error",
    [
        OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)),
        OSError(errno.EDQUOT, os.strerror(errno.EDQUOT)),
        OSError("Unable to write (No space left on device)"),
    ],
)
def test_no_room_is_said_wherever_it_is_met(tmp_path, error):
    said = pytest.raises(UnwritableError, match=r"out: cannot be written to \(.+folder; saved before: a.json, b.json$")
    with said, hold_folder(tmp_path / "out"):
        write_together(tmp_path / "out", {"a.json": "1", "b.json": "2"})
        raise error


HDF5 = """
import resource, sys
from pathlib import Path
import h5py, numpy
from mechid.errors import UnwritableError
from mechid.writing import buffered_file, creating_folder
resource.setrlimit(resource.RLIMIT_FSIZE, (9000, resource.RLIM_INFINITY))
try:
    place = Path(sys.argv[1])
    with creating_folder(place), buffered_file(place / "a.h5") as content, h5py.File(content, "w") as file:
        file["x"] = numpy.arange(5000.0)
except UnwritableError as error:
    print(error)
"""


def test_a_full_disk_under_hdf5_is_an_error_and_no_crash(tmp_path):
    """Truth: written to the disk itself, h5py 3.16 ends Python with a segmentation fault on a full one."""
    pytest.importorskip("h5py")
    done = subprocess.run([sys.executable, "-c", HDF5, str(tmp_path)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"{tmp_path}: cannot be written to (File too large); make room, or give another folder\n"
    assert list(tmp_path.iterdir()) == []
