"""A diagnosis on a terminal; its numbers are those of diagnose.json."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from mechid.ink.console import print_lines, say, say_if_synthetic
from mechid.reports.diagnosis.tables import effect_table, value_table
from mechid.reports.diagnosis.verdict import PATH_TITLE, acts_line, next_lines
from mechid.reports.fit.tables import path_table


def print_diagnosis(data: Mapping[str, Any], console: Console, files: Sequence[Path] = ()) -> None:
    """Print what `diagnosis_data` made, and where the files are."""
    say_if_synthetic(console, data)
    say(console, data["unexplained"]["words"], "bold")
    if data["missing"]:
        console.print()
        effect_table(data).print(console)
        print_lines(console, "missing", [f"{one['name']}: {one['words']}" for one in data["missing"]])
        value_table(data).print(console)
        print_lines(console, "acts", [acts_line(one) for one in data["missing"] if one["places"]])
        print_lines(console, "evidence", data["evidence"])
        print_lines(console, "next", next_lines(data))
    if data["path"]:
        console.print()
        say(console, PATH_TITLE, "bold")
        path_table(data["path"]).print(console)
    print_lines(console, "tried", [f"{one['name']}: {one['why']}" for one in data["tried"]])
    print_lines(console, "written", [str(path) for path in files])
