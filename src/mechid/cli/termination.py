"""Termination of a command on SIGINT, SIGTERM or SIGHUP within two seconds, with exit code 130.

The first signal raises KeyboardInterrupt in the main thread, which saves its results and exits. Python raises it only
between its own instructions, but a block of a kernel, the optimisation of a kernel by LLVM or a library call can take
minutes. The signal handler therefore also wakes a thread, which ends the process if the main thread has not done so in
time, or at a second signal. Results are written to temporary files and renamed, so none is left incomplete.
"""

from __future__ import annotations

import _thread
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
# Windows lacks SIGHUP.
SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")
"""Signals of terminals, of batch systems, and of a closed terminal; Windows lacks the last."""
GRACE_S = 1.5
"""Time for the main thread to exit, in s of elapsed and of processor time, since the processors may be shared."""
LONGEST_S = 5.0
"""The same in s of elapsed time alone, for a command that waits without computing."""
AT_ONCE_S = 0.3
"""Interval in s in which signals count as one: `timeout` and others signal both the process and its group."""
LOOK_S = 0.05
FLUSH_S = 0.2
SHOW_CURSOR = "\x1b[?25h"
"""Escape sequence that shows the cursor, which a live progress line hides."""


@dataclass
class _Shutdown:
    """State of the termination of this process.

    Attributes
    ----------
    remedy : str
        Advice for continuing after a forced end.
    is_raised : bool
        Whether KeyboardInterrupt was raised in the main thread.
    is_lost : bool
        Whether Python ignored that KeyboardInterrupt, as it does in a callback or in a finalizer.
    is_said : bool
        Whether the user was informed.
    is_over : bool
        Whether the command has finished, so that a signal only shortens the shutdown of Python.
    """

    remedy: str = ""
    is_raised: bool = False
    is_lost: bool = False
    is_said: bool = False
    is_over: bool = False


_SHUTDOWN = _Shutdown()


def listen_for_signals() -> None:
    """Install handlers of `SIGNALS`; an ignored signal, as under nohup, stays ignored."""
    # Registered first, so that it is called last.
    atexit.register(_stop_listening)
    heard, wakes = socket.socketpair()
    # Required by set_wakeup_fd.
    wakes.setblocking(False)
    signal.set_wakeup_fd(wakes.detach(), warn_on_full_buffer=False)
    sys.unraisablehook = _note_lost_interrupt
    Thread(target=_watch, args=(heard,), name="signals", daemon=True).start()
    # Last, since the thread above is not woken by a signal that comes before it listens.
    for number in (getattr(signal, name) for name in SIGNALS if hasattr(signal, name)):
        if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(number, _raise_once)


def is_interrupted() -> bool:
    """Return whether a signal has requested the end of this process."""
    return _SHUTDOWN.is_raised


def advise(remedy: str) -> None:
    """Set the advice printed after "mechid: interrupted; " if the command is forced to end."""
    _SHUTDOWN.remedy = remedy


def say_interrupted(line: str = WORDS) -> None:
    """Print on standard error that the command was interrupted; called from the main thread."""
    sys.stderr.write(f"{line}\n")
    sys.stderr.flush()
    _SHUTDOWN.is_said = True


def finish() -> None:
    """Mark the command as finished: later signals do not change its exit code."""
    _SHUTDOWN.is_over = True


def end(code: int) -> NoReturn:
    """End this process immediately, without the shutdown of Python, in which compiling threads would abort LLVM."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(Exception):
            stream.flush()
    _release()
    os._exit(code)


def _raise_once(number: int, frame: FrameType | None) -> None:
    del number, frame
    if (_SHUTDOWN.is_lost or not _SHUTDOWN.is_raised) and not _SHUTDOWN.is_over:
        _SHUTDOWN.is_raised, _SHUTDOWN.is_lost = True, False
        raise KeyboardInterrupt


def _note_lost_interrupt(raised: sys.UnraisableHookArgs) -> None:
    """Note that Python ignored KeyboardInterrupt, so that `_watch` raises it again; report any other exception."""
    if _SHUTDOWN.is_raised and issubclass(raised.exc_type, KeyboardInterrupt):
        _SHUTDOWN.is_lost = True
    else:
        sys.__unraisablehook__(raised)


def _stop_listening() -> None:
    """Ignore `SIGNALS` during the shutdown of Python, where they would change the exit code."""
    for number in (getattr(signal, name) for name in SIGNALS if hasattr(signal, name)):
        signal.signal(number, signal.SIG_IGN)


def _watch(heard: socket.socket) -> None:
    """Wait for a signal, give the main thread time to exit, then end the process."""
    known = {getattr(signal, name) for name in SIGNALS if hasattr(signal, name)}
    while (number := heard.recv(1)[0]) not in known:
        pass
    began, computed = time.monotonic(), time.process_time()
    while True:
        again = select.select([heard], [], [], LOOK_S)[0] and known & {*heard.recv(64)}
        if _SHUTDOWN.is_lost:
            _thread.interrupt_main(signal.Signals(number))
            # It wakes this thread as a signal does, and is not a second one.
            if select.select([heard], [], [], 0.0)[0]:
                heard.recv(64)
        passed, own = time.monotonic() - began, time.process_time() - computed
        if again and passed > AT_ONCE_S:
            break
        if min(passed, own) > GRACE_S or passed > LONGEST_S:
            break
    _force_end()


def _force_end() -> NoReturn:
    """End the process from another thread, while the main thread may be in any call and hold any lock."""
    _SHUTDOWN.is_raised = True
    sys.unraisablehook = lambda raised: None
    with suppress(Exception):
        _release()
    flush = Thread(target=_flush_output, daemon=True)
    flush.start()
    flush.join(FLUSH_S)
    message = "" if _SHUTDOWN.is_said else "; ".join(filter(None, (WORDS, _SHUTDOWN.remedy))) + "\n"
    # Written directly, since the main thread may hold the lock of sys.stderr.
    with suppress(OSError):
        os.write(2, f"{SHOW_CURSOR if os.isatty(2) else ''}{message}".encode(errors="backslashreplace"))
    os._exit(INTERRUPTED)


def _flush_output() -> None:
    with suppress(Exception):
        sys.stdout.flush()


def _release() -> None:
    """Release result folders and the reading process, if their modules are loaded."""
    for module, name in (("mechid.locks.folder", "release_all"), ("mechid.reading.process", "end_reader")):
        if module in sys.modules:
            with suppress(Exception):
                getattr(sys.modules[module], name)()
