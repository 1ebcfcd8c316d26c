"""An identification killed at several instants and taken up again ends as if nothing had been."""

import json
import os
import subprocess
import sys
import time

import pytest

WAIT_S = 180.0


def identify(bench, out, *options):
    return subprocess.Popen(
        [sys.executable, "-m", "mechid", "identify", str(bench), "--out", str(out), *options],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def kill_at(process, path, kind, count):
    """Kill the process when its journal holds so many steps of a kind; SIGKILL cannot be caught."""
    until = time.monotonic() + WAIT_S
    while time.monotonic() < until and process.poll() is None:
        if path.exists() and path.read_text().count(f'"step": "{kind}"') >= count:
            process.kill()
            break
        time.sleep(0.002)
    process.communicate()
    assert process.returncode != 0, f"it was not killed at {kind} {count}"


def numbers(folder):
    """Return estimate.json without how long it took."""
    content = json.loads((folder / "estimate.json").read_text())
    content["provenance"].pop("wall_time_s")
    for stage in content["stages"]:
        stage.pop("seconds")
    return content


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="kill -9 is not of Windows")
def test_killed_at_several_instants_it_ends_with_the_same_numbers(bench, tmp_path):
    """Truth: the undisturbed run, to the bit."""
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    process = identify(bench, whole)
    said = process.communicate(timeout=WAIT_S)[1]
    assert process.returncode == 0, said
    for kind, count in (("starts", 3), ("starts", 20), ("starts refined", 1), ("growth round", 1), ("joint fit", 1)):
        kill_at(identify(bench, killed, "--resume"), killed / "journal.jsonl", kind, count)
        assert not (killed / "estimate.json").exists()
    process = identify(bench, killed, "--resume")
    said = process.communicate(timeout=WAIT_S)[1]
    assert process.returncode == 0, said
    assert numbers(killed) == numbers(whole)


def test_a_journal_of_another_seed_is_refused(bench, tmp_path, refused, run):
    out = tmp_path / "out"
    kill_at(identify(bench, out), out / "journal.jsonl", "starts", 1)
    line = refused(2, "identify", bench, "--out", out, "--seed", "1", "--resume")
    assert "journal.jsonl: cannot be resumed because its run had other inputs (seed)" in line
