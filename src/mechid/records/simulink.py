"""Signals that Simulink has logged into a .mat file of version 7.3: a Dataset's elements and their streams of samples.

Simulink keeps the samples apart from the objects, in numbered streams under ``#sigstream#``: ``#data#`` (bytes, or
numbers), ``#length#`` samples of ``#sampleSize#`` bytes. An element of a Dataset is a struct under ``#refs#`` with its
``Name`` and ``Values``, whose entries that end in ``R2`` are numbers of streams, and whose ``CompressedTime`` is start,
step and count of an even time. Read from files as several programs of others read theirs; MathWorks publishes nothing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.records.arrays import Index, Item
from mechid.records.hdf5_links import Links
from mechid.records.table import Clock, Column

STREAMS, REFERENCES = "#sigstream#", "#refs#"
STREAM = "R2"
"""Ending of an entry that is the number of a stream."""
DOUBLE = 8
"""Bytes of a sample whose kind is known: nothing in a stream tells a single number from a whole one."""


def logged_signals(links: Links, file: Any) -> Iterator[Item]:
    """Yield the signals of the Datasets in an open file, and the streams that no element names."""
    if links.at(file, STREAMS) is None:
        return
    references = links.at(file, REFERENCES)
    entries = [] if references is None else links.entries(references, frozenset())
    elements = [(key, node) for key, node, _ in entries if _is_element(links, node)]
    names = Counter(_text(links.at(node, "Name")) for _, node in elements)
    named: set[int] = set()
    for key, node in elements:
        name = _text(links.at(node, "Name")) or key
        yield from _signal(links, node, name if names[name] < 2 else f"{name}/{key}", named)
    for number in links.at(file, STREAMS):
        if number.isdigit() and int(number) not in named:
            column = Column(name=f"stream_{number}", path=f"{STREAMS}/{number}")
            yield _stream(links, file, int(number), column)


def _is_element(links: Links, node: Any) -> bool:
    if not isinstance(node, links.h5py.Group) or links.at(node, "Name") is None:
        return False
    values = links.at(node, "Values")
    return isinstance(values, links.h5py.Group) and any(key.endswith(STREAM) for key in values)


def _signal(links: Links, node: Any, where: str, named: set[int]) -> Iterator[Item]:
    """Yield the data of an element under its name, with its clock or its time."""
    values, name = links.at(node, "Values"), where.partition("/")[0]
    streams = {key.removesuffix(STREAM): _whole(links.at(values, key)) for key in values if key.endswith(STREAM)}
    named |= set(streams.values())
    clock = _clock(links.at(values, "CompressedTime"))
    for entry, number in streams.items():
        is_data = entry == "Data"
        path_of = where if is_data and len(streams) == 1 else f"{where}/{entry}"
        column = Column(
            name=name if is_data else entry,
            path=path_of,
            clock=clock if is_data else None,
            unit="s" if entry == "Time" else None,
        )
        yield _stream(links, node.file, number, column)


def _clock(node: Any) -> Clock | None:
    if node is None:
        return None
    numbers = np.asarray(node[()], dtype=float).ravel()
    return Clock(float(numbers[0]), 1.0 / float(numbers[1])) if numbers.size == 3 and numbers[1] > 0.0 else None


def _stream(links: Links, file: Any, number: int, column: Column) -> Item:
    stream = links.at(file, f"{STREAMS}/{number}")
    data, length = links.at(stream, "#data#"), _whole(links.at(stream, "#length#"))
    if data.dtype.kind == "f":
        return Item(column=column, shape=(length,), load=_loader(links.h5py, data, length, 1))
    size = _whole(links.at(stream, "#sampleSize#"))
    if size != DOUBLE or data.size < size * length:
        fault = f"{length} samples of {size} bytes each, whose kind the file does not tell; log it as double"
        return Item(column=Column(name=column.name, path=column.path, fault=fault))
    return Item(column=column, shape=(length,), load=_loader(links.h5py, data, length, size))


def _whole(node: Any) -> int:
    return int(node[()].flat[0])


def _loader(h5py: Any, data: Any, length: int, size: int) -> Any:
    """Return what loads a part of a stream of `length` samples, of `size` places in the file each."""
    path, name = data.file.filename, data.name

    def load(index: Index) -> FloatArray:
        start, stop, step = (index[0] if index else slice(None)).indices(length)  # type: ignore[union-attr]
        with h5py.File(path, "r") as file:
            data = file[name]
            axis = int(np.argmax(data.shape))
            place = tuple(slice(size * start, size * stop) if k == axis else 0 for k in range(data.ndim))
            part = np.asarray(data[place])
        numbers = part if size == 1 else np.frombuffer(part.tobytes(), dtype="<f8")
        return np.asarray(numbers[::step], dtype=np.float64)

    return load


def _text(node: Any) -> str:
    return "" if "MATLAB_empty" in node.attrs else "".join(map(chr, node[()].ravel(order="F")))
