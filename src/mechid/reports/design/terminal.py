"""A design on a terminal; its numbers are those of design.json."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from mechid.ink.console import print_lines, say, say_if_synthetic
from mechid.ink.data import Data
from mechid.reports.design.rivals import rival_lines
from mechid.reports.design.tables import loss_table, pair_table, parameter_table, record_table
from mechid.reports.design.verdict import RIVALS, headline, hole_lines, left_out_lines, loss_words, peak_lines


def print_design(data: Data, console: Console, files: Sequence[Path] = ()) -> None:
    """Print what `design_data` made, and where the files are."""
    say_if_synthetic(console, data)
    say(console, headline(data), "bold")
    console.print()
    if data["rivals"]:
        say(console, RIVALS, "bold")
        for line in rival_lines(data):
            say(console, line)
        pair_table(data).print(console)
    say(console, "Standard errors: at the values believed, and the median over the mechanisms that may be true", "bold")
    parameter_table(data).print(console)
    record_table(data).print(console)
    say(console, "Step loss", "bold")
    say(console, loss_words(data))
    loss_table(data).print(console)
    print_lines(console, "holes", hole_lines(data))
    print_lines(console, "amplitude", peak_lines(data))
    print_lines(console, "left out", left_out_lines(data))
    print_lines(console, "warning", data["warnings"], "yellow")
    print_lines(console, "written", [str(path) for path in files])
