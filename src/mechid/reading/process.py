"""Calls in a separate reading process: a crash, a hang or excessive memory use becomes an error message.

One reading process serves all calls of this process. The first call starts it, or `prepare` ahead of that; it is ended
after an idle time. Calls from several threads are serialised. A forked process starts its own reading process.
"""

from __future__ import annotations

import atexit
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from io import FileIO
from pathlib import Path
from threading import Lock, Timer
from typing import IO, Any, TypeVar, cast

from mechid.errors import InputFileError
from mechid.reading.frames import receive, send
from mechid.reading.request import Answer, Call, CallError, Libraries, ProcessEnd, Request

T = TypeVar("T")
TIMEOUT_S = 30.0
"""Time limit of a call, in addition to the time for the bytes of its file."""
SLOWEST_BYTES_PER_S = 10e6
"""Assumed throughput, that of a slow or remote disk; every reader is faster."""
GRACE_S = 5.0
"""The reading process ends an overdue call itself; this much later its parent kills it."""
IDLE_S = 10.0
"""Idle time after which the reading process is ended."""
PIPE_BYTES = 2**20
BOOTSTRAP_CODE = "import sys; sys.path[:] = {path!r}; from mechid.reading.child import serve; serve()"
HDF5_DEFAULTS = {"HDF5_EXTFILE_PREFIX": "${ORIGIN}"}
"""HDF5 looks for external raw data next to the file, unless the user's environment sets another folder."""
ENVIRONMENT = {
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "JE_ARROW_MALLOC_CONF": "background_thread:false",
}
"""Settings for a single thread: a process that forks must have one thread only, and it computes nothing."""
ALARM, KILL = 14, 9
"""Numbers of SIGALRM and SIGKILL, which Python does not name on every system."""


class UnreadableError(Exception):
    """Failure of the reading process; the message is phrased to follow the file's name."""


def read_guarded(function: Callable[..., T], path: Path, *arguments: Any, kind: str) -> T:
    """Read a file in the reading process, so that a damaged one cannot end this process.

    Parameters
    ----------
    function : callable
        Called with the absolute path and the arguments.
    path : Path
    *arguments
    kind : str
        Content of such files, for the message: ``"of a structure"``.

    Raises
    ------
    InputFileError
        Any other error of the function, in one line with the file's name.
    """
    try:
        return call(function, path.absolute(), *arguments, size=path.stat().st_size)
    except InputFileError:
        raise
    except Exception as error:
        what = str(error) if isinstance(error, UnreadableError) else f"{type(error).__name__}: {error}"
        raise InputFileError(
            f"{path.name}: is damaged or not a {path.suffix.lower()} file {kind} ({' '.join(what.split())[:160]}); "
            "export or copy it again"
        ) from error


def call(function: Callable[..., T], *arguments: Any, size: int = 0, libraries: Sequence[str] = ()) -> T:
    """Call a module-level function in the reading process and return its result.

    Parameters
    ----------
    function : callable
    *arguments
        Arguments. They, the result and any exception must be picklable.
    size : int
        Size of the file in bytes, which extends the time limit.
    libraries : sequence of str
        Modules that the function needs.

    Raises
    ------
    UnreadableError
        The reading process crashed or exceeded the time limit.
    Exception
        Any exception of the function.
    """
    asked = Call(function, arguments, tuple(libraries), TIMEOUT_S + size / SLOWEST_BYTES_PER_S)
    answer = _READER.answer(asked)
    if isinstance(answer, CallError):
        raise answer.error
    if isinstance(answer, ProcessEnd):
        raise UnreadableError(_describe_end(answer.signal, asked.seconds))
    return cast(T, answer.value)


def prepare(libraries: Sequence[str]) -> None:
    """Start the reading process with modules that it will need, without waiting for it."""
    _READER.notify(Libraries(tuple(libraries)))


def end_reader() -> None:
    """End the reading process, even if a thread waits for it."""
    _READER.end()


def _describe_end(number: int, seconds: float) -> str:
    if number == ALARM:
        return f"reading it did not finish within {seconds:.0f} s"
    if number == KILL:
        return "the system killed the reading process, as it does when memory runs out"
    known = {each.value: each.name for each in signal.Signals}
    return f"the library that reads it crashed ({known.get(number, 'no signal reported')})"


class _Reader:
    """Handle of the reading process, which is started on demand."""

    def __init__(self) -> None:
        self._alone = Lock()
        self._child: subprocess.Popen[bytes] | None = None
        self._asked = 0
        self._idle: Timer | None = None

    def notify(self, request: Request) -> None:
        """Send a request that has no answer."""
        with self._alone, suppress(OSError):
            send(_pipe(self._ensure_running().stdin), request)
            self._end_when_idle()

    def answer(self, asked: Call) -> Answer:
        """Send a call and return its answer; any error in the exchange ends the reading process."""
        with self._alone:
            child = self._ensure_running()
            overdue = _start_timer(asked.seconds + GRACE_S, _kill, child)
            try:
                answer = _exchange(child, asked)
            # After an interrupt or an unpicklable argument the pipe may hold half a message; no later call can use it.
            except BaseException:
                overdue.cancel()
                self.end()
                raise
            is_late = overdue.finished.is_set()
            overdue.cancel()
            if answer is None:
                answer = ProcessEnd(ALARM if is_late else _terminating_signal(child))
                self.end()
            self._end_when_idle()
            return answer

    def end(self) -> None:
        """End the process, even if a thread waits for it."""
        child, self._child = self._child, None
        if child is not None:
            _kill(child)
            child.wait()
            _close(child)

    def forget(self) -> None:
        """Drop the handle after a fork: the process belongs to the parent of this one."""
        child = self._child
        if child is not None:
            _close(child)
            # Keeps Popen's destructor from waiting for a process that is not a child of this one.
            child.returncode = 0
        self._alone, self._child, self._idle = Lock(), None, None

    def _ensure_running(self) -> subprocess.Popen[bytes]:
        self._asked += 1
        if self._child is not None and self._child.poll() is not None:
            self.end()
        if self._child is None:
            self._child = _start_process()
        return self._child

    def _end_when_idle(self) -> None:
        if self._idle is not None:
            self._idle.cancel()
        self._idle = _start_timer(IDLE_S, self._end_if_unused, self._asked)

    def _end_if_unused(self, asked: int) -> None:
        with self._alone:
            if asked == self._asked:
                self.end()


def _start_process() -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-P", "-c", BOOTSTRAP_CODE.format(path=[str(place) for place in sys.path])],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        bufsize=0,
        pipesize=PIPE_BYTES,
        env={**HDF5_DEFAULTS, **os.environ, **ENVIRONMENT},
        start_new_session=True,  # Ctrl-C goes to the parent only
    )


def _exchange(child: subprocess.Popen[bytes], asked: Call) -> Answer | None:
    """Send a call and return its answer, or None if the process has ended or its answer is malformed."""
    with suppress(OSError):
        send(_pipe(child.stdin), asked)
    try:
        return cast(Answer, receive(_pipe(child.stdout)))
    except Exception:
        return None


def _kill(child: subprocess.Popen[bytes]) -> None:
    """Kill a process and its forked copies."""
    with suppress(OSError):
        if child.returncode is None and hasattr(os, "killpg"):
            os.killpg(child.pid, KILL)
        else:
            child.kill()


def _terminating_signal(child: subprocess.Popen[bytes]) -> int:
    """Return the signal that ended a process, or 0 if none did."""
    with suppress(subprocess.TimeoutExpired):
        return max(-child.wait(GRACE_S), 0)
    return 0


def _close(child: subprocess.Popen[bytes]) -> None:
    for pipe in (child.stdin, child.stdout):
        _pipe(pipe).close()


def _pipe(pipe: IO[bytes] | None) -> FileIO:
    return cast(FileIO, pipe)


def _start_timer(seconds: float, function: Callable[..., None], *arguments: Any) -> Timer:
    timer = Timer(seconds, function, arguments)
    timer.daemon = True
    timer.start()
    return timer


_READER = _Reader()
atexit.register(end_reader)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_READER.forget)
