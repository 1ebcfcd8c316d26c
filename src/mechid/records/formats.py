"""From a file to a record: the one place that knows which reader reads which format.

A further format is one reader, a function from (path, label for messages) to a `Table`, and its
suffixes in `READERS`; columns, units, clock and checks are the same for all.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from mechid.errors import RecordError, did_you_mean
from mechid.records.clock import Clock, read_clock
from mechid.records.columns import ChosenColumn, Layout, choose_columns
from mechid.records.csv import open_csv
from mechid.records.health import channel_warnings, refuse_not_finite
from mechid.records.record import Channel, Record
from mechid.records.spec import RecordSpec
from mechid.records.table import FloatArray, Table, column_label
from mechid.units import si_unit

MINIMUM_SAMPLES = 16

READERS: Mapping[str, Callable[[Path, str], Table]] = {
    ".csv": open_csv,
    ".tsv": open_csv,
    ".txt": open_csv,
    ".dat": open_csv,
    ".asc": open_csv,
}
"""Reader by suffix, in lower case."""


def read_record(path: Path, spec: RecordSpec) -> Record:
    """Read one record and check it.

    Parameters
    ----------
    path : Path
        Where the file lies.
    spec : RecordSpec
        What the campaign says of it.

    Raises
    ------
    RecordError
        The file is missing or cannot be used; one line with file, line and remedy.
    """
    _refuse_missing(path, spec.path)
    try:
        table = _reader(path, spec.path)(path, spec.path)
        return _record(path, spec, table)
    except OSError as error:
        raise RecordError(f"{spec.path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise RecordError(f"{spec.path}: is not the {error.encoding} text that it says it is") from error


def _refuse_missing(path: Path, label: str) -> None:
    if path.is_dir():
        raise RecordError(f"{label}: is a folder, not a file")
    if not path.exists():
        beside = [other.name for other in path.parent.iterdir()] if path.parent.is_dir() else []
        near = did_you_mean(path.name, beside)
        raise RecordError(f"{label}: there is no such file{near or f' ({path})'}")


def _reader(path: Path, label: str) -> Callable[[Path, str], Table]:
    if path.suffix.lower() not in READERS:
        raise RecordError(f'{label}: no reader for "{path.suffix}"; mechid reads {", ".join(READERS)}')
    return READERS[path.suffix.lower()]


def _record(path: Path, spec: RecordSpec, table: Table) -> Record:
    layout = choose_columns(table, spec)
    arrays = table.read([column.index for column in layout.chosen])
    if arrays[0].size < MINIMUM_SAMPLES:
        raise table.error(f"{arrays[0].size} samples; a record needs {MINIMUM_SAMPLES} at least")
    clock = _clock(table, layout, arrays, spec.sample_rate_hz)
    columns = zip(layout.channels, arrays[-len(layout.channels) :], strict=True)
    channels = tuple(_channel(table, column, data) for column, data in columns)
    return Record(
        name=spec.name,
        path=path,
        digest=_digest(path),
        time_start_s=clock.start_s,
        sample_rate_hz=clock.rate_hz,
        channels=channels,
        warnings=_warnings(table, layout, channels),
    )


def _clock(table: Table, layout: Layout, arrays: list[FloatArray], rate_hz: float | None) -> Clock:
    """Return the clock of the time column, else the one that the campaign gives."""
    if layout.time is not None:
        return read_clock(table, _scaled(table, layout.time, arrays[0]), rate_hz)
    if rate_hz is None:
        raise table.error("no time column; give sample_rate_hz")
    return Clock(0.0, rate_hz)


def _channel(table: Table, column: ChosenColumn, data: FloatArray) -> Channel:
    return Channel(
        quantity=column.quantity,
        unit=si_unit(column.quantity),
        data=_scaled(table, column, data),
        role=column.role,
        column=table.columns[column.index] or str(column.index),
    )


def _scaled(table: Table, column: ChosenColumn, data: FloatArray) -> FloatArray:
    """Return the column's samples in SI, shape (N,), contiguous, finite."""
    refuse_not_finite(table, data, column_label(table.columns, column.index))
    scaled = np.array(data, dtype=np.float64, order="C")
    if column.scale != 1.0:
        scaled *= column.scale
    return scaled


def _warnings(table: Table, layout: Layout, channels: tuple[Channel, ...]) -> tuple[str, ...]:
    units = [str(table.error(column.warning)) for column in layout.chosen if column.warning]
    return (*units, *(line for channel in channels for line in channel_warnings(table, channel)))


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
