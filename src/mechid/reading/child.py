"""The process that reads: it waits for calls, and calls them in a copy of itself, so that none harms the next.

A copy lives until a call fails or crashes; then the next one is made, within milliseconds, from the process that has
never read a file. Where the system has no copies (Windows) the process itself calls, and is started anew after a crash.
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
from mechid.reading.request import Call, Ended, Raised, Returned

DONE = 3
"""Exit status of a copy that has answered; with any other a library has ended it."""
CAN_COPY = hasattr(os, "fork")
NAMED_ALONE = ("f2py", "testing")
"""Parts of NumPy of which SciPy asks for the names alone: they are more than half of the time that its import takes."""
ENDINGS = ("SIGINT", "SIGTERM", "SIGHUP")
MOST_WANTED = 1000
"""How soon Linux ends a process where memory is short: 0 as others, 1000 first."""


def serve() -> None:
    """Answer calls from standard input on standard output until it ends; what libraries print goes nowhere."""
    ignore_endings()
    asked, answers = FileIO(os.dup(0), "r"), FileIO(os.dup(1), "w")
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1):
        os.dup2(nowhere, stream)
    with suppress(EOFError, BrokenPipeError):
        while True:
            _next(asked, answers)


def ignore_endings() -> None:
    """Ignore the signals that end a command: the process that waits decides, and this one ends with its pipes."""
    for name in ENDINGS:
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)


def _next(asked: FileIO, answers: FileIO) -> None:
    """Take the next request; a call is made by a copy, with all that follow until one fails."""
    request = _request(asked, answers)
    if not isinstance(request, Call):
        return
    if not CAN_COPY:
        _answered(request, answers)
        return
    copy = os.fork()
    if copy == 0:
        status = 0
        try:
            _limit()
            _as_long_as_good(request, asked, answers)
            status = DONE
        finally:
            os._exit(status)
    _, how = os.waitpid(copy, 0)
    if os.waitstatus_to_exitcode(how) != DONE:
        send(answers, Ended(os.WTERMSIG(how) if os.WIFSIGNALED(how) else 0))


def _as_long_as_good(request: Call | None, asked: FileIO, answers: FileIO) -> None:
    """Answer a call, and those that follow until one has failed: what it left in memory is not to be trusted."""
    with suppress(EOFError, BrokenPipeError):
        while request is None or _answered(request, answers):
            request = _request(asked, answers)


def _request(asked: FileIO, answers: FileIO) -> Call | None:
    """Return the next call, its libraries imported; None where there was something else to do."""
    try:
        request = receive(asked)
    except (EOFError, OSError):
        raise
    except Exception as error:  # a function that cannot be imported here
        send(answers, Raised(_portable(error)))
        return None
    _import(request.libraries if isinstance(request, Call) else request.names)
    return request if isinstance(request, Call) else None


def _import(libraries: Sequence[str]) -> None:
    with _left_out():
        for name in libraries:
            with suppress(Exception):  # the reader that needs it says what is missing
                import_module(name)


@contextmanager
def _left_out() -> Iterator[None]:
    """Have empty modules in place of those of `NAMED_ALONE`, where they are not there yet."""
    empty = {name: ModuleType(f"numpy.{name}") for name in NAMED_ALONE if f"numpy.{name}" not in sys.modules}
    for name, module in empty.items():
        sys.modules[module.__name__] = module
        setattr(numpy, name, module)
    try:
        yield
    finally:
        for name, module in empty.items():
            del sys.modules[module.__name__]
            delattr(numpy, name)


def _answered(call: Call, answers: FileIO) -> bool:
    """Call and answer; return whether it succeeded. The system ends what takes longer, also where nobody waits."""
    _alarm(call.seconds)
    try:
        answer: Returned | Raised = Returned(call.function(*call.arguments))
    except Exception as error:
        answer = Raised(_portable(error))
    _alarm(0.0)
    try:
        send(answers, answer)
    except BrokenPipeError:
        raise
    except Exception as error:  # a value that does not pickle: a fault of mechid's own
        send(answers, Raised(_portable(error)))
        return False
    return isinstance(answer, Returned)


def _portable(error: Exception) -> Exception:
    """Return an error that can be sent; of a fault of mechid's own with where it came from."""
    if not isinstance(error, MechidError | OSError | MemoryError):
        error.add_note("in the process that reads:\n" + "".join(traceback.format_exception(error)))
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError("".join(traceback.format_exception(error)))
    return error


def _alarm(seconds: float) -> None:
    """Have the system end this process after so many seconds; 0 for never."""
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, seconds)


def _limit() -> None:
    """Limit what this process may take: memory, and no image of it is left behind where it crashes."""
    import resource

    limit = limit_bytes()
    with suppress(ValueError, OSError):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if limit is not None:
            resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
    with suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text(str(MOST_WANTED))
