"""Output of commands: results, messages and progress."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import typer

from mechid.display import presenter_of
from mechid.identification.computation.progress import Listener
from mechid.ink.console import console_on
from mechid.progress.terminal import ProgressLine


def print_result(result: object, out: Path | None, *, docx: bool = False) -> None:
    """Print a result, and write its files if a folder is given, with `docx` also the test report."""
    own = presenter_of(result)
    numbers = own.numbers(result)
    own.print(numbers, console_on(), own.write(result, numbers, out, docx=docx) if out is not None else ())


@contextmanager
def show_progress() -> Iterator[Listener]:
    """Yield a listener that shows progress on stderr."""
    with ProgressLine(console_on(err=True)) as line:
        yield line.tell


def say(line: str) -> None:
    """Print a line on stderr."""
    typer.echo(line, err=True)
