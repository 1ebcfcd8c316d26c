"""Selection of the reader for a record file by its format.

A new format needs a reader, a function from (path, label for messages) to a `Table`, and its suffixes in `READERS`.
Columns, units, clock, conditioning and checks are common to all formats.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from mechid.arrays import IntArray
from mechid.errors import RecordError, did_you_mean
from mechid.reading.process import prepare
from mechid.reading.whole import is_file, is_folder, is_there, refuse_special
from mechid.records.columns import ChosenColumn, Layout, choose_columns
from mechid.records.csv import open_csv
from mechid.records.hdf5 import open_hdf5
from mechid.records.health import channel_warnings
from mechid.records.isolated_table import Reader, open_guarded
from mechid.records.matlab import open_matlab
from mechid.records.matlab73 import is_matlab73
from mechid.records.numpy_file import open_npy, open_npz
from mechid.records.parquet import open_parquet
from mechid.records.record import Channel, Record
from mechid.records.sampling import sample
from mechid.records.spec import VOLTAGE, RecordSpec
from mechid.records.table import Table
from mechid.records.tdms import open_tdms
from mechid.records.uff import open_uff
from mechid.signal.series import Series, no_samples
from mechid.units import si_unit
from mechid.writing import mark_as_read

MIN_SAMPLES = 16

TEXTS = (".csv", ".tsv", ".txt", ".dat", ".asc", ".dcexp")
GUARDED: Mapping[str, Reader] = {
    ".mat": open_matlab,
    **dict.fromkeys((".h5", ".hdf5", ".hdf", ".nc"), open_hdf5),
    ".tdms": open_tdms,
    **dict.fromkeys((".uff", ".unv", ".u58"), open_uff),
    **dict.fromkeys((".parquet", ".pq"), open_parquet),
    ".npy": open_npy,
    ".npz": open_npz,
}
"""Readers that run in the reading process (`mechid.reading`), isolated from crashes caused by damaged files."""
READERS: Mapping[str, Callable[[Path, str], Table]] = {**dict.fromkeys(TEXTS, open_csv), **GUARDED}
"""Reader by suffix, in lower case."""
READERS_WITH_LINKS = (open_hdf5, open_matlab)
"""Readers of formats whose files may refer to data in other files."""
LIBRARIES: Mapping[Reader, str] = {
    open_hdf5: "h5py",
    open_tdms: "nptdms",
    open_uff: "pyuff",
    open_parquet: "pyarrow.parquet",
}
"""Library of each reader, imported in advance."""


def read_record(path: Path, spec: RecordSpec) -> Record:
    """Read one record and check it.

    Parameters
    ----------
    path : Path
        Location of the file.
    spec : RecordSpec
        Declaration in the campaign.

    Raises
    ------
    RecordError
        The file is missing or invalid; a one-line message names the file, the line and the remedy.
    """
    began = time.perf_counter()
    with wrap_read_errors(spec.path):
        record = record_from(path, spec, open_table(path, spec.path, spec.external_files))
        # Only now: a rejected file may be of any size.
        digest = digest_of(path)
    return replace(record, digest=digest, reading_s=time.perf_counter() - began)


def open_table(path: Path, label: str, external_files: tuple[str, ...] = ()) -> Table:
    """Open a file of any supported format and return its table.

    Parameters
    ----------
    path : Path
    label : str
        Name of the file in messages.
    external_files : tuple of str
        Other files from which numbers may be taken.

    Raises
    ------
    RecordError
        The file is missing, of an unknown format, or cannot be read.
    """
    _refuse_missing(path, label)
    suffix = _suffix(path, label)
    with wrap_read_errors(label):
        # Checked before opening, since a pipe or a device may block forever.
        refuse_special(path)
        mark_as_read(path)
        if external_files and READERS[suffix] not in READERS_WITH_LINKS:
            raise RecordError(f"{label}: external_files: only HDF5 and MATLAB 7.3 name other files; leave it out")
        if suffix in GUARDED:
            return open_guarded(path, label, GUARDED[suffix], _libraries(path), external_files)
        return READERS[suffix](path, label)


def prepare_to_read(paths: Iterable[Path]) -> None:
    """Start the reading process in advance if one of the files needs it."""
    guarded = [path for path in paths if path.suffix.lower() in GUARDED and is_file(path)]
    if guarded:
        prepare(sorted({library for path in guarded for library in _libraries(path)}))


@contextmanager
def wrap_read_errors(label: str) -> Iterator[None]:
    """Convert errors of reading a file to a RecordError with its name."""
    try:
        yield
    except OSError as error:
        raise RecordError(f"{label}: cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise RecordError(f"{label}: is not valid {error.encoding} text, which it claims to be") from error
    except MemoryError as error:
        raise RecordError(f"{label}: does not fit into memory; read a part of it with window_s") from error


def _refuse_missing(path: Path, label: str) -> None:
    if is_folder(path):
        raise RecordError(f"{label}: is a folder, not a file")
    if not is_there(path):
        beside = [other.name for other in path.parent.iterdir()] if is_folder(path.parent) else []
        near = "; it is a broken link" if path.is_symlink() else did_you_mean(path.name, beside)
        where = "; check the path" if str(path) == label else f" ({path})"
        raise RecordError(f"{label}: there is no such file{near or where}")


def _suffix(path: Path, label: str) -> str:
    suffix = path.suffix.lower()
    if suffix not in READERS:
        raise RecordError(f'{label}: no reader for "{path.suffix}"; mechid reads {", ".join(READERS)}')
    return suffix


def _libraries(path: Path) -> tuple[str, ...]:
    reader = GUARDED[path.suffix.lower()]
    if reader is open_matlab:
        return ("h5py" if is_matlab73(path) else "scipy.io",)
    return (LIBRARIES[reader],) if reader in LIBRARIES else ()


def record_from(path: Path, spec: RecordSpec, table: Table, digest: str = "") -> Record:
    """Return the record of an opened table; `path` and `digest` identify the source of its samples.

    Raises
    ------
    RecordError
        The samples are not usable.
    """
    layout = choose_columns(table, spec)
    samples = sample(table, layout, spec)
    if samples.data[0].size < MIN_SAMPLES:
        raise table.error(f"{samples.data[0].size} samples; a record needs {MIN_SAMPLES} at least")
    pairs = enumerate(zip(layout.channels, samples.data, strict=True))
    bridged = samples.bridged
    channels = tuple(_channel(table, column, data, bridged.get(k, no_samples())) for k, (column, data) in pairs)
    return Record(
        name=spec.name,
        path=path,
        digest=digest,
        time_start_s=samples.clock.start_s,
        sample_rate_hz=samples.clock.rate_hz,
        channels=channels,
        warnings=_warnings(table, layout, channels),
        start_time=table.columns[layout.channels[0].index].start_time,
        metadata=table.metadata,
        treatments=samples.treatments,
    )


def _channel(table: Table, chosen: ChosenColumn, data: Series, bridged: IntArray) -> Channel:
    column = table.columns[chosen.index]
    return Channel(
        quantity=chosen.quantity,
        unit=si_unit(VOLTAGE if chosen.in_volts else chosen.quantity),
        data=data,
        role=chosen.role,
        column=column.key or str(chosen.index),
        metadata=column.metadata,
        scale=chosen.scale,
        bridged=bridged,
    )


def _warnings(table: Table, layout: Layout, channels: tuple[Channel, ...]) -> tuple[str, ...]:
    units = [str(table.error(column.warning)) for column in layout.selected_columns if column.warning]
    pairs = zip(channels, layout.channels, strict=True)
    health = [line for channel, chosen in pairs for line in channel_warnings(table, channel, chosen.warning)]
    return (*table.warnings, *units, *health)


def digest_of(path: Path) -> str:
    """Return the SHA-256 digest of a file in hexadecimal notation."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
