"""Document of simulated records: samples, size, accuracy and figure of each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from mechid.campaign.trajectory_file import write_trajectories
from mechid.identification.result.estimate_file import json_text
from mechid.ink.document import IN_DOCUMENTS, Document, Lines, Picture, Rows, Section, Words
from mechid.ink.presenter import Presenter
from mechid.ink.table import Table
from mechid.ink.text_table import Column
from mechid.simulation.trajectory import Trajectory
from mechid.simulations.numbers import FILE_NAME, figure_name, simulation_numbers
from mechid.simulations.run import Simulated

ALONE = "trajectory"
"""Name of a trajectory without a record."""
COLUMNS = (
    Column("record", "name", words=True),
    Column("samples", "samples"),
    Column("RMS", "rms"),
    Column("peak", "peak"),
    Column("unit", "unit", words=True),
    Column("steps/sample", "substeps"),
    Column("difference", "difference"),
)
MEANING = (
    "What the mechanism as written would do, without noise and offset. The difference is by how much half the "
    "integration step changes a record, as a share of its RMS."
)


def simulation_document(data: Mapping[str, Any]) -> Document:
    """Make the document from the result of `simulation_numbers`."""
    records = [_record(row) for row in data["records"]]
    return Document(
        title="Simulated records",
        command="mechid simulate",
        under=data["campaign"],
        parts=(
            Words(MEANING, where=IN_DOCUMENTS),
            Rows(Table(COLUMNS, data["records"])),
            Lines(data["warnings"], "warning", "Warnings", "yellow"),
            *records,
        ),
    )


def _record(row: Mapping[str, Any]) -> Section:
    name = row["name"]
    picture = Picture(figure_name(name), f"{name} over time, simulated")
    return Section(name, (Words(row["command"]), picture), f"record-{name}", name, where=IN_DOCUMENTS)


def _as_simulated(found: Simulated | Trajectory) -> Simulated:
    return Simulated(trajectories={ALONE: found}) if isinstance(found, Trajectory) else found


def _figures(found: Simulated | Trajectory, _numbers: Mapping[str, Any]) -> Iterator[Any]:
    # Imported here, since Matplotlib takes half a second to load.
    from mechid.simulations.figures import simulation_figures

    yield from simulation_figures(_as_simulated(found))


def _line(found: Simulated | Trajectory) -> str:
    runs = _as_simulated(found).trajectories.values()
    return "; ".join(f"{', '.join(r.values)}: {r.time.size} samples, {r.outcome.name.lower()}" for r in runs)


def _files(found: Simulated | Trajectory, _numbers: Mapping[str, Any], folder: Path) -> list[Path]:
    return [*write_trajectories(_as_simulated(found).trajectories, folder).values()]


PRESENTER = Presenter(
    name="simulate",
    numbers=lambda found: simulation_numbers(_as_simulated(found)),
    document=simulation_document,
    line=_line,
    texts=lambda _found, data: {FILE_NAME: json_text(data)},
    files=_files,
    figures=_figures,
)
