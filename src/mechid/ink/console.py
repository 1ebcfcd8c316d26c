"""Console output with styles on a terminal, plain elsewhere."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable

from rich.console import Console
from rich.text import Text

LOG_WIDTH = 120
"""Width in columns if the output is not a terminal and COLUMNS is not set."""


def console_on(*, err: bool = False) -> Console:
    """Return a console on stdout or stderr, with its width."""
    stream = sys.stderr if err else sys.stdout
    wide = None if stream.isatty() or "COLUMNS" in os.environ else LOG_WIDTH
    return Console(file=stream, width=wide, markup=False, highlight=False, emoji=False)


def print_lines(console: Console, word: str, lines: Iterable[str], style: str = "") -> None:
    """Print lines, each prefixed with a word."""
    for line in lines:
        say(console, f"{word}: {line}", style)


def say(console: Console, line: str, style: str = "") -> None:
    """Print a line, wrapped at words on a terminal only; elsewhere it remains one line for scripts."""
    console.print(Text(line, style=style), soft_wrap=not console.is_terminal)
