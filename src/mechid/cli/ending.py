"""End of a command on SIGINT, SIGTERM or SIGHUP: within two seconds, with exit code 130.

The first signal raises KeyboardInterrupt in the main thread, which keeps what was found and leaves. Python raises it
between two of its own instructions only, and a kernel's block, LLVM's optimisation of a kernel or a call of a library
may take minutes. So the system's own handler also wakes a thread, which ends the process where the main thread has not
done so in time, or at a second signal. Results are written beside their place and renamed, so none is left half there.
"""

from __future__ import annotations

import atexit
import os
import select
import signal
import socket
import sys
import time
from contextlib import suppress
from dataclasses import dataclass
from threading import Thread
from types import FrameType
from typing import NoReturn

INTERRUPTED = 130
WORDS = "mechid: interrupted"
SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")
"""Those of a terminal, of batch systems, and of a terminal that is closed; Windows lacks the last."""
GRACE_S = 1.5
"""Time that the main thread has, in seconds of the clock and of computing: other work may share the processors."""
LONGEST_S = 5.0
"""The same in seconds of the clock alone, for a command that waits and does not compute."""
AT_ONCE_S = 0.3
"""Signals this close together are one: `timeout` and others send theirs to the process and to its group."""
LOOK_S = 0.05
FLUSH_S = 0.2
SHOW_CURSOR = "\x1b[?25h"
"""A live progress line hides the cursor."""


@dataclass
class _Course:
    """Where the end of this process stands.

    Attributes
    ----------
    remedy : str
        How to go on after an end that the main thread did not come to by itself.
    is_raised : bool
        Whether the main thread has been told.
    is_said : bool
        Whether the user has been.
    is_over : bool
        Whether the command has done its work, so that a signal changes nothing but how long Python takes to leave.
    """

    remedy: str = ""
    is_raised: bool = False
    is_said: bool = False
    is_over: bool = False


_COURSE = _Course()


def listen_for_signals() -> None:
    """Have `SIGNALS` end this process; one that is ignored, as under nohup, stays ignored."""
    for number in (getattr(signal, name) for name in SIGNALS if hasattr(signal, name)):
        if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(number, _raise_once)
    atexit.register(_stop_listening)  # called last of all that is registered
    heard, wakes = socket.socketpair()
    wakes.setblocking(False)
    signal.set_wakeup_fd(wakes.detach(), warn_on_full_buffer=False)
    Thread(target=_watch, args=(heard,), name="signals", daemon=True).start()


def is_interrupted() -> bool:
    """Whether a signal has told this process to end."""
    return _COURSE.is_raised


def advise(remedy: str) -> None:
    """Set what is said of how to go on, should the command be cut short; follows "mechid: interrupted; "."""
    _COURSE.remedy = remedy


def say_interrupted(line: str = WORDS) -> None:
    """Say on standard error that the command was interrupted, from the main thread."""
    sys.stderr.write(f"{line}\n")
    sys.stderr.flush()
    _COURSE.is_said = True


def finish() -> None:
    """Note that the command has done its work: a signal from here on does not change its exit code."""
    _COURSE.is_over = True


def end(code: int) -> NoReturn:
    """End this process at once: without Python's own end, in which threads that still compile would abort LLVM."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(Exception):
            stream.flush()
    _release()
    os._exit(code)


def _raise_once(number: int, frame: FrameType | None) -> None:
    del number, frame
    if not _COURSE.is_raised and not _COURSE.is_over:
        _COURSE.is_raised = True
        raise KeyboardInterrupt


def _stop_listening() -> None:
    """Ignore `SIGNALS` while Python takes itself down, where they would end it as if its work were not done."""
    for number in (getattr(signal, name) for name in SIGNALS if hasattr(signal, name)):
        signal.signal(number, signal.SIG_IGN)


def _watch(heard: socket.socket) -> None:
    """Wait for a signal, give the main thread its time, and end the process."""
    known = {getattr(signal, name) for name in SIGNALS if hasattr(signal, name)}
    while not known & {*heard.recv(1)}:
        pass
    began, computed = time.monotonic(), time.process_time()
    while True:
        again = select.select([heard], [], [], LOOK_S)[0] and known & {*heard.recv(64)}
        passed, own = time.monotonic() - began, time.process_time() - computed
        if again and passed > AT_ONCE_S:
            break
        if min(passed, own) > GRACE_S or passed > LONGEST_S:
            break
    _cut_short()


def _cut_short() -> NoReturn:
    """End the process from beside its main thread, which may be within any call and hold any lock."""
    _COURSE.is_raised = True
    sys.unraisablehook = lambda raised: None
    with suppress(Exception):
        _release()
    flush = Thread(target=_flush_output, daemon=True)
    flush.start()
    flush.join(FLUSH_S)
    said = "" if _COURSE.is_said else "; ".join(filter(None, (WORDS, _COURSE.remedy))) + "\n"
    with suppress(OSError):  # past Python's stream, whose lock the main thread may hold
        os.write(2, f"{SHOW_CURSOR if os.isatty(2) else ''}{said}".encode(errors="backslashreplace"))
    os._exit(INTERRUPTED)


def _flush_output() -> None:
    with suppress(Exception):
        sys.stdout.flush()


def _release() -> None:
    """Let go of result folders and of the process that reads, where they have been used: nothing is imported here."""
    for module, name in (("mechid.holding.folder", "release_all"), ("mechid.reading.process", "end_reader")):
        if module in sys.modules:
            with suppress(Exception):
                getattr(sys.modules[module], name)()
