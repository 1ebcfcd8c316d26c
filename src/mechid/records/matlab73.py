"""Reader of MATLAB files of version 7.3: HDF5 files that encode MATLAB's structs, cells and texts."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from mechid.records.arrays import ArrayTable, Item, array_table, fact
from mechid.records.hdf5 import COMPLEX, loader
from mechid.records.hdf5_links import Links, Within
from mechid.records.matlab_classes import object_fault, unpack_object
from mechid.records.mcos import Heap, Tree, referenced_objects
from mechid.records.simulink import logged_signals
from mechid.records.table import Column, Fact
from mechid.records.third_party import import_library, wrap_parser_errors

KIND = "a MATLAB 7.3 file"
HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
USER_BLOCK = 512
PRIVATE = "#"
"""First character of the names of MATLAB's internal entries."""
NUMBERS = ("double", "single", "logical", *(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)))

OF_STREAMS = ("/Values/CompressedTime", "/SignalAttributes/")
"""Parts of the paths of arrays that describe streams of logged signals."""
OBJECTS = "#subsystem#/MCOS"
"""Path of the cells of all objects."""

Entry = tuple[Any, str | None]
"""HDF5 object, or None and the reason if it must not be accessed."""


def is_matlab73(path: Path) -> bool:
    """Return whether a .mat file is an HDF5 file."""
    # MATLAB writes a text of 512 bytes before the signature; other programs do not.
    with path.open("rb") as file:
        head = file.read(USER_BLOCK + len(HDF5_SIGNATURE))
    return head.startswith(HDF5_SIGNATURE) or head[USER_BLOCK:] == HDF5_SIGNATURE


def open_matlab73(path: Path, label: str, external_files: Collection[str] = ()) -> ArrayTable:
    """Read the header of the MATLAB 7.3 file at `path`; paths and metadata as in `open_matlab`, links as in `Links`."""
    h5py = import_library("h5py", "h5py", label)
    metadata: dict[str, Fact] = {}
    with wrap_parser_errors(label, KIND), h5py.File(path, "r") as file:
        reader = _Objects(Links(h5py, label, external_files), file)
        items = [*_group_items(reader, file, "", frozenset(), metadata)]
        items = [*_merge_logged_signals(items, [*logged_signals(reader.links, file)])]
    return array_table(label, KIND, items, metadata, is_sliced=True, warnings=reader.links.warnings)


def _merge_logged_signals(items: list[Item], logged: list[Item]) -> Iterator[Item]:
    """Yield the items of a file and the signals logged by Simulink, without the objects that only refer to these."""
    for item in items:
        fault, key = item.column.fault or "", item.column.key
        if not logged or not ("MATLAB class" in fault or any(part in key for part in OF_STREAMS)):
            yield item
    yield from logged


class _Objects(Heap):
    """Objects of an open file."""

    def __init__(self, links: Links, file: Any) -> None:
        self.links, self.h5py = links, links.h5py
        found = links.at(file, OBJECTS)
        cells = [] if found is None else [node for node, _ in self.resolve_references(found, frozenset())]
        super().__init__(cells, lambda cell: bytes(cell[()].tobytes()))

    def tree(self, node: Any, within: Within = frozenset()) -> Tree:
        """Return the content of a node."""
        if node is None or "MATLAB_empty" in node.attrs:
            return None
        if isinstance(node, self.h5py.Group):
            inside = self.links.enter(node, within)
            return {name: self.tree(entry, inside) for name, entry, _ in self.links.entries(node, inside)}
        if node.dtype == self.h5py.ref_dtype:
            inside = self.links.enter(node, within)
            return [self.tree(entry, inside) for entry, _ in self.resolve_references(node, inside)]
        if fact(node.attrs.get("MATLAB_class", b"")) == "char":
            return "".join(map(chr, node[()].ravel(order="F")))
        if node.dtype == np.uint32 and referenced_objects(words := node[()]):
            return self.one_or_all(words)
        dtype = np.dtype(complex) if node.dtype.names in COMPLEX else node.dtype
        return Item(column=Column(), shape=node.shape, dtype=dtype, load=loader(self.h5py, node))

    def resolve_references(self, node: Any, within: Within) -> Iterator[tuple[Any, str | None]]:
        """Yield the objects of the references of a cell, or of a struct array's field, in MATLAB's order."""
        for reference in node[()].ravel(order="F"):
            yield self.links.resolve_reference(node, reference, within) if reference else (None, None)


def _group_items(reader: _Objects, group: Any, under: str, within: Within, metadata: dict[str, Fact]) -> Iterator[Item]:
    """Yield the arrays of the entries of a group."""
    inside = reader.links.enter(group, within)
    for name, node, fault in reader.links.entries(group, inside):
        if under or not name.startswith(PRIVATE):
            yield from _items(reader, f"{under}{name}", (node, fault), inside, metadata)


def _items(reader: _Objects, key: str, entry: Entry, within: Within, metadata: dict[str, Fact]) -> Iterator[Item]:
    """Yield the arrays of an entry, including those in structs and cells; texts and single numbers become metadata."""
    node, fault = entry
    column = Column(name=key.rpartition("/")[2], path=key, fault=fault)
    if fault:
        yield Item(column=column)
        return
    kind = str(fact(node.attrs.get("MATLAB_class", b"")) or "")
    if "MATLAB_empty" in node.attrs:
        return
    if "MATLAB_sparse" in node.attrs:
        yield Item(column=replace(column, fault="a sparse matrix; save it full"))
    elif isinstance(node, reader.h5py.Group):
        yield from _group_items(reader, node, f"{key}/", within, metadata)
    elif node.dtype == reader.h5py.ref_dtype:
        inside = reader.links.enter(node, within)
        for number, inner in enumerate(reader.resolve_references(node, inside)):
            if inner != (None, None):
                yield from _items(reader, f"{key}/{number}", inner, inside, metadata)
    elif kind == "char":
        metadata[key] = "".join(map(chr, node[()].ravel(order="F")))
    elif kind and kind not in NUMBERS:
        found = reader.instances(node[()])
        for number, instance in enumerate(found):
            place = column if len(found) == 1 else Column(name=column.name, path=f"{key}/{number}")
            yield from unpack_object(place, instance, metadata)
        if not found:
            yield Item(column=replace(column, fault=object_fault(kind)))
    else:
        yield from _numbers(reader.h5py, column, node, metadata)


def _numbers(h5py: Any, column: Column, node: Any, metadata: dict[str, Fact]) -> Iterator[Item]:
    single = fact(node[()]) if node.size == 1 and not node.dtype.names else None
    if single is not None:
        metadata[column.key] = single
        return
    dtype = np.dtype(complex) if node.dtype.names in COMPLEX else node.dtype
    yield Item(column=column, shape=node.shape, dtype=dtype, load=loader(h5py, node))
