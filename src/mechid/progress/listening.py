"""Listeners of progress: the one given, else a line that is overwritten in a notebook, else none."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from html import escape
from importlib import import_module
from typing import Any

from mechid.identification.computation.progress import Listener, Progress, silent


@contextmanager
def listening(listener: Listener | None) -> Iterator[Listener]:
    """Return who is told of progress: the listener, else a line in a notebook, else nobody."""
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
def telling(say: Callable[[str], None] | None) -> Iterator[Callable[[str], None]]:
    """Return who is told of single lines, likewise."""
    if say is not None:
        yield say
    elif not _in_notebook():
        yield _unheard
    else:
        line = NotebookLine()
        try:
            yield line.show
        finally:
            line.end()


def _unheard(line: str) -> None:
    del line


def progress_words(progress: Progress, since: float = 0.0) -> str:
    """Return a report in words: stage k of n, where it stands, cost, elapsed."""
    cost = [] if progress.cost is None else [f"cost {progress.cost:.6g}"]
    where = [progress.line] if progress.line else []
    parts = [progress.stage, *where, *cost, f"{progress.elapsed_s + since:.1f} s"]
    return f"stage {progress.number} of {progress.total}: {', '.join(parts)}"


class NotebookLine:
    """A line of progress in a notebook's output; call it with each `Progress`."""

    def __init__(self) -> None:
        self._handle: Any = None

    def __call__(self, progress: Progress) -> None:
        """Show a report in place of the last one."""
        self.show(progress_words(progress))

    def show(self, words: str) -> None:
        """Show a line in place of the last one."""
        shown = import_module("IPython.display")
        ink = shown.HTML(f'<code style="color: gray">{escape(words)}</code>')
        if self._handle is None:
            self._handle = shown.display(ink, display_id=True)
        else:
            self._handle.update(ink)

    def end(self) -> None:
        """Take the line away."""
        if self._handle is not None:
            self._handle.update(import_module("IPython.display").HTML(""))


def _in_notebook() -> bool:
    """Tell whether this runs in a notebook's kernel."""
    shell = sys.modules.get("IPython")
    running = shell.get_ipython() if shell is not None else None
    return running is not None and hasattr(running, "kernel")
