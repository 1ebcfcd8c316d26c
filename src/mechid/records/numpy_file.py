"""Reader of NumPy files: .npy, which is memory-mapped, and .npz."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy

from mechid.records.arrays import ArrayTable, Index, Item, array_table, fact
from mechid.records.table import Column, Fact
from mechid.records.third_party import wrap_parser_errors

HEADERS = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}


def open_npy(path: Path, label: str) -> ArrayTable:
    """Read the header of the .npy file at `path`: a plain array, or a structured array with a field per channel."""
    with wrap_parser_errors(label, "an .npy file"):
        array = np.load(path, mmap_mode="r", allow_pickle=False)
    items = [_mapped_item(path, name, array) for name in array.dtype.names or ("",)]
    return array_table(label, "an .npy file", items, {}, is_ordered=True, is_sliced=True)


def open_npz(path: Path, label: str) -> ArrayTable:
    """Read the headers of the arrays in the .npz file at `path`; single numbers are metadata."""
    items: list[Item] = []
    metadata: dict[str, Fact] = {}
    with wrap_parser_errors(label, "an .npz file"):
        for name, shape, dtype in _members(path):
            found = fact(_load(path, name)[()]) if not shape and dtype.kind in "fiubU" else None
            if found is not None:
                metadata[name] = found
            else:
                items.append(_lazy_item(path, name, shape, dtype))
    return array_table(label, "an .npz file", items, metadata)


def _mapped_item(path: Path, name: str, array: np.ndarray[Any, Any]) -> Item:
    """Return the item of an array, or of its field `name`."""

    def load(index: Index) -> Any:
        # Mapped anew for each part: the pages of a permanent mapping would stay in memory.
        found = np.load(path, mmap_mode="r", allow_pickle=False)
        return (found[name] if name else found)[index]

    dtype = array.dtype[name] if name else array.dtype
    return Item(column=Column(name=name), shape=array.shape, dtype=dtype, load=load)


def _lazy_item(path: Path, name: str, shape: tuple[int, ...], dtype: np.dtype[Any]) -> Item:
    def load(index: Index) -> Any:
        return _load(path, name)[index]

    return Item(column=Column(name=name), shape=shape, dtype=dtype, load=load)


def _load(path: Path, name: str) -> np.ndarray[Any, Any]:
    with np.load(path, allow_pickle=False) as archive:
        return np.asarray(archive[name])


def _members(path: Path) -> Iterator[tuple[str, tuple[int, ...], np.dtype[Any]]]:
    """Yield name, shape and number type of each array, reading only its header."""
    # NumPy's own reader would decompress the samples of every array to return its shape.
    with zipfile.ZipFile(path) as archive:
        for member in archive.namelist():
            with archive.open(member) as file:
                shape, _, dtype = HEADERS[npy.read_magic(file)](file)
            yield member.removesuffix(".npy"), shape, dtype
