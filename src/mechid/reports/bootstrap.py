"""A bootstrap: every number in one dict, its files, and its ink for a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from mechid.identification.refit.bootstrap import Bootstrap, DrawOutcome, Spread
from mechid.identification.result.estimate_file import json_text
from mechid.ink.console import print_lines, say, say_if_synthetic
from mechid.ink.digits import digits, like, with_sigma
from mechid.ink.text_table import Column, print_tables
from mechid.signal.autoregression import Autoregression
from mechid.writing import write_together

FORMAT = "mechid-bootstrap/1"
FILE_NAME, DRAWS_NAME = "bootstrap.json", "bootstrap.csv"
NAME = (Column("parameter", "name", words=True), Column("estimate", "estimate"), Column("unit", "unit", words=True))
SCATTER = (
    Column("+- sigma", "std_error"),
    Column("scatter", "deviation"),
    Column("shift", "mean_shift"),
    Column("95 % from", "low"),
    Column("to", "high"),
)
LAYOUTS = (((*NAME, *SCATTER),), (NAME, (NAME[0], *SCATTER)))


def bootstrap_data(found: Bootstrap, seed: int) -> dict[str, Any]:
    """Return all that a bootstrap shows: numbers, and beside those that need rounding their text."""
    return {
        "format": FORMAT,
        "synthetic": found.synthetic,
        "seed": seed,
        "draws": len(found.draws),
        "tally": {outcome.code: count for outcome, count in found.tally.items()},
        "noise": {name: _noise(own) for name, own in found.noise.items()},
        "parameters": {s.name: _spread(s) for s in found.spreads},
        "refits": [{"draw": d.number, "outcome": d.outcome.code, "cost": d.cost, **d.values} for d in found.draws],
        "warnings": [
            f"{count} of {len(found.draws)} refits {outcome.value}"
            for outcome, count in found.tally.items()
            if count and outcome is not DrawOutcome.CONVERGED
        ],
    }


def write_bootstrap(data: Mapping[str, Any], folder: Path | str) -> list[Path]:
    """Write bootstrap.json and bootstrap.csv, one line a draw, into a folder, made where it is missing.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    names = list(data["refits"][0])
    rows = [",".join(names)] + [",".join(str(refit[name]) for name in names) for refit in data["refits"]]
    return write_together(folder, {FILE_NAME: json_text(data), DRAWS_NAME: "\n".join(rows) + "\n"})


def print_bootstrap(data: Mapping[str, Any], console: Console, files: Sequence[Path] = ()) -> None:
    """Print what `bootstrap_data` made, and where the files are."""
    say_if_synthetic(console, data)
    say(
        console,
        f"{data['draws']} refits; scatter: their standard deviation, shift: their mean less the estimate",
        "bold",
    )
    print_tables(console, LAYOUTS, [{"name": name, **p} for name, p in data["parameters"].items()])
    print_lines(console, "warning", data["warnings"], "yellow")
    print_lines(console, "written", [str(path) for path in files])


def _spread(s: Spread) -> dict[str, Any]:
    value, error = with_sigma(s.value, s.std_error or s.deviation)
    return {
        "unit": s.unit,
        "value": s.value,
        "std_error": s.std_error,
        "deviation": s.deviation,
        "mean_shift": s.mean_shift,
        "ci95": list(s.interval),
        "text": {
            "estimate": value,
            "std_error": error if s.std_error else "",
            "deviation": digits(s.deviation, 2),
            "mean_shift": digits(s.mean_shift, 2),
            "low": like(s.interval[0], s.deviation),
            "high": like(s.interval[1], s.deviation),
            "unit": "" if s.unit == "1" else s.unit,
        },
    }


def _noise(own: Mapping[str, Autoregression]) -> dict[str, Any]:
    """Return what the noise of a record was drawn from, by channel."""
    return {quantity: {"order": model.order, "sigma": model.sigma} for quantity, model in own.items()}
