"""The reader of MATLAB's files up to version 7, by SciPy; those of version 7.3 are HDF5 and have their own."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from mechid.records.arrays import ArrayTable, Item, array_table, fact
from mechid.records.foreign import parsing
from mechid.records.matlab73 import is_matlab73, object_fault, open_matlab73
from mechid.records.memory import refuse_larger_than_memory
from mechid.records.table import Column, Fact

KIND = "a MATLAB file"
OPAQUE = "None"
"""The key under which SciPy puts an object of a MATLAB class; the last one only, of several."""


def open_matlab(path: Path, label: str) -> ArrayTable:
    """Read the .mat file at `path`.

    Fields of structs are named by their path, as ``rec/torque``, elements of cells and of arrays of
    structs by their number too, as ``runs/torque/0``; those of one number or text are metadata. SciPy
    cannot read a part of such a file, so it is read whole.
    """
    if is_matlab73(path):
        return open_matlab73(path, label)
    from scipy.io import loadmat

    refuse_larger_than_memory(path, label, KIND)
    with parsing(label, KIND):
        content: dict[str, Any] = loadmat(path)
    metadata: dict[str, Fact] = {}
    header = fact(content.get("__header__"))
    if header is not None:
        metadata["header"] = header
    items = [item for name, value in content.items() if not name.startswith("__") for item in _items(name, value)]
    kept = []
    for item in items:
        single = fact(item.load(())) if _is_single(item) else None
        if single is None:
            kept.append(item)
        else:
            metadata[item.column.key] = single
    return array_table(label, KIND, kept, metadata)


def _is_single(item: Item) -> bool:
    """Whether it is one number or one text."""
    return item.column.fault is None and item.dtype.kind in "fiubU" and int(np.prod(item.shape)) == 1


def _items(path: str, value: Any) -> Iterator[Item]:
    """Yield what an entry holds, structs and cells taken apart."""
    column = Column(name=path.rpartition("/")[2], path=path)
    if path == OPAQUE and isinstance(value, np.ndarray) and value.dtype.names:
        name, _, kind, *_ = value.ravel()[0]
        yield Item(column=Column(name=_text(name), fault=object_fault(_text(kind))))
    elif not isinstance(value, np.ndarray):
        yield Item(column=Column(name=column.name, path=path, fault=f"no plain array ({type(value).__name__})"))
    elif value.dtype.names:
        for field in value.dtype.names:
            for number, entry in enumerate(value[field].ravel(order="F")):
                yield from _items(f"{path}/{field}" if value.size == 1 else f"{path}/{field}/{number}", entry)
    elif value.dtype == object:
        for number, entry in enumerate(value.ravel(order="F")):
            yield from _items(f"{path}/{number}", entry)
    else:
        yield Item(column=column, shape=value.shape, dtype=value.dtype, load=value.__getitem__)


def _text(name: Any) -> str:
    return name.decode("utf-8", errors="replace") if isinstance(name, bytes) else str(name)
