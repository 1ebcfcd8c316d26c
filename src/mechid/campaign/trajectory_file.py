"""Simulated records as files that `mechid` and others read."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mechid.errors import FitError
from mechid.simulation.trajectory import SimulationOutcome, Trajectory
from mechid.units import SI_UNIT
from mechid.writing import writable, write_whole

REMEDY = (
    "Check the mechanism file: with an inertia or inductance too small, or a damping too large, it is too "
    "fast for the sample rate"
)
ROWS = 8192
"""Rows made into text at once, so that a long record does not fill the memory."""
TIME_FORMAT, TORQUE_FORMAT = "%.15g", "%.12e"


def write_trajectories(trajectories: Mapping[str, Trajectory], folder: Path | str) -> dict[str, Path]:
    """Write each trajectory as ``<name>.csv``, one header line; whole or not at all.

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
    files = {name: Path(folder) / f"{name}.csv" for name in trajectories}
    with writable(folder):
        for name, path in files.items():
            trajectory = trajectories[name]
            others = {quantity: y for quantity, y in trajectory.values.items() if quantity != trajectory.quantity}
            rows = record_rows(trajectory.time, trajectory.measured, quantity=trajectory.quantity, others=others)
            write_whole(path, rows)
    return files


def refuse_lost(trajectories: Mapping[str, Trajectory]) -> None:
    """Raise FitError for the first trajectory that was not simulated to its end."""
    for name, trajectory in trajectories.items():
        if trajectory.outcome is not SimulationOutcome.COMPLETE:
            at = "" if trajectory.lost_from_s is None else f" at {trajectory.lost_from_s:.9g} s"
            raise FitError(f'record "{name}"{at}: {trajectory.outcome.value} {REMEDY}')


def record_rows(
    time: NDArray[np.float64],
    measured: NDArray[np.float64],
    *,
    quantity: str = "torque",
    others: Mapping[str, NDArray[np.float64]] | None = None,
    time_format: str = TIME_FORMAT,
    torque_format: str = TORQUE_FORMAT,
) -> Iterator[str]:
    """Yield a record as text, piece by piece: a header line, then time in s and one or more quantities in SI, (n,)."""
    columns = {quantity: measured, **(others or {})}
    row = ",".join([time_format, *(torque_format for _ in columns)]) + "\n"
    names = [f"{name}_{SI_UNIT[name].replace('*', '').replace('/', '_')}" for name in columns]
    yield ",".join(["time_s", *names]) + "\n"
    for start in range(0, time.size, ROWS):
        cells = zip(*(values[start : start + ROWS].tolist() for values in (time, *columns.values())), strict=True)
        yield "".join(row % line for line in cells)
