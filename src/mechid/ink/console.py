"""The ink of a terminal, plain where it is none."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable

from rich.console import Console
from rich.text import Text

LOG_WIDTH = 120
"""Columns where the output is no terminal and COLUMNS says nothing."""


def console_on(*, err: bool = False) -> Console:
    """Return a console on stdout or stderr, as wide as it is."""
    stream = sys.stderr if err else sys.stdout
    wide = None if stream.isatty() or "COLUMNS" in os.environ else LOG_WIDTH
    return Console(file=stream, width=wide, markup=False, highlight=False, emoji=False)


def print_lines(console: Console, word: str, lines: Iterable[str], style: str = "") -> None:
    """Print lines that begin with a word."""
    for line in lines:
        say(console, f"{word}: {line}", style)


def say(console: Console, line: str, style: str = "") -> None:
    """Print a line, wrapped by words on a terminal alone: elsewhere a line stays a line."""
    console.print(Text(line, style=style), soft_wrap=not console.is_terminal)
