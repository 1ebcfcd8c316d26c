"""Processes that draw figures in parallel.

A figure takes a fifth of a second of Python under the interpreter lock, so threads would not help. A pen is a separate
interpreter that has loaded only Matplotlib and the drawings. It receives sheets and writes their files. It is not
forked, since this process has threads, and it does not import the script that runs mechid.
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
"""Most pens; with none, the process itself draws."""
OBJECTS_UNSEEN = 50_000
"""Threshold of the garbage collector while a figure is drawn."""
SCRIPT = (
    f"import signal; own = [getattr(signal, name) for name in {TERMINATION_SIGNALS} if hasattr(signal, name)];"
    "[signal.signal(number, signal.SIG_IGN) for number in own];"
    "import sys; sys.path[:] = PATH; from mechid.ink.pens import serve; serve()"
)
"""Program of a pen. It first ignores the signals that end a command: the parent decides, and a closed pipe ends it.

The path is part of the text, since a pen started while the command ends would find its pipe empty.
"""


class Pens:
    """Context manager of drawing processes.

    If there are none, this process draws the figures.
    """

    def __init__(self) -> None:
        self._count = min(os.cpu_count() or 1, MOST)
        self._threads = ThreadPoolExecutor(max(self._count, 1), thread_name_prefix="pen")
        self._own = local()
        self._here = Lock()
        self._processes: list[Process] = []
        self._idle: list[Process] = []

    def __enter__(self) -> Pens:
        """Start the processes, which load their modules in the background."""
        with suppress(OSError):
            for _ in range(self._count):
                self._processes.append(_start_process())
        self._idle = list(self._processes)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """End the processes; after an error, unfinished figures are dropped."""
        self._threads.shutdown(wait=kind is None, cancel_futures=True)
        for process in self._processes:
            if kind is not None:
                process.kill()
            with suppress(OSError):
                _of(process.stdin).close()
            process.wait()
            _of(process.stdout).close()

    def draw(self, sheets: Iterable[Sheet], folder: Path) -> dict[str, Future[None]]:
        """Start drawing sheets into a folder, as SVG and PNG; return futures of their completion by name."""
        return {sheet.name: self._threads.submit(self._draw_remotely, sheet, folder) for sheet in sheets}

    def _draw_remotely(self, sheet: Sheet, folder: Path) -> None:
        """Let the process of this thread draw a sheet."""
        if not hasattr(self._own, "process"):
            self._own.process = self._idle.pop() if self._idle else None
        pen: Process | None = self._own.process
        if pen is None:
            with self._here:
                _write_sheet(sheet, folder)
            return
        try:
            _send(_of(pen.stdin), (sheet, folder))
            failed: Exception | None = pickle.load(_of(pen.stdout))
        except (EOFError, BrokenPipeError):
            raise RuntimeError(f"a process that draws figures ended with code {pen.wait()}") from None
        if failed is not None:
            raise failed


def _start_process() -> Process:
    surroundings = {**os.environ, "MPLBACKEND": "agg"}  # a notebook's is not there for others
    return subprocess.Popen(
        [sys.executable, "-c", SCRIPT.replace("PATH", repr([str(place) for place in sys.path]))],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=surroundings,
        start_new_session=True,  # what is sent to a group of processes is for the one that waits
    )


def _of(stream: IO[bytes] | None) -> IO[bytes]:
    assert stream is not None
    return stream


def _send(stream: IO[bytes], message: Any) -> None:
    pickle.dump(message, stream, protocol=pickle.HIGHEST_PROTOCOL)
    stream.flush()


def _write_sheet(sheet: Sheet, folder: Path) -> None:
    from mechid.ink.drawings import draw
    from mechid.ink.figures import write_figure

    write_figure(sheet.name, draw(sheet), folder)


def serve() -> None:
    """Draw the sheets received on stdin until it ends, and answer each on stdout with None or an error."""
    answers, sys.stdout = sys.stdout.buffer, sys.stderr
    import_module("mechid.ink.drawings")
    gc.set_threshold(OBJECTS_UNSEEN)
    # Loaded modules are excluded from collections, which then cover only the objects of a figure.
    gc.freeze()
    while True:
        try:
            sheet, folder = pickle.load(sys.stdin.buffer)
        except (EOFError, pickle.UnpicklingError):  # the latter where who sends was killed
            return
        failed: Exception | None = None
        try:
            _write_sheet(sheet, folder)
        except Exception as error:  # the process that waits raises it
            failed = error
        try:
            _send(answers, failed)
        except BrokenPipeError:  # who waited was killed
            # A normal exit would print an error about the broken stream.
            os._exit(0)
        # The parts of a figure reference one another; the memory is freed while nobody waits.
        gc.collect()
