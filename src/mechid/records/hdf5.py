"""The reader of HDF5 files, by h5py: each dataset, under its path, is read when it is wanted."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from mechid.records.arrays import ArrayTable, Index, Item, array_table, fact
from mechid.records.foreign import library, parsing
from mechid.records.table import Column, Fact

KIND = "an HDF5 file"
UNIT_ATTRIBUTES = ("unit", "units", "Unit", "Units")
COMPLEX = (("real", "imag"), ("r", "i"))
DEEPEST = 32
"""Groups may hold themselves; no instrument nests them so deep."""


def open_hdf5(path: Path, label: str) -> ArrayTable:
    """Read the head of the HDF5 file at `path`.

    A dataset of records has a column for each field. The unit is the dataset's attribute ``unit`` or
    ``units``. Attributes of the file, and datasets of one number or text, are metadata.
    """
    h5py = library("h5py", "h5py", label)
    metadata: dict[str, Fact] = {}
    with parsing(label, KIND), h5py.File(path, "r") as file:
        metadata |= facts(file.attrs)
        items = list(_items(h5py, path, file, "", metadata))
    return array_table(label, KIND, items, metadata, is_sliced=True)


def facts(attributes: Any) -> dict[str, Fact]:
    """Return the attributes that are a number or a text."""
    found = {str(key): fact(attributes[key]) for key in attributes}
    return {key: value for key, value in found.items() if value is not None}


def loader(h5py: Any, path: Path, name: str, field: str | None = None) -> Callable[[Index], Any]:
    """Return what loads a part of the dataset `name`, or of one of its fields, from the file at `path`."""

    def load(index: Index) -> Any:
        with h5py.File(path, "r") as file:
            dataset = file[name]
            return (dataset.fields(field) if field else dataset)[index]

    return load


def _items(h5py: Any, path: Path, group: Any, under: str, metadata: dict[str, Fact]) -> Iterator[Item]:
    if under.count("/") > DEEPEST:
        return
    for name in group:
        key = f"{under}{name}"
        entry = group.get(name)
        if isinstance(entry, h5py.Group):
            metadata |= {f"{key}/{attribute}": value for attribute, value in facts(entry.attrs).items()}
            yield from _items(h5py, path, entry, f"{key}/", metadata)
        elif isinstance(entry, h5py.Dataset):
            yield from _dataset(h5py, path, entry, key, metadata)
        else:
            yield Item(column=Column(name=name, path=key, fault="a link to nothing in this file"))


def _dataset(h5py: Any, path: Path, dataset: Any, key: str, metadata: dict[str, Fact]) -> Iterator[Item]:
    single = fact(dataset[()]) if dataset.size == 1 and not dataset.dtype.names else None
    if single is not None:
        metadata[key] = single
        return
    told = facts(dataset.attrs)
    unit = next((str(told.pop(name)) for name in UNIT_ATTRIBUTES if name in told), None)
    names = dataset.dtype.names
    if names is None or names in COMPLEX:
        dtype = np.dtype(complex) if names else dataset.dtype
        column = Column(name=key.rpartition("/")[2], path=key, unit=unit, metadata=told)
        yield Item(column=column, shape=dataset.shape or (), dtype=dtype, load=loader(h5py, path, dataset.name))
        return
    for name in names:
        column = Column(name=name, path=f"{key}/{name}", unit=unit, metadata=told)
        load = loader(h5py, path, dataset.name, name)
        yield Item(column=column, shape=dataset.shape, dtype=dataset.dtype[name], load=load)
