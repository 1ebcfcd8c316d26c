"""Signals logged by Simulink into a .mat file of version 7.3: elements of a Dataset and their streams of samples.

Simulink stores samples separately from objects, in numbered streams under ``#sigstream#``: ``#data#`` (bytes or
numbers) with ``#length#`` samples of ``#sampleSize#`` bytes. An element of a Dataset is a struct under ``#refs#`` with
``Name`` and ``Values``, which is a time series, or a struct of them for a bus. ``DataR2`` and ``TimeR2`` of a time
series are stream numbers, empty if there is no stream; ``CompressedTime`` contains start, step and count of a uniform
time; ``SignalAttributes/ClassName`` is the type of a sample. MathWorks does not publish the layout; it was derived from
third-party files.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechid.errors import RecordError
from mechid.records.arrays import Index, Item
from mechid.records.hdf5 import loader
from mechid.records.hdf5_links import Links
from mechid.records.table import Clock, Column
from mechid.units import to_si_factor

STREAMS, REFERENCES = "#sigstream#", "#refs#"
DATA, TIME, VARIABLE_SIZE = "DataR2", "TimeR2", "VarDimsR2"
"""Entries of a time series that contain stream numbers."""
MAX_BUS_LEVELS = 8
"""Maximum nesting of buses."""
DEFAULT_CLASS = "double"
"""Class of samples of 8 bytes if the file does not state it; it is Simulink's default."""
TYPES: Mapping[str, np.dtype[Any]] = {
    "double": np.dtype("<f8"),
    "single": np.dtype("<f4"),
    "half": np.dtype("<f2"),
    **dict.fromkeys(("logical", "boolean"), np.dtype("u1")),
    **{f"{name}{8 * size}": np.dtype(f"<{name[0]}{size}") for name in ("int", "uint") for size in (1, 2, 4, 8)},
}
"""Sample type by MATLAB class name."""


@dataclass(frozen=True)
class Leaf:
    """Time series: an element of a Dataset, or a signal of a bus.

    Attributes
    ----------
    path : str
        Names of element and buses.
    node : h5py.Group
    """

    path: str
    node: Any


def logged_signals(links: Links, file: Any) -> Iterator[Item]:
    """Yield the signals of the Datasets in an open file, and the streams that no signal refers to."""
    if links.at(file, STREAMS) is None:
        return
    leaves = list(_leaves(links, file))
    named = {
        number
        for leaf in leaves
        for entry in (DATA, TIME)
        if (number := _stream_of(links, leaf.node, entry)) is not None
    }
    for leaf in leaves:
        yield from _signal(links, leaf)
    for number in links.at(file, STREAMS):
        if number.isdigit() and int(number) not in named:
            column = Column(name=f"stream_{number}", path=f"{STREAMS}/{number}")
            yield _stream(links, file, int(number), column, None)


def _leaves(links: Links, file: Any) -> Iterator[Leaf]:
    """Yield the time series of all elements once; paths of elements with equal names include the key of the struct."""
    references = links.at(file, REFERENCES)
    entries = [] if references is None else links.entries(references, frozenset())
    elements = [(key, node) for key, node, _ in entries if isinstance(node, links.h5py.Group)]
    found: dict[tuple[str, int | None], list[tuple[str, Leaf]]] = {}
    for key, node in elements:
        name, values = links.at(node, "Name"), links.at(node, "Values")
        if name is None or not isinstance(values, links.h5py.Group):
            continue
        for leaf in _series_in(links, values, _text(name) or _read_text(links, node, "PropagatedName") or key, 0):
            # A run that was saved both as output and as variable has two elements for one stream.
            found.setdefault((leaf.path, _stream_of(links, leaf.node, DATA)), []).append((key, leaf))
    alone = Counter(path for path, _ in found)
    for (path, _), [(key, leaf), *_] in found.items():
        yield leaf if alone[path] == 1 else replace(leaf, path=f"{path}/{key}")


def _series_in(links: Links, node: Any, path: str, level: int) -> Iterator[Leaf]:
    """Yield the time series among the values of an element."""
    if DATA in node:
        yield Leaf(path, node)
    elif level < MAX_BUS_LEVELS:
        for name, entry, _ in links.entries(node, frozenset()):
            if isinstance(entry, links.h5py.Group):
                yield from _series_in(links, entry, f"{path}/{name}", level + 1)


def _signal(links: Links, leaf: Leaf) -> Iterator[Item]:
    """Yield the data of a time series, with its clock or its time."""
    node, file = leaf.node, leaf.node.file
    data, time = (_stream_of(links, node, entry) for entry in (DATA, TIME))
    # Nothing was logged for this signal.
    if data is None:
        return
    has_time = time is not None or _non_empty_dataset(links, node, "Time") is not None
    name, unit = leaf.path.rpartition("/")[2], _read_text(links, node, "DataUnits/Value") or None
    column = Column(name=name, path=f"{leaf.path}/Data" if has_time else leaf.path, unit=unit)
    item = _stream(links, file, data, column, _class_of(links, node))
    yield item if has_time else _with_clock(links, node, item)
    if has_time:
        seconds = _read_text(links, node, "TimeUnits/Value") or "s"
        stamps = Column(name="Time", path=f"{leaf.path}/Time", unit=seconds)
        if time is not None:
            yield _stream(links, file, time, stamps, DEFAULT_CLASS)
        else:
            held = links.at(node, "Time")
            yield Item(column=stamps, shape=held.shape, dtype=held.dtype, load=loader(links.h5py, held))


def _with_clock(links: Links, node: Any, item: Item) -> Item:
    """Return a signal with the uniform time of ``CompressedTime``."""
    held = _non_empty_dataset(links, node, "CompressedTime")
    numbers = [] if held is None else np.asarray(held[()], dtype=float).ravel().tolist()
    if len(numbers) != 3 or numbers[1] <= 0.0 or item.column.fault:
        return item
    if numbers[2] != item.shape[0]:
        return _faulty_item(item.column, f"its time has {numbers[2]:.9g} samples, its data {item.shape[0]}")
    try:
        second = to_si_factor(_read_text(links, node, "TimeUnits/Value") or "s", "time")
    except RecordError as error:
        return _faulty_item(item.column, f"its time: {error}")
    return replace(item, column=replace(item.column, clock=Clock(numbers[0] * second, 1.0 / (numbers[1] * second))))


def _class_of(links: Links, node: Any) -> str | None:
    """Return the class of a signal's samples, or a description if it cannot be a channel; None if not stated."""
    attributes = links.at(node, "SignalAttributes")
    if attributes is None:
        return None
    told = [_read_text(links, attributes, name) for name in ("ClassName", "ResolvedClassName")]
    # An enumeration resolves to integers.
    kind = next((name for name in told if name in TYPES), told[0])
    complexity = _non_empty_dataset(links, attributes, "Complexity")
    if complexity is not None and _read_integer(complexity):
        return f"complex {kind}"
    return "signal of variable size" if _stream_of(links, node, VARIABLE_SIZE) is not None else kind


def _stream(links: Links, file: Any, number: int, column: Column, kind: str | None) -> Item:
    """Return the item of a stream; vector samples give several parallel series."""
    stream = links.at(file, f"{STREAMS}/{number}")
    if stream is None:
        return _faulty_item(column, f"its stream {number} is not in the file")
    data, length, size = links.at(stream, "#data#"), _read_integer(links.at(stream, "#length#")), 1
    # Some streams are stored as numbers; all others are bytes, to be interpreted by their class.
    if data.dtype.kind == "f":
        return Item(column=column, shape=(length,), load=_loader(links.h5py, data, length, 1, data.dtype))
    size = _read_integer(links.at(stream, "#sampleSize#"))
    if kind is None and size == TYPES[DEFAULT_CLASS].itemsize:
        kind = DEFAULT_CLASS
    if kind is None:
        return _faulty_item(
            column, f"{length} samples of {size} bytes each, whose class the file does not state; log it as double"
        )
    if kind not in TYPES:
        return _faulty_item(column, f'its samples are of the class "{kind}"; log it as double')
    dtype = TYPES[kind]
    if size % dtype.itemsize or data.size < size * length:
        return _faulty_item(column, f"{data.size} bytes for {length} samples of {size} bytes of the class {kind}")
    side = size // dtype.itemsize
    shape = (length,) if side == 1 else (length, side)
    return Item(column=column, shape=shape, dtype=dtype, load=_loader(links.h5py, data, length, size, dtype))


def _faulty_item(column: Column, fault: str) -> Item:
    return Item(column=Column(name=column.name, path=column.path, fault=fault))


def _loader(h5py: Any, data: Any, length: int, size: int, dtype: np.dtype[Any]) -> Any:
    """Return a function that loads a part of a stream of `length` samples with `size` array elements each."""
    path, name = data.file.filename, data.name

    def load(index: Index) -> NDArray[Any]:
        rows, *beside = index or (slice(None),)
        start, stop, step = (rows if isinstance(rows, slice) else slice(rows, rows + 1)).indices(length)
        with h5py.File(path, "r") as file:
            data = file[name]
            axis = int(np.argmax(data.shape))
            place = tuple(slice(size * start, size * stop) if k == axis else 0 for k in range(data.ndim))
            part = np.asarray(data[place])
        numbers = part if part.dtype.kind == "f" else np.frombuffer(part.tobytes(), dtype=dtype)
        numbers = numbers.reshape(stop - start, -1)[::step]
        found = numbers[:, beside[0]] if beside else numbers.squeeze(axis=1) if numbers.shape[1] == 1 else numbers
        return found if isinstance(rows, slice) else found[0]

    return load


def _non_empty_dataset(links: Links, node: Any, path: str) -> Any:
    """Return the dataset at a path, or None if there is none or it is empty."""
    # For an empty array MATLAB stores its dimensions as data, and marks them by an attribute.
    found = links.at(node, path)
    is_filled = isinstance(found, links.h5py.Dataset) and "MATLAB_empty" not in found.attrs and found.size
    return found if is_filled else None


def _stream_of(links: Links, node: Any, entry: str) -> int | None:
    found = _non_empty_dataset(links, node, entry)
    return None if found is None else _read_integer(found)


def _read_integer(node: Any) -> int:
    return int(node[()].flat[0])


def _read_text(links: Links, node: Any, path: str) -> str:
    """Return the text at a path, empty if there is none."""
    found = _non_empty_dataset(links, node, path)
    return _text(found) if found is not None and found.dtype.kind == "u" else ""


def _text(node: Any) -> str:
    return "" if "MATLAB_empty" in node.attrs else "".join(map(chr, node[()].ravel(order="F")))
