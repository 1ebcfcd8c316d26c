"""What is shown of simulated records."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.console import Console

from mechid.ink.console import print_lines
from mechid.ink.digits import digits
from mechid.ink.text_table import Column, print_table
from mechid.signal.moments import extremes, root_mean_square
from mechid.simulation.accuracy import PROMISE
from mechid.simulation.trajectory import Trajectory
from mechid.units import SI_UNIT

COLUMNS = (
    Column("record", "name", words=True),
    Column("samples", "samples"),
    Column("RMS", "rms"),
    Column("peak", "peak"),
    Column("unit", "unit", words=True),
    Column("steps/sample", "substeps"),
    Column("difference", "difference"),
)


def simulated_data(trajectories: Mapping[str, Trajectory], files: Mapping[str, Path]) -> dict[str, Any]:
    """Return all that `mechid simulate` shows."""
    return {
        "records": [_row(name, trajectory) for name, trajectory in trajectories.items()],
        "files": [str(path) for path in files.values()],
        "warnings": [
            f'record "{name}": halving the integration step still changes the {t.quantity} by {t.difference:.1e} '
            "of its RMS: a switch between stick and slip falls either way within that"
            for name, t in trajectories.items()
            if t.difference is not None and t.difference > PROMISE
        ],
    }


def print_simulated(data: Mapping[str, Any], console: Console) -> None:
    """Print what `simulated_data` made."""
    print_table(console, COLUMNS, data["records"])
    print_lines(console, "warning", data["warnings"], "yellow")
    print_lines(console, "written", data["files"])


def _row(name: str, trajectory: Trajectory) -> dict[str, Any]:
    measured = trajectory.values[trajectory.quantity]
    rms, peak = root_mean_square(measured), max(map(abs, extremes(measured)))
    return {
        "name": name,
        "samples": trajectory.time.size,
        "unit": SI_UNIT[trajectory.quantity].replace("*", " "),
        "rms": rms,
        "peak": peak,
        "substeps": trajectory.substeps,
        "difference": trajectory.difference,
        "text": {
            "rms": digits(rms, 4),
            "peak": digits(peak, 4),
            "difference": "-" if trajectory.difference is None else f"{trajectory.difference:.1e}",
        },
    }
