"""Reader of MATLAB files up to version 7 by SciPy; files of version 7.3 are HDF5 and have a separate reader."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from mechid.records.arrays import ArrayTable, Item, array_table, fact
from mechid.records.matlab73 import is_matlab73, open_matlab73
from mechid.records.matlab_classes import object_fault, unpack_object
from mechid.records.mcos import Heap, Tree, referenced_objects
from mechid.records.memory import refuse_larger_than_memory
from mechid.records.table import Column, Fact
from mechid.records.third_party import wrap_parser_errors

KIND = "a MATLAB file"
OPAQUE, WORKSPACE = "None", "__function_workspace__"
"""Keys that SciPy uses for an object of a MATLAB class (the last one of several) and for the data of all objects."""
HEAD, OFFSET = 128, slice(116, 124)
"""Number of bytes of a file's header, and the position of the offset of the object data within it."""


def open_matlab(path: Path, label: str, external_files: Collection[str] = ()) -> ArrayTable:
    """Read the .mat file at `path`.

    Fields of structs are named by their path, such as ``rec/torque``, and elements of cells and struct arrays also by
    their index, such as ``runs/torque/0``. Single numbers and texts are metadata. SciPy cannot read a part of such a
    file, so it is read as a whole. `external_files` apply to version 7.3 only.
    """
    if is_matlab73(path):
        return open_matlab73(path, label, external_files)
    from scipy.io import loadmat

    refuse_larger_than_memory(path, label, KIND)
    metadata: dict[str, Fact] = {}
    with wrap_parser_errors(label, KIND):
        content: dict[str, Any] = loadmat(path)
        if any(_has_integers(value) for value in content.values()):
            # MATLAB stores doubles with integer values as integers. SciPy restores their class only with mat_dtype,
            # which loses the imaginary parts of other arrays: only the integers are taken from a second reading.
            typed = loadmat(path, mat_dtype=True)
            content = {name: _with_class(value, typed[name]) for name, value in content.items()}
    header = fact(content.get("__header__"))
    if header is not None:
        metadata["header"] = header
        objects = _Objects(path.read_bytes(), content[WORKSPACE]) if WORKSPACE in content else None
        variables = [*content.items(), *(objects.variables() if objects else ())]
        plain = [(name, value) for name, value in variables if not name.startswith("__") and name != OPAQUE]
        items = [item for name, value in plain for item in _items(name, value, objects, metadata)]
    kept = []
    for item in items:
        single = fact(item.load(())) if _is_single(item) else None
        if single is None:
            kept.append(item)
        else:
            metadata[item.column.key] = single
    return array_table(label, KIND, kept, metadata)


def _has_integers(value: Any) -> bool:
    """Return whether an entry is or contains an array of integers."""
    if not isinstance(value, np.ndarray):
        return False
    if value.dtype.names and not _is_object(value):
        return any(_has_integers(value[field]) for field in value.dtype.names)
    return any(map(_has_integers, value.ravel())) if value.dtype == object else value.dtype.kind in "iu"


def _with_class(value: Any, typed: Any) -> Any:
    """Return an entry with integers replaced by floats where `typed`, the entry in MATLAB's classes, has floats."""
    if not isinstance(value, np.ndarray) or (value.dtype.names and _is_object(value)):
        return value
    if value.dtype.names:
        for field in value.dtype.names:
            value[field] = _with_class(value[field], typed[field])
    elif value.dtype == object:
        for place, (one, other) in enumerate(zip(value.flat, typed.flat, strict=True)):
            value.flat[place] = _with_class(one, other)
    elif value.dtype.kind in "iu" and typed.dtype.kind == "f":
        return typed
    return value


def _is_single(item: Item) -> bool:
    """Return whether an item is a single number or text."""
    return item.column.fault is None and item.dtype.kind in "fiubU" and int(np.prod(item.shape)) == 1


class _Objects(Heap):
    """Objects of a file; SciPy gives all of them the same name, so each variable is read as a separate file."""

    def __init__(self, raw: bytes, workspace: Any) -> None:
        from scipy.io import loadmat
        from scipy.io.matlab import varmats_from_mat

        self.parts = [part for name, part in varmats_from_mat(BytesIO(raw)) if name == OPAQUE]
        head = raw[: OFFSET.start] + bytes(8) + raw[OFFSET.stop : HEAD]
        cells: list[Any] = []
        with suppress(ValueError, IndexError, KeyError):
            _, inner = varmats_from_mat(BytesIO(head + workspace.tobytes()[8:]))[0]
            cells = [*loadmat(inner)[WORKSPACE]["MCOS"][0, 0].ravel()[0][-1].ravel()]
        super().__init__(cells, lambda cell: bytes(cell.tobytes()))

    def variables(self) -> Iterator[tuple[str, Any]]:
        """Yield names and values of the variables that are objects."""
        from scipy.io import loadmat

        for part in self.parts:
            value = loadmat(part)[OPAQUE]
            yield _text(value.ravel()[0][0]), value

    def tree(self, value: Any) -> Tree:
        """Return the content of a value."""
        if not isinstance(value, np.ndarray) or value.size == 0:
            return None
        if value.dtype.names:
            if _is_object(value):
                return self.tree(value.ravel()[0][-1])
            trees = [{name: self.tree(one[name]) for name in value.dtype.names} for one in value.ravel()]
            return trees[0] if len(trees) == 1 else trees
        if value.dtype == object:
            return [self.tree(one) for one in value.ravel(order="F")]
        if value.dtype.kind == "U":
            return str(value.ravel()[0])
        if referenced_objects(value):
            return self.one_or_all(value)
        return Item(column=Column(), shape=value.shape, dtype=value.dtype, load=value.__getitem__)


def _is_object(value: Any) -> bool:
    return bool(value.dtype.names) and value.dtype.names[0] == "s0"


def _items(path: str, value: Any, objects: _Objects | None, metadata: dict[str, Fact]) -> Iterator[Item]:
    """Yield the arrays of an entry, including those in structs and cells."""
    column = Column(name=path.rpartition("/")[2], path=path)
    if isinstance(value, np.ndarray) and _is_object(value):
        _, _, kind, words = value.ravel()[0]
        found = objects.instances(words) if objects else []
        for number, instance in enumerate(found):
            own = column if len(found) == 1 else Column(name=column.name, path=f"{path}/{number}")
            yield from unpack_object(own, instance, metadata)
        if not found:
            yield Item(column=Column(name=column.name, path=path, fault=object_fault(_text(kind))))
    elif not isinstance(value, np.ndarray):
        yield Item(column=Column(name=column.name, path=path, fault=f"no plain array ({type(value).__name__})"))
    elif value.dtype.names:
        for field in value.dtype.names:
            for number, entry in enumerate(value[field].ravel(order="F")):
                place = f"{path}/{field}" if value.size == 1 else f"{path}/{field}/{number}"
                yield from _items(place, entry, objects, metadata)
    elif value.dtype == object:
        for number, entry in enumerate(value.ravel(order="F")):
            yield from _items(f"{path}/{number}", entry, objects, metadata)
    else:
        yield Item(column=column, shape=value.shape, dtype=value.dtype, load=value.__getitem__)


def _text(name: Any) -> str:
    return name.decode("utf-8", errors="replace") if isinstance(name, bytes) else str(name)
