"""Progress listeners: the given one, else an updated line in a notebook, else none."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from html import escape
from importlib import import_module
from typing import Any

from mechid.identification.computation.progress import Listener, Progress, silent


@contextmanager
def progress_listener(listener: Listener | None) -> Iterator[Listener]:
    """Yield the listener of progress: the given one, else a line in a notebook, else a silent one."""
    if listener is not None:
        yield listener
    elif not _in_notebook():
        yield silent
    else:
        line = NotebookLine()
        try:
            yield line
        finally:
            line.end()


@contextmanager
def line_receiver(say: Callable[[str], None] | None) -> Iterator[Callable[[str], None]]:
    """Yield the receiver of single lines, chosen in the same way."""
    if say is not None:
        yield say
    elif not _in_notebook():
        yield _ignore
    else:
        line = NotebookLine()
        try:
            yield line.show
        finally:
            line.end()


def _ignore(line: str) -> None:
    del line


def progress_words(progress: Progress, since: float = 0.0) -> str:
    """Describe a report: stage k of n, position, cost, elapsed time."""
    cost = [] if progress.cost is None else [f"cost {progress.cost:.6g}"]
    where = [progress.line] if progress.line else []
    parts = [progress.stage, *where, *cost, f"{progress.elapsed_s + since:.1f} s"]
    return f"stage {progress.number} of {progress.total}: {', '.join(parts)}"


class NotebookLine:
    """Progress line in the output of a notebook; call it with each `Progress`."""

    def __init__(self) -> None:
        self._handle: Any = None

    def __call__(self, progress: Progress) -> None:
        """Replace the line by a report."""
        self.show(progress_words(progress))

    def show(self, words: str) -> None:
        """Replace the line by another one."""
        shown = import_module("IPython.display")
        ink = shown.HTML(f'<code style="color: gray">{escape(words)}</code>')
        if self._handle is None:
            self._handle = shown.display(ink, display_id=True)
        else:
            self._handle.update(ink)

    def end(self) -> None:
        """Remove the line."""
        if self._handle is not None:
            self._handle.update(import_module("IPython.display").HTML(""))


def _in_notebook() -> bool:
    """Return whether this process is the kernel of a notebook."""
    # IPython is not imported: in a notebook it is loaded already.
    shell = sys.modules.get("IPython")
    running = shell.get_ipython() if shell is not None else None
    return running is not None and hasattr(running, "kernel")
