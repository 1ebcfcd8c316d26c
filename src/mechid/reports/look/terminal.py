"""The ink of a look on a terminal; its numbers are those of look.json."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from mechid.ink.console import print_lines, say
from mechid.ink.quantities import quantity_words

ABOUT = ("health", "noise", "lines", "mains", "resonances")


def print_look(data: Mapping[str, Any], console: Console, files: Sequence[Path] = ()) -> None:
    """Print what `look_data` made, and where the files are."""
    for record in data["records"]:
        text = record["text"]
        say(console, f"{record['name']}  ({record['file']})", "bold")
        say(console, f"  {text['samples']} samples at {text['sample_rate_hz']} Hz, {text['duration_s']} s")
        for line in (*record["treatments"], *record["driven"]["words"]):
            say(console, f"  {line}")
        for channel in record["channels"]:
            _print_channel(channel, console)
        console.print()
    print_lines(console, "resonance", [one["words"] for one in data["resonances"]])
    print_lines(console, "warning", [line for record in data["records"] for line in record["warnings"]], "yellow")
    print_lines(console, "left out", [one["message"] for one in data["left_out"]], "yellow")
    print_lines(console, "written", [str(path) for path in files])


def _print_channel(channel: Mapping[str, Any], console: Console) -> None:
    unit = f", {channel['unit']}" if channel["unit"] else ""
    say(console, f"  {quantity_words(channel['quantity'])}{unit} (column {channel['column']})", "bold")
    for about in ABOUT:
        say(console, f"    {about}: {' '.join(channel['words'][about])}")
