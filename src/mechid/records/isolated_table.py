"""Tables of files that are read in the reading process: the header is transferred at once, samples on demand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechid.reading.process import call
from mechid.records.arrays import ArrayTable, Index
from mechid.records.third_party import wrap_parser_errors

Reader = Callable[..., ArrayTable]
CACHED_TABLES = 2
"""Number of files whose tables the reading process keeps; tables of formats read as a whole include all samples."""


@dataclass(frozen=True, kw_only=True)
class Source:
    """File with its reader.

    Parameters
    ----------
    path : Path
        Absolute path.
    label : str
        Name of the file in messages.
    reader : callable
        Module-level function of path, label, and optionally `external_files`.
    libraries : tuple of str
        Modules that the reader needs.
    external_files : tuple of str
        Other files from which numbers may be taken.
    state : tuple of int
        Size in bytes and modification time; a changed file is a different source in the cache.
    """

    path: Path
    label: str
    reader: Reader
    libraries: tuple[str, ...]
    external_files: tuple[str, ...]
    state: tuple[int, int]


def open_guarded(
    path: Path, label: str, reader: Reader, libraries: tuple[str, ...] = (), external_files: tuple[str, ...] = ()
) -> ArrayTable:
    """Return the table of a file that is read in the reading process; the arguments are those of a `Source`.

    Raises
    ------
    RecordError
        The reader raised an error, crashed, exceeded the time limit, or ran out of memory.
    """
    file = path.stat()
    source = Source(
        path=path.absolute(),
        label=label,
        reader=reader,
        libraries=libraries,
        external_files=external_files,
        state=(file.st_size, file.st_mtime_ns),
    )
    with wrap_parser_errors(label, f"a {path.suffix} file"):
        head = call(_read_head, source, size=file.st_size, libraries=libraries)
    places = enumerate(head.series)
    series = tuple((partial(_load_isolated, source, number), axis, first) for number, (_, axis, first) in places)
    return replace(head, series=series)


def _load_isolated(source: Source, number: int, index: Index) -> NDArray[Any]:
    """Return a part of the array of a column, read in the reading process."""
    return call(_load_part, source, number, index, size=source.state[0], libraries=source.libraries)


def _read_head(source: Source) -> ArrayTable:
    """Return the table without its loaders."""
    # Loaders are closures and open files: they cannot be pickled and remain in the reading process.
    table = _table(source)
    return replace(table, series=tuple((_not_loadable, axis, first) for _, axis, first in table.series))


def _load_part(source: Source, number: int, index: Index) -> NDArray[Any]:
    table = _table(source)
    with wrap_parser_errors(table.label, table.kind):
        return np.asarray(table.series[number][0](index), order="C")


@lru_cache(maxsize=CACHED_TABLES)
def _table(source: Source) -> ArrayTable:
    more = {"external_files": source.external_files} if source.external_files else {}
    return source.reader(source.path, source.label, **more)


def _not_loadable(index: Index) -> Any:
    raise NotImplementedError(index)
