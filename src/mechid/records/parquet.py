"""Reader of Parquet files by PyArrow: only the selected columns, one row group after the other."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from mechid.records.arrays import ArrayTable, Index, Item, array_table, fact
from mechid.records.table import Column, Fact
from mechid.records.third_party import import_library, wrap_parser_errors

KIND = "a Parquet file"
UNIT_KEYS = ("unit", "units")
FIELD_ID = b"PARQUET:field_id"
NOT_FOR_USERS = (b"pandas", b"ARROW:schema")
DATE = "timestamp["
BUFFER = 2**20
"""Size of the read buffer in bytes; without one, a complete column of a row group is held in memory for decoding."""
BATCH = 2**18
"""Number of rows decoded together; a row group may be as long as the file."""


def open_parquet(path: Path, label: str) -> ArrayTable:
    """Read the header of the Parquet file at `path`; units are in the names or in the metadata of the fields."""
    pq = import_library("pyarrow.parquet", "pyarrow", label)
    with wrap_parser_errors(label, KIND), pq.ParquetFile(path) as file:
        schema, samples = file.schema_arrow, file.metadata.num_rows
        items = [_item(pq, path, field, samples) for field in schema]
        facts = {key.decode(): fact(value) for key, value in (schema.metadata or {}).items() if _is_public(key)}
    metadata: dict[str, Fact] = {key: value for key, value in facts.items() if value is not None}
    return array_table(label, KIND, items, metadata, is_ordered=True, is_sliced=True)


def _is_public(key: bytes) -> bool:
    return key not in NOT_FOR_USERS


def _item(pq: Any, path: Path, field: Any, samples: int) -> Item:
    attributes = {key.decode(): fact(value) for key, value in (field.metadata or {}).items() if key != FIELD_ID}
    told = {key: value for key, value in attributes.items() if value is not None}
    unit = next((told.pop(key) for key in UNIT_KEYS if key in told), None)
    column = Column(name=field.name, unit=str(unit) if unit else None, metadata=told)

    def load(index: Index) -> Any:
        (rows,) = index
        return _read(pq, path, field.name, rows)

    return Item(column=column, shape=(samples,), dtype=_dtype(field.type), load=load, attributes=told)


def _dtype(kind: Any) -> np.dtype[Any]:
    """Return the NumPy type of a column; object if it does not contain plain numbers."""
    if str(kind).startswith(DATE):
        return np.dtype("M8[ns]")
    try:
        found: np.dtype[Any] = np.dtype(kind.to_pandas_dtype())
    except (NotImplementedError, TypeError):
        found = np.dtype(object)
    return found


def _read(pq: Any, path: Path, name: str, rows: int | slice) -> Any:
    """Return rows of a column; empty cells are NaN."""
    # Without pre-buffering, which would hold complete column chunks in memory.
    with pq.ParquetFile(path, buffer_size=BUFFER, pre_buffer=False) as file:
        start, stop, _ = (rows if isinstance(rows, slice) else slice(rows, rows + 1)).indices(file.metadata.num_rows)
        parts = list(_parts(file, name, start, stop))
    found = np.concatenate(parts) if parts else np.empty(0)
    return found if isinstance(rows, slice) else found[0]


def _parts(file: Any, name: str, start: int, stop: int) -> Any:
    """Yield the values between two rows, reading only the row groups that contain them."""
    first = 0
    for group in range(file.num_row_groups):
        last = first + file.metadata.row_group(group).num_rows
        if first < stop and last > start:
            for batch in file.iter_batches(BATCH, row_groups=[group], columns=[name]):
                size = batch.num_rows
                if first < stop and first + size > start:
                    yield batch.column(0).to_numpy(zero_copy_only=False)[max(start - first, 0) : stop - first]
                first += size
        first = last
