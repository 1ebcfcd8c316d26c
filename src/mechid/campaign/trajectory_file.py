"""CSV files of simulated records."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from mechid.errors import FitError, UsageError
from mechid.signal.series import Series
from mechid.simulation.trajectory import SimulationOutcome, Trajectory
from mechid.units import SI_UNIT
from mechid.writing import write_together

REMEDY = (
    "Check the mechanism file: with an inertia or inductance too small, or a damping or a chopper's clock too large, "
    "it is too fast for the sample rate"
)
# A long record must not fill the memory.
ROWS = 8192
"""Rows formatted at once."""
TIME_FORMAT, TORQUE_FORMAT = "%.15g", "%.12e"
SIMULATED = re.compile(r"-?\d\.\d{12}e[+-]\d+")
"""A number in `TORQUE_FORMAT`."""
LONGEST_LINE = 4096


def write_trajectories(trajectories: Mapping[str, Trajectory], folder: Path | str) -> dict[str, Path]:
    """Write each trajectory as ``<name>.csv`` with one header line; all files or none.

    Parameters
    ----------
    trajectories : mapping of str to Trajectory
        Trajectories by record name.
    folder : Path
        Created with its parents if missing; files of these names are replaced.

    Returns
    -------
    dict of str to Path
        The files written.

    Raises
    ------
    FitError
        A trajectory is incomplete; no file is written.
    UsageError
        The folder is not writable.
    """
    refuse_incomplete(trajectories)
    files = write_together(folder, {f"{name}.csv": _rows(trajectory) for name, trajectory in trajectories.items()})
    return dict(zip(trajectories, files, strict=True))


def refuse_measured(files: Iterable[Path], names: Iterable[str], folder: Path | str) -> None:
    """Raise UsageError if a simulated ``<name>.csv`` would replace a measured file.

    A file counts as measured if it is one of `files` or was not written by `write_trajectories`: another campaign in
    the folder may use the same names.
    """
    measured = {file.resolve() for file in files}
    for place in (Path(folder) / f"{name}.csv" for name in names):
        if place.resolve() in measured or (place.exists() and not _is_simulated(place)):
            raise UsageError(
                f"{folder}: holds {place.name}, which is no simulation of mechid's and is not replaced; give another "
                "folder"
            )


def _is_simulated(path: Path) -> bool:
    """Return whether a file looks like output of `record_rows`, judged by the digits of its second line."""
    try:
        with path.open("rb") as file:
            header, row = file.readline(LONGEST_LINE), file.readline(LONGEST_LINE)
    except OSError:
        return False
    # Measured files have other numbers of digits, so the format of the second line decides.
    cells = row.decode("ascii", errors="replace").strip().split(",")[1:]
    return header.startswith(b"time_s,") and bool(cells) and all(map(SIMULATED.fullmatch, cells))


def _rows(trajectory: Trajectory) -> Iterator[str]:
    others = {quantity: y for quantity, y in trajectory.values.items() if quantity != trajectory.quantity}
    return record_rows(
        trajectory.time, trajectory.values[trajectory.quantity], quantity=trajectory.quantity, others=others
    )


def refuse_incomplete(trajectories: Mapping[str, Trajectory]) -> None:
    """Raise FitError for the first trajectory that was not simulated to its end."""
    for name, trajectory in trajectories.items():
        if trajectory.outcome is not SimulationOutcome.COMPLETE:
            at = "" if trajectory.lost_from_s is None else f" at {trajectory.lost_from_s:.9g} s"
            raise FitError(f'record "{name}"{at}: {trajectory.outcome.value} {REMEDY}')


def record_rows(
    time: Series,
    measured: Series,
    *,
    quantity: str = "torque",
    others: Mapping[str, Series] | None = None,
    time_format: str = TIME_FORMAT,
    torque_format: str = TORQUE_FORMAT,
) -> Iterator[str]:
    """Yield a record as CSV text in blocks: a header line, then time in s and one or more quantities in SI units."""
    columns = {quantity: measured, **(others or {})}
    row = ",".join([time_format, *(torque_format for _ in columns)]) + "\n"
    names = [f"{name}_{SI_UNIT[name].replace('*', '').replace('/', '_')}" for name in columns]
    yield ",".join(["time_s", *names]) + "\n"
    for start in range(0, time.size, ROWS):
        cells = zip(*(values[start : start + ROWS].tolist() for values in (time, *columns.values())), strict=True)
        yield "".join(row % line for line in cells)
