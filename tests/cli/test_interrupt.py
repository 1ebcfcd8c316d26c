"""Ctrl-C while identifying. Truth: exit code 130, and the best values so far in a file marked as such."""

import json
import os
import signal
import subprocess
import sys
import threading

import pytest

from mechid.identification.result.grade import GRADE_WORDS, FitOutcome, Grade

WAIT_S = 120.0


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signals to send to another process")
@pytest.mark.parametrize(
    "name", [*(pytest.param(one, marks=pytest.mark.slow) for one in ("SIGINT", "SIGTERM")), "SIGHUP"]
)
def test_ctrl_c_and_a_terminal_or_batch_system_that_ends_it_keep_the_best_so_far(bench, tmp_path, name):
    number = getattr(signal, name)
    out = tmp_path / "result"
    if signal.getsignal(number) is signal.SIG_IGN:  # as under nohup, which the command would inherit
        signal.signal(number, signal.SIG_DFL)
    process = subprocess.Popen(
        [sys.executable, "-m", "mechid", "identify", str(bench), "--out", str(out)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
    )
    watchdog = threading.Timer(WAIT_S, process.kill)
    watchdog.start()
    try:
        said = ""
        for line in process.stderr:
            said += line
            if line.startswith("stage 1 of"):
                process.send_signal(number)
                break
        output, rest = process.communicate()
    finally:
        watchdog.cancel()
        process.kill()
    assert process.returncode == 130, said + rest
    assert "Traceback" not in said + rest
    assert f"mechid: interrupted; {out} holds the best so far" in rest.splitlines()
    assert json.loads((out / "estimate.json").read_text())["outcome"]["code"] == "interrupted"
    synthetic, first, second = output.splitlines()[:3]
    assert synthetic.startswith("SYNTHETIC")
    assert (first, second) == (GRADE_WORDS[Grade.FAILED], f"interrupted: {FitOutcome.INTERRUPTED.value}")
    assert output.count("Interrupted by the user") == 1
    assert sorted(path.name for path in out.iterdir()) == [
        "estimate.json",
        "journal.jsonl",
        "mechanism.toml",
        "report.json",
    ]
