"""Main loop of the reading process, which runs each call in a forked copy so that no call can affect the next.

A copy serves calls until one fails or crashes. The parent, which has never read a file, then forks a new copy within
milliseconds. On systems without fork (Windows) the process itself runs the calls and is restarted after a crash.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from io import FileIO
from pathlib import Path
from types import ModuleType

import numpy

from mechid.errors import MechidError
from mechid.reading.frames import receive, send
from mechid.reading.memory import limit_bytes
from mechid.reading.request import Call, CallError, CallResult, ProcessEnd

DONE = 3
"""Exit status of a copy that has sent its answer; any other status means that a library ended the process."""
CAN_COPY = hasattr(os, "fork")
UNNEEDED_PARTS = ("f2py", "testing")
"""NumPy subpackages that SciPy only refers to by name; importing them takes over half of SciPy's import time."""
TERMINATION_SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")
OOM_SCORE = 1000
"""Linux `oom_score_adj`: 0 is neutral; with 1000 the process is killed first when memory runs out."""


def serve() -> None:
    """Answer calls from standard input on standard output until the input ends; discard output of libraries."""
    ignore_termination_signals()
    # Libraries may print to standard output: the pipes move to new descriptors, and 0 and 1 go to the null device.
    asked, answers = FileIO(os.dup(0), "r"), FileIO(os.dup(1), "w")
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1):
        os.dup2(nowhere, stream)
    with suppress(EOFError, BrokenPipeError):
        while True:
            _serve_next(asked, answers)


def ignore_termination_signals() -> None:
    """Ignore the signals that end a command: the parent handles them, and this process ends when its pipes close."""
    for name in TERMINATION_SIGNALS:
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)


def _serve_next(asked: FileIO, answers: FileIO) -> None:
    """Handle the next request; a forked copy runs a call and all that follow until one fails."""
    request = _receive_call(asked, answers)
    if not isinstance(request, Call):
        return
    if not CAN_COPY:
        _answer_call(request, answers)
        return
    copy = os.fork()
    if copy == 0:
        status = 0
        try:
            _limit_resources()
            _serve_until_failure(request, asked, answers)
            status = DONE
        finally:
            # Skips the exit handlers and buffers that the copy has inherited: they belong to the parent.
            os._exit(status)
    _, how = os.waitpid(copy, 0)
    if os.waitstatus_to_exitcode(how) != DONE:
        send(answers, ProcessEnd(os.WTERMSIG(how) if os.WIFSIGNALED(how) else 0))


def _serve_until_failure(request: Call | None, asked: FileIO, answers: FileIO) -> None:
    """Answer a call and those that follow until one fails."""
    # A failed call may have left corrupt state in a library's memory, so its process must not serve another one.
    with suppress(EOFError, BrokenPipeError):
        while request is None or _answer_call(request, answers):
            request = _receive_call(asked, answers)


def _receive_call(asked: FileIO, answers: FileIO) -> Call | None:
    """Return the next call after importing its libraries, or None if the request is not a call."""
    try:
        request = receive(asked)
    except (EOFError, OSError):
        raise
    except Exception as error:  # a function that cannot be imported here
        send(answers, CallError(_portable(error)))
        return None
    _import(request.libraries if isinstance(request, Call) else request.names)
    return request if isinstance(request, Call) else None


def _import(libraries: Sequence[str]) -> None:
    with _empty_numpy_parts():
        for name in libraries:
            # The reader that needs a missing library reports it with the file and the package to install.
            with suppress(Exception):
                import_module(name)


@contextmanager
def _empty_numpy_parts() -> Iterator[None]:
    """Substitute empty modules for those of `UNNEEDED_PARTS` that are not imported yet."""
    empty = {name: ModuleType(f"numpy.{name}") for name in UNNEEDED_PARTS if f"numpy.{name}" not in sys.modules}
    for name, module in empty.items():
        sys.modules[module.__name__] = module
        setattr(numpy, name, module)
    try:
        yield
    finally:
        for name, module in empty.items():
            del sys.modules[module.__name__]
            delattr(numpy, name)


def _answer_call(call: Call, answers: FileIO) -> bool:
    """Run a call, send its answer, and return whether it succeeded."""
    # The alarm ends this process on timeout even if the parent is gone.
    _set_alarm(call.seconds)
    try:
        answer: CallResult | CallError = CallResult(call.function(*call.arguments))
    except Exception as error:
        answer = CallError(_portable(error))
    _set_alarm(0.0)
    try:
        send(answers, answer)
    except BrokenPipeError:
        raise
    except Exception as error:  # the value cannot be pickled, which is a bug in mechid
        send(answers, CallError(_portable(error)))
        return False
    return isinstance(answer, CallResult)


def _portable(error: Exception) -> Exception:
    """Return an error that can be pickled; one that indicates a bug in mechid carries its traceback as a note."""
    if not isinstance(error, MechidError | OSError | MemoryError):
        error.add_note("in the reading process:\n" + "".join(traceback.format_exception(error)))
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError("".join(traceback.format_exception(error)))
    return error


def _set_alarm(seconds: float) -> None:
    """Let the operating system end this process after some seconds; 0 cancels the alarm."""
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, seconds)


def _limit_resources() -> None:
    """Limit the memory of this process, and disable core dumps."""
    import resource

    limit = limit_bytes()
    with suppress(ValueError, OSError):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if limit is not None:
            resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
    with suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text(str(OOM_SCORE))
