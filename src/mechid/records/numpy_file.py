"""The reader of NumPy's own files: .npy, mapped and not loaded, and .npz."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy

from mechid.records.arrays import ArrayTable, Index, Item, array_table, fact
from mechid.records.foreign import wrap_parser_errors
from mechid.records.table import Column, Fact

HEADERS = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}


def open_npy(path: Path, label: str) -> ArrayTable:
    """Read the head of the .npy file at `path`: one array, or one with a field for each channel."""
    with wrap_parser_errors(label, "an .npy file"):
        array = np.load(path, mmap_mode="r", allow_pickle=False)
    items = [_mapped_item(path, name, array) for name in array.dtype.names or ("",)]
    return array_table(label, "an .npy file", items, {}, is_ordered=True, is_sliced=True)


def open_npz(path: Path, label: str) -> ArrayTable:
    """Read the heads of the arrays in the .npz file at `path`; those of one number are metadata."""
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
    """Return the array, or the field of it that is called so, mapped anew for each part: what was read is let go."""

    def load(index: Index) -> Any:
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
    """Yield name, shape and kind of numbers of each array, from its first bytes alone."""
    with zipfile.ZipFile(path) as archive:
        for member in archive.namelist():
            with archive.open(member) as file:
                shape, _, dtype = HEADERS[npy.read_magic(file)](file)
            yield member.removesuffix(".npy"), shape, dtype
