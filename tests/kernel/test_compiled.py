"""A kernel that is damaged on disk is made anew, by one process. Truth: its files, and what it gives."""

import gc
import os
import subprocess
import sys
import textwrap
import time
from types import SimpleNamespace

import pytest

import mechid
from mechid.kernel.cache_files import TAG, is_sealed, is_whole, lock_kernel, remove_kernel, seal
from mechid.kernel.compiled import aligned_zeros, compiled_module, kernel_for, lane_places

GIVEN = """
    from mechid.kernel.compiled import compiled_module
    written = []
    def text():
        written.append(1)
        return "from numba import njit\\n@njit(cache=True)\\ndef run(x):\\n    return x + 1.0\\n"
    module = compiled_module("kernel_1", text, lambda made: made.run(1.0))
    print(len(written), module.run(2.0), module.run.stats.cache_hits.total())
"""
MADE, LOADED = ["1", "3.0", "0"], ["0", "3.0", "1"]


def given(cache):
    command = [sys.executable, "-c", textwrap.dedent(GIVEN)]
    return subprocess.Popen(
        command,
        env={**os.environ, "MECHID_CACHE": str(cache)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def said(process):
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    assert err == ""
    return out.split()


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    """Return a cache in which two processes at once wanted one kernel, and what they said."""
    folder = tmp_path_factory.mktemp("cache")
    answers = [said(process) for process in [given(folder), given(folder)]]
    return folder, answers


def files(folder, suffix):
    return sorted(folder.rglob(f"*{suffix}"))


def test_two_processes_compile_one_kernel_once(cache):
    folder, answers = cache
    assert sorted(answers) == [LOADED, MADE]
    assert [len(files(folder, suffix)) for suffix in (".py", ".nbi", ".nbc", ".sums")] == [1, 1, 1, 1]
    assert said(given(folder)) == LOADED


def cut(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def turned(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 255
    path.write_bytes(content)


DAMAGES = {
    "an index of junk": (".nbi", lambda path: path.write_bytes(b"junk")),
    "an empty index": (".nbi", lambda path: path.write_bytes(b"")),
    "a cut kernel": (".nbc", cut),
    "an empty kernel": (".nbc", lambda path: path.write_bytes(b"")),
    "one bit of a kernel": (".nbc", turned),
    "a cut source": (".py", cut),
    "a lost kernel": (".nbc", lambda path: path.unlink()),
    "sums of junk": (".sums", lambda path: path.write_bytes(b"\xff")),
}


QUICK = ("one bit of a kernel", "sums of junk")


@pytest.mark.parametrize(
    "damage", [one if one in QUICK else pytest.param(one, marks=pytest.mark.slow) for one in DAMAGES]
)
def test_a_damaged_kernel_is_made_anew(cache, damage):
    folder, _ = cache
    suffix, spoil = DAMAGES[damage]
    spoil(files(folder, suffix)[0])
    (files(folder, ".py")[0].parent / ".kernel.py.4194305.part").write_text("half")  # of a process that was killed
    assert said(given(folder)) == MADE
    assert said(given(folder)) == LOADED
    assert files(folder, ".part") == []


def test_a_damaged_index_that_was_never_sealed_is_made_anew(cache):
    folder, _ = cache
    for suffix, spoil in ((".sums", lambda path: path.unlink()), (".nbi", lambda path: path.write_bytes(b"junk"))):
        spoil(files(folder, suffix)[0])
    assert said(given(folder)) == MADE
    assert said(given(folder)) == LOADED


def test_what_is_kept_is_whole_until_it_is_changed(tmp_path):
    path, compiled = tmp_path / "kernel_1.py", tmp_path / "__pycache__" / f"kernel_1.run-3{TAG}1.nbc"
    compiled.parent.mkdir()
    path.write_text("a = 1")
    compiled.write_bytes(b"code")
    assert not is_whole(path)
    assert not is_sealed(path)
    seal(path)
    assert is_whole(path)
    other = compiled.with_name("kernel_1.run-3.py27.1.nbc")  # of another version of Python, which shares the cache
    other.write_bytes(b"code")
    assert is_whole(path)
    seal(path)
    other.unlink()
    assert is_whole(path)
    compiled.write_bytes(b"cod3")
    assert not is_whole(path)
    assert is_sealed(path)
    remove_kernel(path)
    assert [file for file in tmp_path.rglob("*") if file.is_file()] == []


def test_a_process_that_is_killed_while_it_makes_a_kernel_stops_nobody(tmp_path):
    script = "import sys, time; from pathlib import Path; from mechid.kernel.cache_files import lock_kernel\n"
    script += "with lock_kernel(Path(sys.argv[1])): print('in', flush=True); time.sleep(600)"
    path = tmp_path / "kernel_1.py"
    with subprocess.Popen([sys.executable, "-c", script, str(path)], stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout.readline() == "in\n"
        other.kill()
        began = time.perf_counter()
        with lock_kernel(path):
            assert time.perf_counter() - began < 10.0


def test_the_source_is_the_text_that_is_compiled():
    """Truth: the file of the kernel that runs."""
    mechanism = mechid.catalogue_mechanism()
    assert mechid.kernel_source(mechanism) == kernel_for(mechanism.plant).text
    with pytest.raises(mechid.UsageError, match="-1 is negative"):
        mechid.kernel_source(mechanism, sensitivities=-1)


@pytest.mark.parametrize("size", [1, 8, 1000])
def test_a_workspace_starts_on_a_cache_line(size):
    """Truth: the address; 64 bytes are a line of every processor that Numba compiles for."""
    room = aligned_zeros(size)
    assert room.shape == (size,)
    assert room.ctypes.data % 64 == 0
    assert not room.any()


def test_lanes_stand_in_groups():
    """Truth: by hand; two lanes of a row side by side, the next group a whole group's rows further on."""
    module = SimpleNamespace(LANES_PER_GROUP=2, GROUP_SIZE=20)
    assert lane_places(module, 3, 5).tolist() == [6, 7, 26, 27, 46]


def test_the_garbage_collector_rests_while_a_kernel_is_compiled(monkeypatch, tmp_path):
    """Truth: its own state, in a compilation and after one that failed."""
    monkeypatch.setenv("MECHID_CACHE", str(tmp_path))
    seen = []

    def fail(_made):
        seen.append(gc.isenabled())
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        compiled_module("kernel_resting", lambda: "run = 1\n", fail)
    assert seen == [False]
    assert gc.isenabled()
