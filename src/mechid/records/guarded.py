"""Files whose readers run in the process that reads: the head comes here, samples when they are wanted."""

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
from mechid.records.foreign import wrap_parser_errors

Reader = Callable[..., ArrayTable]
CACHED_TABLES = 2
"""Files of which the process that reads remembers the head, or all where they are read whole."""


@dataclass(frozen=True, kw_only=True)
class Source:
    """A file and how it is read.

    Parameters
    ----------
    path : Path
        Absolute.
    label : str
        What messages call it.
    reader : callable
        A function of a module: of path, label, and `external_files` where there are any.
    libraries : tuple of str
        Modules that it needs.
    external_files : tuple of str
        Other files that its numbers may come from.
    state : tuple of int
        Size in bytes, and when it was changed: after a change it is another file.
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
    """Return the table of a file that another process reads; the arguments are those of a `Source`.

    Raises
    ------
    RecordError
        What its reader says; or it crashed, came to no end, or took too much memory.
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
    """Return the part at an index of what a column is loaded from, read elsewhere."""
    return call(_load_part, source, number, index, size=source.state[0], libraries=source.libraries)


def _read_head(source: Source) -> ArrayTable:
    """Return the table without what loads it, which stays where this is called."""
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
