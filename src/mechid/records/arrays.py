"""Tables of array-based files: each one-dimensional series is a column, which is read on demand."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechid.arrays import FloatArray
from mechid.errors import RecordError
from mechid.records.adjacent_scaling import add_adjacent_scaling
from mechid.records.scaling import Attributes, read_packing, unapplied_scaling
from mechid.records.table import ALL, Column, Metadata, column_label
from mechid.records.third_party import wrap_parser_errors
from mechid.signal.series import blocks

Index = tuple[int | slice, ...]
Load = Callable[[Index], Any]
MAX_SERIES = 256
"""Maximum number of parallel series in one array; a wider array is a matrix rather than a record."""
LARGEST_EXACT = 2**53
"""Largest magnitude up to which float64 represents all integers."""
UNITS_WITHOUT_LENGTH = ("Y", "M", "generic")
"""Units of NumPy's dates and durations without a fixed length in seconds."""
AT_ONCE = 2**20
"""Number of samples of a column read together: the usual size of a row group in Parquet files."""


@dataclass(frozen=True, kw_only=True)
class Item:
    """Array in a file.

    Parameters
    ----------
    column : Column
        Description of the array, except for its length and number type.
    shape : tuple of int
        One vector, or several in parallel; the longest axis is that of the samples.
    dtype : dtype
        Number type.
    load : callable
        Function that returns the part of the array at an index, like ``array[index]``.
    attributes : Mapping
        All attributes of the array in the file, by name; they may include a scaling.
    """

    column: Column
    shape: tuple[int, ...] = ()
    dtype: np.dtype[Any] = field(default_factory=lambda: np.dtype(float))
    load: Load = np.empty(0).__getitem__
    attributes: Attributes = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class ArrayTable:
    """Opened file of arrays; its header has been read, its samples are read on demand."""

    label: str
    kind: str
    columns: tuple[Column, ...]
    series: tuple[tuple[Load, int, Index], ...]
    """Source of each column: loader of the array, axis of its samples, and index of its first sample."""
    metadata: Metadata
    is_ordered: bool = False
    is_sliced: bool = False
    warnings: tuple[str, ...] = ()

    def read(self, wanted: Sequence[int], rows: slice = ALL) -> list[FloatArray]:
        """Return `rows` of the `wanted` columns, each of shape (N,), in the units of the file."""
        return [self._read_column(index, rows) for index in wanted]

    def blocks(self, wanted: Sequence[int], rows: slice = ALL) -> Iterator[list[FloatArray]]:
        """Yield the same block by block, or in one block if the file can only be read as a whole."""
        if not self.is_sliced:
            yield self.read(wanted, rows)
            return
        start, stop, _ = rows.indices(self.columns[wanted[0]].samples or 0)
        for part in blocks(max(stop - start, 0), AT_ONCE):
            yield self.read(wanted, slice(start + part.start, start + part.stop))

    def error(self, message: str, row: int | None = None) -> RecordError:
        """Return an error with the file, the sample index and `message`."""
        return RecordError(f"{self.label}:{'' if row is None else f' sample {row}:'} {message}")

    def _read_column(self, index: int, rows: slice) -> FloatArray:
        column, (load, axis, first) = self.columns[index], self.series[index]
        if column.fault:
            raise self.error(f"{column_label(self.columns, index)}: {column.fault}")
        with wrap_parser_errors(self.label, self.kind):
            part = np.asarray(load((*first[:axis], rows, *first[axis + 1 :])))
        expected = len(range(column.samples or 0)[rows])
        if part.shape != (expected,):
            label = column_label(self.columns, index)
            raise self.error(
                f"{label}: found {part.size} samples, but the header states {expected}; check that the file is complete"
            )
        return self._to_float64(part, index)

    def _to_float64(self, part: NDArray[Any], index: int) -> FloatArray:
        """Return samples as float64: durations in s, dates in s since the first one, packed numbers unpacked."""
        if part.dtype.kind == "M":
            load, _, first = self.series[index]
            # Counted from the first sample of the file rather than of the part, so that all parts share one origin.
            part = part - np.asarray(load(first))
        if part.dtype.kind == "m":
            return np.asarray(part / np.timedelta64(1, "ns") * 1e-9, dtype=np.float64)
        packing = self.columns[index].packing
        if part.dtype.kind in "iu" and part.dtype.itemsize == 8:
            # Fill values may exceed 2^53 by design; only measured values must be exact.
            measured = part[~packing.is_missing(part)] if packing else part
            if measured.size and max(abs(int(measured.min())), abs(int(measured.max()))) > LARGEST_EXACT:
                label = column_label(self.columns, index)
                raise self.error(f"{label}: whole numbers beyond 2^53, which have no exact float64")
        return packing.unpack(part) if packing else part.astype(np.float64, copy=False)


def array_table(
    label: str,
    kind: str,
    items: Iterable[Item],
    metadata: Metadata,
    *,
    is_ordered: bool = False,
    is_sliced: bool = False,
    warnings: tuple[str, ...] = (),
) -> ArrayTable:
    """Return the table of all series in `items`.

    `is_sliced` states that each item can load a part without having the rest in memory.

    Raises
    ------
    RecordError
        There are no items.
    """
    found = [pair for item in items for pair in _columns_of_item(item)]
    if not found:
        raise RecordError(f"{label}: contains no array of numbers")
    columns, series = zip(*found, strict=True)
    return ArrayTable(
        label=label,
        kind=kind,
        columns=add_adjacent_scaling(columns, metadata),
        series=series,
        metadata=metadata,
        is_ordered=is_ordered,
        is_sliced=is_sliced,
        warnings=warnings,
    )


def _columns_of_item(item: Item) -> Iterator[tuple[Column, tuple[Load, int, Index]]]:
    """Yield a column and its source for each series of an array."""
    fault = item.column.fault or _find_fault(item.dtype, item.shape)
    if fault:
        yield replace(item.column, fault=fault), (item.load, 0, ())
        return
    axis = int(np.argmax(item.shape))
    column = replace(_complete_column(item), samples=item.shape[axis])
    others = [k for k, size in enumerate(item.shape) if k != axis and size > 1]
    for place in range(item.shape[others[0]] if others else 1):
        first: Index = tuple(place if [k] == others else 0 for k in range(len(item.shape)))
        path = f"{column.key}/{place}" if others else column.path
        yield replace(column, path=path), (item.load, axis, first)


def _complete_column(item: Item) -> Column:
    """Return the column of an array with its unit, number type and scaling."""
    column, kind = item.column, item.dtype.kind
    # Dates and durations include their unit, so a unit in the name does not apply.
    if kind in "mM":
        return replace(column, name=column.bare_name, path=column.key, unit="s")
    packing = read_packing(item.attributes, item.dtype)
    is_whole = kind in "iub" and not (packing and packing.is_scaled)
    unapplied = unapplied_scaling(item.attributes, has_unit=column.stated_unit is not None, is_whole=is_whole)
    return replace(column, whole=is_whole, packing=packing, unapplied=unapplied or column.unapplied)


def _find_fault(dtype: np.dtype[Any], shape: tuple[int, ...]) -> str | None:
    # Axes of length one do not count: MATLAB stores vectors as matrices with one row or column.
    long = sorted(size for size in shape if size > 1)
    if dtype.kind == "c":
        return "complex numbers; a record needs real ones"
    if dtype.kind not in "fiubmM":
        return f"no numbers ({dtype})"
    if dtype.kind in "mM" and np.datetime_data(dtype)[0] in UNITS_WITHOUT_LENGTH:
        return f"times in units that have no length in seconds ({dtype})"
    if not shape or 0 in shape:
        return "it is empty"
    sizes = " x ".join(map(str, shape))
    if len(long) > 2:
        return f"{sizes} values; a channel has one dimension"
    if len(long) == 2 and (long[0] == long[1] or long[0] > MAX_SERIES):
        return f"{sizes} values; a matrix is no channel"
    return None


def fact(value: Any) -> str | int | float | None:
    """Return a metadata value as text or number; None if it is neither."""
    if isinstance(value, bytes):
        value = value.decode("utf-8", errors="replace")
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.item()
    if isinstance(value, np.generic):
        value = str(value) if value.dtype.kind in "Mm" else value.item()
    if isinstance(value, bytes):
        value = value.decode("utf-8", errors="replace")
    if isinstance(value, str):
        return value.strip("\0 ") or None
    return value if isinstance(value, int | float) else None
