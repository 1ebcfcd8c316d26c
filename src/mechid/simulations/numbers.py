"""Numbers of simulated records, in one dict."""

from __future__ import annotations

from typing import Any

from mechid.command.words import command_words
from mechid.identification.output_error.digests import file_digests
from mechid.ink.digits import digits
from mechid.signal.moments import extremes, root_mean_square
from mechid.simulation.accuracy import PROMISE
from mechid.simulation.trajectory import Trajectory
from mechid.simulations.run import Simulated
from mechid.units import SI_UNIT

FORMAT = "mechid-simulation/1"
FILE_NAME = "simulate.json"


def simulation_numbers(found: Simulated) -> dict[str, Any]:
    """Return the numbers shown for simulated records."""
    campaign = found.campaign
    commands = {record.name: command_words(record.command) for record in campaign.records} if campaign else {}
    provenance = {"campaign": str(campaign.path.resolve()), "inputs_sha256": file_digests(campaign)} if campaign else {}
    return {
        "format": FORMAT,
        "campaign": str(campaign.path) if campaign else "",
        "records": [_row(name, run) | {"command": commands.get(name, "")} for name, run in found.trajectories.items()],
        "warnings": [
            f'record "{name}": halving the integration step still changes the {t.quantity} by {t.difference:.1e} '
            "of its RMS: a switch between stick and slip falls either way within that"
            for name, t in found.trajectories.items()
            if t.difference is not None and t.difference > PROMISE
        ],
        "provenance": provenance,
    }


def figure_name(record: str) -> str:
    """Return the name of a record's figure."""
    return f"simulated_{record}"


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
