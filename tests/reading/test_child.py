"""The process that reads, by itself. Truth: the processes that are there, and its memory's limit."""

import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from mechid.reading import process
from mechid.reading.process import UnreadableError, call

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="limits of the system")


@pytest.fixture(autouse=True)
def impatient(monkeypatch):
    monkeypatch.setattr(process, "TIMEOUT_S", 1.0)


def is_there(number):
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def gone(number, within_s=5.0):
    until = time.monotonic() + within_s
    while is_there(number) and time.monotonic() < until:
        time.sleep(0.02)
    return not is_there(number)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="others limit no memory")
def test_a_flood_of_memory_is_refused_there():
    with pytest.raises(MemoryError):
        call(bytes, 1 << 45)
    assert call(math.sqrt, 4.0) == 2.0


def test_where_the_system_ends_it_that_is_said():
    with pytest.raises(UnreadableError, match="when memory runs out"):
        call(signal.raise_signal, signal.SIGKILL)


def test_it_ends_when_nothing_is_asked_of_it(monkeypatch):
    monkeypatch.setattr(process, "IDLE_S", 0.2)
    number = call(os.getppid)
    assert gone(number)
    assert call(os.getppid) != number


SCRIPT = """
import os, signal, sys, threading, time
from mechid.reading import process
process.TIMEOUT_S = 2.0
print(process.call(os.getppid), process.call(os.getpid), flush=True)
if sys.argv[1] == "busy":
    threading.Thread(target=process.call, args=[sum, range(10**12)], daemon=True).start()
    time.sleep(0.3)
os.kill(os.getpid(), signal.SIGKILL) if sys.argv[2] == "killed" else sys.exit()
"""


@pytest.mark.parametrize("state", ["idle", "busy"])
@pytest.mark.parametrize("end", ["killed", "ended"])
def test_it_does_not_outlive_the_one_that_started_it(state, end):
    """Idle it goes at once; in a loop that looks at nothing the system ends it when its time is over."""
    done = subprocess.run([sys.executable, "-c", SCRIPT, state, end], capture_output=True, text=True, check=False)
    numbers = [int(number) for number in done.stdout.split()]
    assert len(numbers) == 2
    assert all(gone(number) for number in numbers)


def test_what_a_library_prints_goes_nowhere(capfd):
    call(os.write, 1, b"nonsense")
    call(print, "nonsense")
    assert call(math.sqrt, 4.0) == 2.0
    assert capfd.readouterr() == ("", "")
