"""Calls in a process of its own: a crash, a hang or a flood of memory there is one line here.

One process serves all that this one reads. It is started by the first call, or ahead by `prepare`, and ended when
nothing has been asked of it for a while. It is safe among threads, which take turns; a forked process starts its own.
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
from threading import Lock, Timer
from typing import IO, Any, TypeVar, cast

from mechid.reading.frames import receive, send
from mechid.reading.request import Answer, Call, Ended, Libraries, Raised, Request

T = TypeVar("T")
PATIENCE_S = 30.0
"""Time that a call may take, beside that for the bytes of its file."""
SLOWEST = 10e6
"""Bytes a second: what a slow disk or a far one gives, and less than any reader needs."""
GRACE_S = 5.0
"""The process ends a call itself; so much later it is ended from here."""
IDLE_S = 10.0
"""Time after which a process that nothing is asked of is ended."""
PIPE_BYTES = 2**20
START = "import sys; sys.path[:] = {path!r}; from mechid.reading.child import serve; serve()"
BESIDE = {"HDF5_EXTFILE_PREFIX": "${ORIGIN}"}
"""Where HDF5 looks for raw storage that a file names, unless the user says otherwise."""
ENVIRONMENT = {
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "JE_ARROW_MALLOC_CONF": "background_thread:false",
}
"""A process that copies itself must have one thread; nothing is computed there."""
ALARM, KILL = 14, 9
"""Numbers of signals, also where the system has none of that name."""


class UnreadableError(Exception):
    """What has become of the process that read a file, in words that follow the name of the file."""


def call(function: Callable[..., T], *arguments: Any, size: int = 0, libraries: Sequence[str] = ()) -> T:
    """Return what a function of a module returns, called in the process that reads.

    Parameters
    ----------
    function : callable
    *arguments
        These, and what it returns or raises, pickle.
    size : int
        Bytes of the file that it reads: so much more time it has.
    libraries : sequence of str
        Modules that it needs.

    Raises
    ------
    UnreadableError
        It crashed, or came to no end in time.
    Exception
        Whatever the function raises.
    """
    asked = Call(function, arguments, tuple(libraries), PATIENCE_S + size / SLOWEST)
    answer = _READER.answer(asked)
    if isinstance(answer, Raised):
        raise answer.error
    if isinstance(answer, Ended):
        raise UnreadableError(_words(answer.signal, asked.seconds))
    return cast(T, answer.value)


def prepare(libraries: Sequence[str]) -> None:
    """Start the process that reads, with modules that it will need; return at once."""
    _READER.tell(Libraries(tuple(libraries)))


def end_reader() -> None:
    """End the process that reads, whoever waits for it."""
    _READER.end()


def _words(number: int, seconds: float) -> str:
    if number == ALARM:
        return f"reading it came to no end within {seconds:.0f} s"
    if number == KILL:
        return "the system ended the process that read it, as it does where memory is short"
    known = {each.value: each.name for each in signal.Signals}
    return f"the library that reads it crashed ({known.get(number, 'without a word')})"


class _Reader:
    """The process that reads, while there is one."""

    def __init__(self) -> None:
        self._alone = Lock()
        self._child: subprocess.Popen[bytes] | None = None
        self._asked = 0
        self._idle: Timer | None = None

    def tell(self, request: Request) -> None:
        """Send what is not answered."""
        with self._alone, suppress(OSError):
            send(_pipe(self._running().stdin), request)
            self._end_when_idle()

    def answer(self, asked: Call) -> Answer:
        """Send a call and return its answer; whatever goes wrong on the way ends the process."""
        with self._alone:
            child = self._running()
            overdue = _timer(asked.seconds + GRACE_S, _kill, child)
            try:
                answer = _exchanged(child, asked)
            except BaseException:  # interrupted, or what cannot be sent
                overdue.cancel()
                self.end()
                raise
            is_late = overdue.finished.is_set()
            overdue.cancel()
            if answer is None:
                answer = Ended(ALARM if is_late else _ended_by(child))
                self.end()
            self._end_when_idle()
            return answer

    def end(self) -> None:
        """End the process, whoever waits for it."""
        child, self._child = self._child, None
        if child is not None:
            _kill(child)
            child.wait()
            _close(child)

    def forget(self) -> None:
        """Leave the process to the one that this one has been forked from."""
        child = self._child
        if child is not None:
            _close(child)
            child.returncode = 0
        self._alone, self._child, self._idle = Lock(), None, None

    def _running(self) -> subprocess.Popen[bytes]:
        self._asked += 1
        if self._child is not None and self._child.poll() is not None:
            self.end()
        if self._child is None:
            self._child = _started()
        return self._child

    def _end_when_idle(self) -> None:
        if self._idle is not None:
            self._idle.cancel()
        self._idle = _timer(IDLE_S, self._end_unless_asked, self._asked)

    def _end_unless_asked(self, asked: int) -> None:
        with self._alone:
            if asked == self._asked:
                self.end()


def _started() -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-P", "-c", START.format(path=[str(place) for place in sys.path])],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        bufsize=0,
        pipesize=PIPE_BYTES,
        env={**BESIDE, **os.environ, **ENVIRONMENT},
        start_new_session=True,  # Ctrl-C is for the process that waits
    )


def _exchanged(child: subprocess.Popen[bytes], asked: Call) -> Answer | None:
    """Send a call and return its answer; None where the process is gone, or what it wrote is nonsense."""
    with suppress(OSError):
        send(_pipe(child.stdin), asked)
    try:
        return cast(Answer, receive(_pipe(child.stdout)))
    except Exception:
        return None


def _kill(child: subprocess.Popen[bytes]) -> None:
    """End a process and its copies."""
    with suppress(OSError):
        if child.returncode is None and hasattr(os, "killpg"):
            os.killpg(child.pid, KILL)
        else:
            child.kill()


def _ended_by(child: subprocess.Popen[bytes]) -> int:
    """Return the signal that ended a process, 0 where it was none."""
    with suppress(subprocess.TimeoutExpired):
        return max(-child.wait(GRACE_S), 0)
    return 0


def _close(child: subprocess.Popen[bytes]) -> None:
    for pipe in (child.stdin, child.stdout):
        _pipe(pipe).close()


def _pipe(pipe: IO[bytes] | None) -> FileIO:
    return cast(FileIO, pipe)


def _timer(seconds: float, function: Callable[..., None], *arguments: Any) -> Timer:
    timer = Timer(seconds, function, arguments)
    timer.daemon = True
    timer.start()
    return timer


_READER = _Reader()
atexit.register(end_reader)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_READER.forget)
