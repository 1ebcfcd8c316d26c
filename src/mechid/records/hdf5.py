"""Reader of HDF5 files by h5py: each dataset, identified by its path, is read on demand."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from mechid.errors import RecordError
from mechid.records.arrays import ArrayTable, Index, Item, array_table, fact
from mechid.records.hdf5_links import Links, Within
from mechid.records.scaling import plain_unit, unapplied_scaling
from mechid.records.table import Column, Fact
from mechid.records.third_party import import_library, wrap_parser_errors

KIND = "an HDF5 file"
UNIT_ATTRIBUTES = ("unit", "units", "Unit", "Units")
NO_VARIABLE = "This is a netCDF dimension but not a netCDF variable"
"""Beginning of the attribute NAME of a dataset that represents only a dimension."""
CLASSIC = b"CDF"
"""Signature of NetCDF files of the classic format."""
COMPLEX = (("real", "imag"), ("r", "i"))


def open_hdf5(path: Path, label: str, external_files: Collection[str] = ()) -> ArrayTable:
    """Read the header of the HDF5 file at `path`.

    A compound dataset has a column for each field. The unit is the dataset's attribute ``unit`` or ``units``; scaling
    and fill values are applied as described in `mechid.records.scaling`. Attributes of the file and datasets with a
    single number or text are metadata. Links are followed according to `Links`; data of other files are read only if
    listed in `external_files`.
    """
    h5py = import_library("h5py", "h5py", label)
    metadata: dict[str, Fact] = {}
    _refuse_classic(path, label)
    with wrap_parser_errors(label, KIND), h5py.File(path, "r") as file:
        metadata |= facts(file.attrs)
        links = Links(h5py, label, external_files)
        items = list(_items(links, file, "", frozenset(), metadata))
    return array_table(label, KIND, items, metadata, is_sliced=True, warnings=links.warnings)


def _refuse_classic(path: Path, label: str) -> None:
    """Raise an error for NetCDF files before version 4, which are not HDF5 files."""
    with path.open("rb") as file:
        if file.read(len(CLASSIC)) == CLASSIC:
            raise RecordError(
                f"{label}: is a classic NetCDF file; convert it to NetCDF-4, for example by nccopy -k nc4 old.nc new.nc"
            )


def facts(attributes: Any) -> dict[str, Fact]:
    """Return the attributes that are numbers or texts."""
    found = {str(key): fact(attributes[key]) for key in attributes}
    return {key: value for key, value in found.items() if value is not None}


def loader(h5py: Any, dataset: Any, field: str | None = None) -> Callable[[Index], Any]:
    """Return a function that loads a part of a dataset, or of one of its fields, from the dataset's file."""
    # The file is opened for each part, since the handle of the header is closed when its table is returned.
    path, name = dataset.file.filename, dataset.name

    def load(index: Index) -> Any:
        with h5py.File(path, "r") as file:
            dataset = file[name]
            return (dataset.fields(field) if field else dataset)[index]

    return load


def _items(links: Links, group: Any, under: str, within: Within, metadata: dict[str, Fact]) -> Iterator[Item]:
    within = links.enter(group, within)
    for name, entry, fault in links.entries(group, within):
        key = f"{under}{name}"
        if isinstance(entry, links.h5py.Group):
            metadata |= {f"{key}/{attribute}": value for attribute, value in facts(entry.attrs).items()}
            yield from _items(links, entry, f"{key}/", within, metadata)
        elif isinstance(entry, links.h5py.Dataset):
            yield from _dataset(links.h5py, entry, key, metadata)
        elif fault:
            yield Item(column=Column(name=name, path=key, fault=fault))


def _dataset(h5py: Any, dataset: Any, key: str, metadata: dict[str, Fact]) -> Iterator[Item]:
    single = fact(dataset[()]) if dataset.size == 1 and not dataset.dtype.names else None
    if single is not None:
        metadata[key] = single
        return
    stated = {str(name): dataset.attrs[name] for name in dataset.attrs}
    if str(fact(stated.get("NAME", ""))).startswith(NO_VARIABLE):
        return
    attributes = facts(stated)
    unit = next((plain_unit(str(attributes.pop(name))) for name in UNIT_ATTRIBUTES if name in attributes), None)
    names = dataset.dtype.names
    if names is None or names in COMPLEX:
        dtype = np.dtype(complex) if names else dataset.dtype
        column = Column(name=key.rpartition("/")[2], path=key, unit=unit, metadata=attributes)
        load = loader(h5py, dataset)
        yield Item(column=column, shape=dataset.shape or (), dtype=dtype, load=load, attributes=stated)
        return
    # It is not known to which of several fields a scaling applies: to all of them, including the time, or to one.
    unapplied = unapplied_scaling(stated, has_unit=unit is not None, is_whole=False, is_beside=True)
    for name in names:
        column = Column(name=name, path=f"{key}/{name}", unit=unit, unapplied=unapplied, metadata=attributes)
        load = loader(h5py, dataset, name)
        yield Item(column=column, shape=dataset.shape, dtype=dataset.dtype[name], load=load)
