"""The process that reads. Truth: one error here for whatever befalls it there; the next call is as the first."""

import ctypes
import math
import os
import signal
import threading
import time
from multiprocessing import get_context
from pathlib import Path

import numpy as np
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


def test_a_call_returns_what_the_function_returns():
    assert call(math.sqrt, 2.0) == math.sqrt(2.0)
    values = call(np.linspace, 0.0, 1.0, 300_000)
    np.testing.assert_array_equal(values, np.linspace(0.0, 1.0, 300_000))
    values[0] = 5.0
    dates = call(np.arange, "2024-01", "2024-03", 1, "M8[D]")
    np.testing.assert_array_equal(dates, np.arange("2024-01", "2024-03", 1, "M8[D]"))


def test_what_it_raises_is_raised_here_with_where_it_came_from():
    with pytest.raises(ValueError, match="math domain error") as caught:
        call(math.sqrt, -1.0)
    assert "in the reading process" in caught.value.__notes__[0]


CRASHES = {
    "SIGSEGV": (ctypes.string_at, 8),
    "SIGABRT": (os.abort,),
    "no signal reported": (os._exit, 0),
}


@pytest.mark.parametrize("name", CRASHES)
def test_a_crash_is_an_error_and_the_next_call_is_good(name):
    """Truth: address 8 belongs to nobody."""
    with pytest.raises(UnreadableError, match=rf"the library that reads it crashed \({name}\)"):
        call(*CRASHES[name])
    assert call(math.sqrt, 4.0) == 2.0


def test_a_hang_is_ended():
    began = time.monotonic()
    with pytest.raises(UnreadableError, match="reading it did not finish within 1 s"):
        call(time.sleep, 60.0)
    assert 1.0 <= time.monotonic() - began < 5.0
    assert call(math.sqrt, 4.0) == 2.0


def test_a_hang_that_holds_the_interpreter_is_ended():
    """Truth: a sum over 10^12 numbers in C looks at no signal."""
    with pytest.raises(UnreadableError, match="reading it did not finish within 1 s"):
        call(sum, range(10**12))


def test_a_larger_file_has_more_time(monkeypatch):
    """Truth: the same call, which is ended where the file is small."""
    monkeypatch.setattr(process, "TIMEOUT_S", 0.2)
    assert call(time.sleep, 0.6, size=int(2 * process.SLOWEST_BYTES_PER_S)) is None
    with pytest.raises(UnreadableError):
        call(time.sleep, 0.6)


def test_one_process_serves_all_threads():
    parents = [None] * 8

    def ask(place):
        parents[place] = [call(os.getppid), call(np.full, 50_000, float(place))]

    threads = [threading.Thread(target=ask, args=[place]) for place in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len({found[0] for found in parents}) == 1
    assert all((found[1] == place).all() for place, found in enumerate(parents))


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_forked_process_starts_its_own():
    here = call(os.getppid)
    with get_context("fork").Pool(1) as pool:
        there = pool.apply(call, [os.getppid])
    assert there != here
    assert call(os.getppid) == here


def test_it_is_started_again_where_it_was_ended_from_outside():
    number = call(os.getppid)
    os.killpg(number, signal.SIGKILL)
    assert gone(number)
    assert call(math.sqrt, 4.0) == 2.0


def test_an_interrupted_call_leaves_nothing_behind(monkeypatch):
    number = call(os.getppid)
    signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(signal.SIGINT))
    signal.setitimer(signal.ITIMER_REAL, 0.2)
    try:
        with pytest.raises(KeyboardInterrupt):
            call(time.sleep, 0.9)
    finally:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
    assert gone(number)
    assert call(math.sqrt, 4.0) == 2.0


def test_what_cannot_be_sent_is_a_fault_of_ours():
    with pytest.raises(AttributeError, match=r"pickle|local object"):  # the words of Python 3.11, 3.13
        call(lambda: 1)
    assert call(math.sqrt, 4.0) == 2.0
