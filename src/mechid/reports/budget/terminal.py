"""The ink of a budget on a terminal; its numbers are those of budget.json."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from mechid.ink.console import print_lines, say, say_if_synthetic
from mechid.reports.budget.contents import budget_contents
from mechid.reports.budget.tables import mode_table, requirement_table, side_table
from mechid.reports.budget.verdict import deciding_coupling

SHOWN_SHARES, SHOWN_CROSSINGS = 3, 12


def print_budget(data: Mapping[str, Any], console: Console, files: Sequence[Path] = ()) -> None:
    """Print what `budget_data` made, and where the files are."""
    data = budget_contents(data)
    verdict = data["verdict"]
    say_if_synthetic(console, data)
    say(console, verdict["headline"], "bold")
    print_lines(console, "margin", verdict["questions"][0]["answers"] if data["requirements"] else [])
    say(console, "Modes of operation, at the rate of the largest one-way line-of-sight RMS in full steps/s", "bold")
    mode_table(data).print(console)
    _print_side(data, console)
    if data["requirements"]:
        say(
            console,
            "Requirements, at the worst rate of each; the lower 95 % limit of a margin decides, two-way where computed",
            "bold",
        )
        requirement_table(data).print(console)
        print_lines(console, "driven by", [_drivers(r) for r in data["requirements"]])
    for mode in data["modes"]:
        print_lines(console, "avoid", [_avoid(mode, n, r) for n, r in mode["avoid"].items() if r])
    lines = [f"order {c['order']:g} meets {c['mode']} at {c['rate']:.4g} steps/s" for c in data["crossings"]]
    print_lines(console, "crossing", lines[:SHOWN_CROSSINGS])
    if len(lines) > SHOWN_CROSSINGS:
        say(console, f"... and {len(lines) - SHOWN_CROSSINGS} further crossings in crossings.csv")
    print_lines(console, "note", data["notes"])
    print_lines(console, "warning", data["warnings"], "yellow")
    print_lines(console, "written", [str(path) for path in files])


def _print_side(data: Mapping[str, Any], console: Console) -> None:
    """Print what the torque and each component beside it make of the line of sight, where several fly."""
    for mode in data["modes"]:
        if mode["side_rows"]:
            say(console, f'Forces and moments beside the torque, mode "{mode["name"]}", at its worst rate', "bold")
            side_table(mode).print(console)


def _drivers(r: Mapping[str, Any]) -> str:
    largest = [(n, s) for n, s in r["variance_shares"].items() if abs(s) >= 0.01][:SHOWN_SHARES]
    return f'{r["requirement"]}, mode "{r["mode"]}": ' + ", ".join(f"{n} {100.0 * s:.0f} %" for n, s in largest)


def _avoid(mode: Mapping[str, Any], requirement: str, ranges: Sequence[Sequence[float]]) -> str:
    avoided = ", ".join(f"{a:.4g} to {b:.4g} steps/s" for a, b in ranges)
    return f'mode "{mode["name"]}", {requirement}: {avoided} ({deciding_coupling(mode)})'
