"""The ink of a fleet on a terminal; its numbers are those of fleet.json."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from mechid.ink.console import print_lines, say
from mechid.reports.fleet.contents import fleet_contents
from mechid.reports.fleet.tables import campaign_table, parameter_table
from mechid.reports.fleet.verdict import SYNTHETIC
from mechid.reports.verdict import BAD, CAUTION, GOOD

STYLES = {GOOD: "bold green", CAUTION: "bold yellow", BAD: "bold red"}


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
    campaign_table(contents).print(console)
    if contents["parameters"]:
        say(
            console,
            "Parameters over the units: mean, and spread from unit to unit without the estimates' errors",
            "bold",
        )
        parameter_table(contents).print(console)
    print_lines(console, "caution", data["cautions"], "yellow")
    print_lines(console, "written", [str(path) for path in files])
