"""The reader of MATLAB's files of version 7.3: HDF5 in which MATLAB's structs, cells and texts are coded."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from mechid.records.arrays import ArrayTable, Item, array_table, fact
from mechid.records.foreign import library, parsing
from mechid.records.hdf5 import COMPLEX, DEEPEST, loader
from mechid.records.matlab_classes import object_fault, unpacked
from mechid.records.mcos import Heap, Tree, referred
from mechid.records.simulink import logged_signals
from mechid.records.table import Column, Fact

KIND = "a MATLAB 7.3 file"
HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
USER_BLOCK = 512
PRIVATE = "#"
"""What MATLAB keeps for itself begins so."""
NUMBERS = ("double", "single", "logical", *(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)))

OBJECTS = "#subsystem#/MCOS"
"""Where the cells of all objects are."""

Entry = tuple[str, Any]
"""A path as the user writes it, and the HDF5 object there."""


def is_matlab73(path: Path) -> bool:
    """Whether a .mat file is HDF5: MATLAB puts a text of 512 bytes in front, other programs do not."""
    with path.open("rb") as file:
        head = file.read(USER_BLOCK + len(HDF5_SIGNATURE))
    return head.startswith(HDF5_SIGNATURE) or head[USER_BLOCK:] == HDF5_SIGNATURE


def open_matlab73(path: Path, label: str) -> ArrayTable:
    """Read the head of the MATLAB 7.3 file at `path`; paths and metadata as in `open_matlab`."""
    h5py = library("h5py", "h5py", label)
    metadata: dict[str, Fact] = {}
    with parsing(label, KIND), h5py.File(path, "r") as file:
        entries = [(name, file[name]) for name in file if not name.startswith(PRIVATE)]
        reader = _Objects(h5py, path, file)
        items = [item for entry in entries for item in _items(reader, path, entry, metadata)]
        items = [*_over(items, [*logged_signals(h5py, path, file)])]
    return array_table(label, KIND, items, metadata, is_sliced=True)


def _over(items: list[Item], logged: list[Item]) -> Iterator[Item]:
    """Yield what a file holds; where Simulink has logged signals, the objects that name them say nothing more."""
    yield from (item for item in items if not (logged and item.column.fault and "MATLAB class" in item.column.fault))
    yield from logged


class _Objects(Heap):
    """The objects of an open file."""

    def __init__(self, h5py: Any, path: Path, file: Any) -> None:
        self.h5py, self.path = h5py, path
        cells = [file[reference] for reference in file[OBJECTS][()].ravel()] if OBJECTS in file else []
        super().__init__(cells, lambda cell: bytes(cell[()].tobytes()))

    def tree(self, node: Any, level: int = 0) -> Tree:
        """Return what a node holds."""
        if level > DEEPEST or "MATLAB_empty" in node.attrs:
            return None
        if isinstance(node, self.h5py.Group):
            return {name: self.tree(node[name], level + 1) for name in node}
        if node.dtype == self.h5py.ref_dtype:
            return [self.tree(node.file[r], level + 1) if r else None for r in node[()].ravel(order="F")]
        if fact(node.attrs.get("MATLAB_class", b"")) == "char":
            return "".join(map(chr, node[()].ravel(order="F")))
        if node.dtype == np.uint32 and referred(words := node[()]):
            return self.one_or_all(words)
        dtype = np.dtype(complex) if node.dtype.names in COMPLEX else node.dtype
        return Item(column=Column(), shape=node.shape, dtype=dtype, load=loader(self.h5py, self.path, node.name))


def _items(reader: _Objects, path: Path, entry: Entry, metadata: dict[str, Fact]) -> Iterator[Item]:
    """Yield what an entry holds, structs and cells taken apart; texts and single numbers become metadata."""
    key, node = entry
    h5py = reader.h5py
    kind = str(fact(node.attrs.get("MATLAB_class", b"")) or "")
    column = Column(name=key.rpartition("/")[2], path=key)
    if key.count("/") > DEEPEST or "MATLAB_empty" in node.attrs:
        return
    if "MATLAB_sparse" in node.attrs:
        yield Item(column=Column(name=column.name, path=key, fault="a sparse matrix; save it full"))
    elif isinstance(node, h5py.Group):
        for name in node:
            yield from _items(reader, path, (f"{key}/{name}", node[name]), metadata)
    elif node.dtype == h5py.ref_dtype:
        for inner in _referred(node, key):
            yield from _items(reader, path, inner, metadata)
    elif kind == "char":
        metadata[key] = "".join(map(chr, node[()].ravel(order="F")))
    elif kind and kind not in NUMBERS:
        found = reader.instances(node[()])
        for number, instance in enumerate(found):
            place = column if len(found) == 1 else Column(name=column.name, path=f"{key}/{number}")
            yield from unpacked(place, instance, metadata)
        if not found:
            yield Item(column=Column(name=column.name, path=key, fault=object_fault(kind)))
    else:
        yield from _numbers(h5py, path, column, node, metadata)


def _referred(node: Any, key: str) -> Iterator[Entry]:
    """Yield the elements of a cell, or of a struct array's field, in MATLAB's order."""
    for index, reference in enumerate(node[()].ravel(order="F")):
        if reference:
            yield f"{key}/{index}", node.file[reference]


def _numbers(h5py: Any, path: Path, column: Column, node: Any, metadata: dict[str, Fact]) -> Iterator[Item]:
    single = fact(node[()]) if node.size == 1 and not node.dtype.names else None
    if single is not None:
        metadata[column.key] = single
        return
    dtype = np.dtype(complex) if node.dtype.names in COMPLEX else node.dtype
    yield Item(column=column, shape=node.shape, dtype=dtype, load=loader(h5py, path, node.name))
