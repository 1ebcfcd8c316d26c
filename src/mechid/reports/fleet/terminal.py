"""The ink of a fleet on a terminal; its numbers are those of fleet.json."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from mechid.reports.console import print_lines, say
from mechid.reports.fit.verdict import BAD, CAUTION, GOOD
from mechid.reports.fleet.contents import fleet_contents
from mechid.reports.fleet.verdict import SYNTHETIC
from mechid.reports.text_table import Column, print_table, print_tables

STYLES = {GOOD: "bold green", CAUTION: "bold yellow", BAD: "bold red"}
CAMPAIGNS = (
    Column("campaign", "label", words=True),
    Column("unit", "unit", words=True),
    Column("group", "group", words=True),
    Column("state", "state", words=True),
    Column("grade", "grade", words=True),
    Column("", "how_words", words=True),
    Column("took s", "seconds"),
)
PARAMETER = Column("parameter", "key", words=True)
FLEET = (
    Column("units", "units"),
    Column("mean", "mean"),
    Column("+- sigma", "std_error"),
    Column("unit", "unit", words=True),
)
SPREAD = (
    Column("spread", "spread"),
    Column("95 %", "spread95"),
    Column("", "differs", words=True),
    Column("stands off", "outliers", words=True, style="yellow"),
    Column("", "lacking", words=True),
)
LAYOUTS = (((PARAMETER, *FLEET, *SPREAD),), ((PARAMETER, *FLEET), (PARAMETER, *SPREAD)))


def print_fleet(data: Mapping[str, Any], console: Console, files: Sequence[Path] = ()) -> None:
    """Print what `fleet_data` made, and where the files are."""
    contents = fleet_contents(data)
    verdict = contents["verdict"]
    if data["synthetic"]:
        say(console, SYNTHETIC, "bold")
    say(console, verdict["headline"], STYLES[verdict["tone"]])
    for each in verdict["questions"]:
        say(console, each["question"], "bold")
        for answer in each["answers"]:
            say(console, f"  {answer}")
    console.print()
    say(console, "Campaigns", "bold")
    print_table(console, CAMPAIGNS, contents["campaigns"])
    if contents["parameters"]:
        say(
            console,
            "Parameters over the units: mean, and spread from unit to unit without the estimates' errors",
            "bold",
        )
        print_tables(console, LAYOUTS, contents["parameters"])
    print_lines(console, "caution", data["cautions"], "yellow")
    print_lines(console, "written", [str(path) for path in files])
