"""The ink of a budget on a terminal; its numbers are those of budget.json."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from mechid.reports.budget.contents import requirement_text, side_rows
from mechid.reports.budget.verdict import budget_verdict
from mechid.reports.console import print_lines, say
from mechid.reports.digits import plain
from mechid.reports.text_table import Column, print_table

REQUIREMENTS = (
    Column("requirement", "requirement", words=True),
    Column("mode", "mode", words=True),
    Column("index", "index", words=True),
    Column("axis", "axis", words=True),
    Column("level rad", "level"),
    Column("+- sigma", "sigma"),
    Column("by draws", "sampling"),
    Column("lacking rad", "lacking"),
    Column("by ECSS sum", "ecss"),
    Column("limit rad", "limit"),
    Column("one-way %", "one_way_margin"),
    Column("two-way %", "two_way_margin"),
    Column("decides %", "deciding", style="bold"),
    Column("", "met", words=True),
)
MODES = (
    Column("mode", "name", words=True),
    Column("worst rate", "rate"),
    Column("torque RMS N m", "torque"),
    Column("line of sight RMS rad", "one_way"),
    Column("lacking", "lacking"),
    Column("two-way", "two_way"),
    Column("|R K|", "gain"),
)
SIDE = (
    Column("", "name", words=True),
    Column("with phase", "coherent"),
    Column("by magnitude", "magnitude"),
    Column("line of sight RMS rad", "rms", words=True),
)
SHOWN_SHARES, SHOWN_CROSSINGS = 3, 12


def print_budget(data: Mapping[str, Any], console: Console, files: Sequence[Path] = ()) -> None:
    """Print what `budget_data` made, and where the files are."""
    verdict = budget_verdict(data)
    say(console, verdict["headline"], "bold")
    print_lines(console, "margin", verdict["questions"][0]["answers"] if data["requirements"] else [])
    say(console, "Modes of operation, at the rate of the largest line-of-sight RMS in full steps/s", "bold")
    print_table(console, MODES, [_mode(mode) for mode in data["modes"]])
    _print_side(data, console)
    if data["requirements"]:
        say(
            console, "Requirements, at the worst rate of each; what decides is the lower 95 % limit of a margin", "bold"
        )
        print_table(console, REQUIREMENTS, [_requirement(r) for r in data["requirements"]])
        print_lines(console, "driven by", [_drivers(r) for r in data["requirements"]])
    for mode in data["modes"]:
        print_lines(console, "avoid", [_avoid(mode["name"], n, r) for n, r in mode["avoid"].items() if r])
    told = [f"order {c['order']:g} meets {c['mode']} at {c['rate']:.4g} steps/s" for c in data["crossings"]]
    print_lines(console, "crossing", told[:SHOWN_CROSSINGS])
    if len(told) > SHOWN_CROSSINGS:
        say(console, f"... and {len(told) - SHOWN_CROSSINGS} further crossings in crossings.csv")
    print_lines(console, "note", data["notes"])
    print_lines(console, "warning", data["warnings"], "yellow")
    print_lines(console, "written", [str(path) for path in files])


def _print_side(data: Mapping[str, Any], console: Console) -> None:
    """Print what the torque and each component beside it make of the line of sight, where several fly."""
    for mode in data["modes"]:
        rows = [dict(zip(("name", "coherent", "magnitude", "rms"), row, strict=True)) for row in side_rows(data, mode)]
        if rows:
            say(console, f'Forces and moments beside the torque, mode "{mode["name"]}", at its worst rate', "bold")
            print_table(console, SIDE, [{"text": {}, **row} for row in rows])


def _mode(mode: Mapping[str, Any]) -> dict[str, Any]:
    two_way, lacking = mode["line_of_sight_rms_two_way_rad"], mode.get("line_of_sight_rms_lacking_rad")
    return {
        "text": {},
        "name": mode["name"],
        "rate": plain(mode["worst_rate"], 4),
        "torque": plain(mode["torque_rms_Nm"], 3),
        "one_way": ", ".join(plain(v, 3) for v in mode["line_of_sight_rms_rad"]),
        "lacking": ", ".join(plain(v, 3) for v in lacking) if lacking and any(lacking) else "-",
        "two_way": ", ".join(plain(v, 3) for v in two_way) if two_way else "-",
        "gain": plain(mode["loop_gain"], 2),
    }


def _requirement(r: Mapping[str, Any]) -> dict[str, Any]:
    return {
        **{key: r[key] for key in ("requirement", "mode", "axis")},
        "text": {**requirement_text(r), "index": r["index"]},
    }


def _drivers(r: Mapping[str, Any]) -> str:
    largest = [(n, s) for n, s in r["variance_shares"].items() if abs(s) >= 0.01][:SHOWN_SHARES]
    return f'{r["requirement"]}, mode "{r["mode"]}": ' + ", ".join(f"{n} {100.0 * s:.0f} %" for n, s in largest)


def _avoid(mode: str, requirement: str, ranges: Sequence[Sequence[float]]) -> str:
    return f'mode "{mode}", {requirement}: ' + ", ".join(f"{a:.4g} to {b:.4g} steps/s" for a, b in ranges)
