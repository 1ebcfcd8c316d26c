"""Processes that draw figures beside this one.

A figure is a fifth of a second of Python under the interpreter's lock, so threads do not share the work. A pen is an
interpreter of its own that has loaded Matplotlib and the drawings alone; it is sent sheets and writes their files.
It is no fork, as this process has threads, and it does not import the script that runs mechid.
"""

from __future__ import annotations

import gc
import os
import pickle
import subprocess
import sys
from collections.abc import Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from threading import Lock, local
from types import TracebackType
from typing import IO, Any, TypeAlias

from mechid.ink.sheet import Sheet
from mechid.reading.child import TERMINATION_SIGNALS

Process: TypeAlias = "subprocess.Popen[bytes]"
MOST = 4
"""Pens: of more, the last would begin to draw when the others are done."""
OBJECTS_UNSEEN = 50_000
"""How many a figure may make before Python looks for those that nobody needs."""
SCRIPT = (
    f"import signal; own = [getattr(signal, name) for name in {TERMINATION_SIGNALS} if hasattr(signal, name)];"
    "[signal.signal(number, signal.SIG_IGN) for number in own];"
    "import sys; sys.path[:] = PATH; from mechid.ink.pens import serve; serve()"
)
"""A pen ignores the signals that end a command, first of all: the process that waits decides, its pipe ends the pen.

The path is part of the text: a pen that is begun while the command ends would find its pipe empty.
"""


class Pens:
    """Some processes that draw: there within a ``with`` statement, gone behind it.

    Where none can be started, the figures are drawn by this process.
    """

    def __init__(self) -> None:
        self._count = min(os.cpu_count() or 1, MOST)
        self._threads = ThreadPoolExecutor(self._count, thread_name_prefix="pen")
        self._own = local()
        self._here = Lock()
        self._processes: list[Process] = []
        self._idle: list[Process] = []

    def __enter__(self) -> Pens:
        """Start the processes, which load what they need while something else goes on."""
        with suppress(OSError):
            for _ in range(self._count):
                self._processes.append(_started())
        self._idle = list(self._processes)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """End the processes; where an error passes, what they draw is given up."""
        self._threads.shutdown(wait=kind is None, cancel_futures=True)
        for process in self._processes:
            if kind is not None:
                process.kill()
            with suppress(OSError):  # what was not sent has no reader any more
                _of(process.stdin).close()
            process.wait()
            _of(process.stdout).close()

    def draw(self, sheets: Iterable[Sheet], folder: Path) -> dict[str, Future[None]]:
        """Begin to draw sheets into a folder, each as SVG and PNG; return by name what ends when they are there."""
        return {sheet.name: self._threads.submit(self._drawn, sheet, folder) for sheet in sheets}

    def _drawn(self, sheet: Sheet, folder: Path) -> None:
        """Have this thread's process draw a sheet."""
        if not hasattr(self._own, "process"):
            self._own.process = self._idle.pop() if self._idle else None
        pen: Process | None = self._own.process
        if pen is None:
            with self._here:
                _written(sheet, folder)
            return
        try:
            _send(_of(pen.stdin), (sheet, folder))
            failed: Exception | None = pickle.load(_of(pen.stdout))
        except (EOFError, BrokenPipeError):
            raise RuntimeError(f"a process that draws figures ended with code {pen.wait()}") from None
        if failed is not None:
            raise failed


def _started() -> Process:
    surroundings = {**os.environ, "MPLBACKEND": "agg"}  # a notebook's is not there for others
    return subprocess.Popen(
        [sys.executable, "-c", SCRIPT.replace("PATH", repr([str(place) for place in sys.path]))],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=surroundings,
        start_new_session=True,  # what is sent to a group of processes is for the one that waits
    )


def _of(stream: IO[bytes] | None) -> IO[bytes]:
    assert stream is not None  # both are pipes
    return stream


def _send(stream: IO[bytes], message: Any) -> None:
    pickle.dump(message, stream, protocol=pickle.HIGHEST_PROTOCOL)
    stream.flush()


def _written(sheet: Sheet, folder: Path) -> None:
    from mechid.ink.drawings import draw
    from mechid.ink.figures import write_figure

    write_figure(sheet.name, draw(sheet), folder)


def serve() -> None:
    """Draw the sheets that come on stdin until it ends, and answer each on stdout: with None, or the error."""
    answers, sys.stdout = sys.stdout.buffer, sys.stderr
    import_module("mechid.ink.drawings")
    gc.set_threshold(OBJECTS_UNSEEN)
    gc.freeze()  # what has been loaded stays; only what a figure makes is looked through
    while True:
        try:
            sheet, folder = pickle.load(sys.stdin.buffer)
        except (EOFError, pickle.UnpicklingError):  # the latter where who sends was killed
            return
        failed: Exception | None = None
        try:
            _written(sheet, folder)
        except Exception as error:  # the process that waits raises it
            failed = error
        try:
            _send(answers, failed)
        except BrokenPipeError:  # who waited was killed
            os._exit(0)  # without what Python says of a stream that nobody reads
        gc.collect()  # parts of a figure refer to one another: what it took is given back while nobody waits
