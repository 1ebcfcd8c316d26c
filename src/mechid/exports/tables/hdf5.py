"""HDF5 file of tables: one group per table, one data set with unit per column (needs the extra ``formats``)."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mechid.arrays import FloatArray
from mechid.exports.tables.table import Table
from mechid.writing import buffered_file

FILE_NAME = "tables.h5"
FORMAT = "mechid-tables/1"


def write_hdf5(tables: Sequence[Table], provenance: Mapping[str, Any], folder: Path) -> str:
    """Write tables; return the file name."""
    import h5py

    with buffered_file(folder / FILE_NAME) as content, h5py.File(content, "w") as file:
        file.attrs["format"] = FORMAT
        file.attrs["provenance"] = json.dumps(provenance)
        for table in tables:
            # Without tracking, HDF5 lists the columns by name.
            group = file.create_group(table.name, track_order=True)
            for column in table.columns:
                data = list(column.values) if isinstance(column.values, tuple) else column.values
                kind = h5py.string_dtype() if isinstance(column.values, tuple) else float
                made = group.create_dataset(column.name, data=data, dtype=kind)
                made.attrs.update({"unit": column.unit, "meaning": column.words})
    return FILE_NAME


def read_hdf5(table: Table, folder: Path) -> dict[str, FloatArray]:
    """Read the numeric columns of a table from the file."""
    import h5py

    with h5py.File(folder / FILE_NAME) as file:
        return {name: file[table.name][name][...] for name in table.numeric}
