"""Simulated records as files that `mechid` and others read."""

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
    "Check the mechanism file: with an inertia or inductance too small, or a damping too large, it is too "
    "fast for the sample rate"
)
ROWS = 8192
"""Rows made into text at once, so that a long record does not fill the memory."""
TIME_FORMAT, TORQUE_FORMAT = "%.15g", "%.12e"
SIMULATED = re.compile(r"-?\d\.\d{12}e[+-]\d+")
"""A number in `TORQUE_FORMAT`."""
LONGEST_LINE = 4096


def write_trajectories(trajectories: Mapping[str, Trajectory], folder: Path | str) -> dict[str, Path]:
    """Write each trajectory as ``<name>.csv``, one header line; all or none.

    Parameters
    ----------
    trajectories : mapping of str to Trajectory
        By record name.
    folder : Path
        Made with its parents where it is missing; earlier files of the names are replaced.

    Returns
    -------
    dict of str to Path
        The files written.

    Raises
    ------
    FitError
        One of them is not complete; then none is written.
    UsageError
        The folder cannot be written to.
    """
    refuse_lost(trajectories)
    files = write_together(folder, {f"{name}.csv": _rows(trajectory) for name, trajectory in trajectories.items()})
    return dict(zip(trajectories, files, strict=True))


def refuse_measured(files: Iterable[Path], names: Iterable[str], folder: Path | str) -> None:
    """Raise UsageError where a simulated ``<name>.csv`` would replace a measured one.

    That is one of `files`, or any that `write_trajectories` has not written: another campaign's may have equal names.
    """
    measured = {file.resolve() for file in files}
    for place in (Path(folder) / f"{name}.csv" for name in names):
        if place.resolve() in measured or (place.exists() and not _is_simulated(place)):
            raise UsageError(
                f"{folder}: holds {place.name}, which is no simulation of mechid's and is not replaced; give another "
                "folder"
            )


def _is_simulated(path: Path) -> bool:
    """Tell whether a file begins as `record_rows` makes it, by the digits of its second line."""
    try:
        with path.open("rb") as file:
            header, row = file.readline(LONGEST_LINE), file.readline(LONGEST_LINE)
    except OSError:
        return False
    cells = row.decode("ascii", errors="replace").strip().split(",")[1:]
    return header.startswith(b"time_s,") and bool(cells) and all(map(SIMULATED.fullmatch, cells))


def _rows(trajectory: Trajectory) -> Iterator[str]:
    others = {quantity: y for quantity, y in trajectory.values.items() if quantity != trajectory.quantity}
    return record_rows(
        trajectory.time, trajectory.values[trajectory.quantity], quantity=trajectory.quantity, others=others
    )


def refuse_lost(trajectories: Mapping[str, Trajectory]) -> None:
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
    """Yield a record as text, piece by piece: a header line, then time in s and one or more quantities in SI."""
    columns = {quantity: measured, **(others or {})}
    row = ",".join([time_format, *(torque_format for _ in columns)]) + "\n"
    names = [f"{name}_{SI_UNIT[name].replace('*', '').replace('/', '_')}" for name in columns]
    yield ",".join(["time_s", *names]) + "\n"
    for start in range(0, time.size, ROWS):
        cells = zip(*(values[start : start + ROWS].tolist() for values in (time, *columns.values())), strict=True)
        yield "".join(row % line for line in cells)
