"""Objects of MATLAB's classes in a .mat file: tables, timetables, time series, and what others hold.

MathWorks publishes no layout. That of the table of objects, ``FileWrapper__`` versions 2 to 4, is read as N.
Lakshmisha's mat-io describes it (docs/subsystem_data_format.md): names, classes, objects, and for each object which
property is in which cell; that of a Simulink Dataset from files of others. Cells are read by the reader of the file;
here they are a tree of dicts (structs), lists (cells), texts, arrays (`Item`) and further objects.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mechid.records.arrays import Index, Item, fact
from mechid.records.table import Clock, Column, Fact

REFERENCE = 0xDD000000
"""First word of a reference to objects; then dimensions, the objects' numbers, and that of their class."""
VERSIONS = (2, 3, 4)
FIRST = 2
"""The first cell that holds a value."""
IN_CELL = 1
"""Kind of a property whose value is in a cell."""
MOST_LEVELS = 16
EXPORT = {
    "timeseries": "t = x.Time; y = x.Data",
    "table": "t = x.t; y = x.y",
    "timetable": "t = seconds(x.Time - x.Time(1)); y = x.y",
    "Simulink.SimulationData.Dataset": "s = x{1}.Values; t = s.Time; y = s.Data",
}
"""MATLAB's line that makes plain arrays of an object."""

Words: TypeAlias = NDArray[np.uint32]
Tree: TypeAlias = Any
"""A dict of trees, a list of them, a text, an `Item`, an `Instance`, or None."""


@dataclass(frozen=True)
class Instance:
    """An object: its class and properties."""

    kind: str
    properties: Mapping[str, Tree]


@dataclass(frozen=True)
class Objects:
    """The table of objects.

    Attributes
    ----------
    classes : tuple of str
        Name of the class of each object, by the object's number.
    cells : tuple of mapping
        For each object its properties' names and cells, counted from the first that holds a value.
    """

    classes: tuple[str, ...]
    cells: tuple[Mapping[str, int], ...]


def object_fault(kind: str) -> str:
    """Return why an object of a MATLAB class cannot be read, and how MATLAB makes plain arrays of it."""
    line = EXPORT.get(kind, "t = seconds(x.Time); y = x.y")
    return (
        f'an object of the MATLAB class "{kind}" in which no array of numbers is found; in MATLAB save plain '
        f"arrays, as {line}; save('run.mat', 't', 'y')"
    )


def referred(words: Words) -> tuple[int, ...]:
    """Return the numbers of the objects that an array of words refers to, none where it is no reference."""
    if words.size < 4 or words.dtype != np.uint32 or int(words.flat[0]) != REFERENCE:
        return ()
    flat = [int(word) for word in words.ravel()]
    count = int(np.prod(flat[2 : 2 + flat[1]]))
    return tuple(flat[2 + flat[1] : 2 + flat[1] + count])


def read_objects(blob: bytes) -> Objects:
    """Return the table of objects of the first cell of a ``FileWrapper__``.

    Raises
    ------
    ValueError, IndexError
        It is none, or of a version that nobody has described.
    """
    words = np.frombuffer(blob[: len(blob) // 4 * 4], dtype="<i4")
    if words.size < 10 or words[0] not in VERSIONS:
        raise ValueError("a table of objects of another version")
    offsets = [int(offset) for offset in words[2:10]]
    names = ["", *(name.decode() for name in blob[40 : offsets[0]].split(b"\0"))]
    regions = [words[a // 4 : b // 4].tolist() for a, b in pairwise(offsets[:5])]
    classes = [".".join(filter(None, (names[a], names[b]))) for a, b, *_ in _blocks(regions[0], 4)]
    saved, plain = (_properties(region, names) for region in (regions[1], regions[3]))
    objects = [*_blocks(regions[2], 6)]
    return Objects(
        classes=tuple(classes[kind] for kind, *_ in objects),
        cells=tuple(saved[s] if s else plain[n] for _, _, _, s, n, _ in objects),
    )


def _blocks(words: Sequence[int], size: int) -> Iterator[Sequence[int]]:
    return (words[at : at + size] for at in range(0, len(words) - size + 1, size))


def _properties(words: Sequence[int], names: Sequence[str]) -> list[dict[str, int]]:
    """Return the cells of each object's properties: a count, three words for each, up to the next even place."""
    found, at = [], 0
    while at < len(words):
        if words[at] < 0:
            raise ValueError("a count of properties below 0")
        end = at + 1 + 3 * words[at]
        listed = _blocks(words[at + 1 : end], 3)
        found.append({names[name]: cell for name, kind, cell in listed if kind == IN_CELL})
        at = end + end % 2
    return found


class Heap:
    """The objects of a file, each made once; what its cells hold, the reader of the file tells by `tree`.

    Attributes
    ----------
    table : Objects or None
        None where it could not be read.
    cells : sequence
        As the file's reader has them.
    """

    def __init__(self, cells: Sequence[Any], blob: Callable[[Any], bytes]) -> None:
        self.cells = cells
        self.table: Objects | None = None
        self._made: dict[int, Instance | None] = {}
        with suppress(ValueError, IndexError):
            self.table = read_objects(blob(cells[0]))

    def instances(self, words: Words) -> list[Instance]:
        """Return the objects that an array of words refers to; none where it is no reference."""
        if self.table is None:
            return []
        return [found for number in referred(words) if (found := self._instance(self.table, number)) is not None]

    def one_or_all(self, words: Words) -> Tree:
        """Return the object that is referred to, or the list of them; None where it is being made."""
        found = self.instances(words)
        return found[0] if len(found) == 1 else found or None

    def tree(self, node: Any) -> Tree:
        """Return what a cell, or a part of it, holds."""
        raise NotImplementedError

    def _instance(self, table: Objects, number: int) -> Instance | None:
        """Return an object; None while it is being made, as of one that holds itself."""
        if number not in self._made:
            self._made[number] = None
            listed = table.cells[number].items()
            held = {name: self.tree(self.cells[FIRST + cell]) for name, cell in listed}
            self._made[number] = Instance(table.classes[number], held)
        return self._made[number]


def unpacked(column: Column, instance: Instance, metadata: dict[str, Fact]) -> list[Item]:
    """Return the series that an object holds; those of one number or text become metadata."""
    found: list[Item] = []
    with suppress(KeyError, ValueError, TypeError, AttributeError):  # a class of that name with other properties
        found = [item for item in READERS.get(instance.kind, _any)(column, instance.properties) if 0 not in item.shape]
    kept = [item for item in found if not _is_fact(item, metadata)]
    return kept if found else [Item(column=replace(column, fault=object_fault(instance.kind)))]


def _is_fact(item: Item, metadata: dict[str, Fact]) -> bool:
    if int(np.prod(item.shape)) != 1:
        return False
    single = fact(item.load(()))
    if single is not None:
        metadata[item.column.key] = single
    return True


def _table(column: Column, properties: Mapping[str, Tree]) -> Iterator[Item]:
    extra = properties.get("props") or {}
    yield from _variables(column, properties["data"], properties["varnames"], extra.get("VariableUnits"))


def _timetable(column: Column, properties: Mapping[str, Tree]) -> Iterator[Item]:
    saved = properties["any"]
    rows = saved["rowTimes"]
    clock, start = _regular(rows) if isinstance(rows, Mapping) else (None, None)
    names = _texts(saved.get("dimNames"))
    time = Column(name="Time", path=f"{column.key}/{names[0] if names else 'Time'}")
    if clock is None:
        yield from _times(time, rows)
    for item in _variables(column, saved["data"], saved["varNames"], saved.get("varUnits")):
        yield replace(item, column=replace(item.column, clock=clock, start_time=start))


def _timeseries(column: Column, properties: Mapping[str, Tree]) -> Iterator[Item]:
    """Yield the data, and the time where it is no regular clock: then TimeInfo has its start and increment."""
    kept = _plain_names(properties)
    told = _plain_names(_properties_of(kept.get("TimeInfo")))
    time = next((part for part in (kept.get("Time"), told.get("Time")) if isinstance(part, Item)), None)
    start, step = (told.get(name) for name in ("Start", "Increment"))
    clock = None
    if time is None and isinstance(step, Item) and _single(step) > 0.0:
        clock = Clock(_single(start) if isinstance(start, Item) else 0.0, 1.0 / _single(step))
    if time is not None:
        yield replace(time, column=Column(name="Time", path=f"{column.key}/Time", unit=_unit(told)))
    if isinstance(kept.get("Data"), Item):
        unit = _unit(_plain_names(_properties_of(kept.get("DataInfo"))))
        path = f"{column.key}/Data" if time is not None else column.key
        yield replace(kept["Data"], column=replace(column, path=path, clock=clock, unit=unit))


def _dataset(column: Column, properties: Mapping[str, Tree]) -> Iterator[Item]:
    """Yield the signals of a Simulink Dataset under their names."""
    elements = properties["any"]["Storage"].properties["any"]["Elements"]
    elements = elements if isinstance(elements, list) else [elements]
    names = [_name(element) or f"element_{place}" for place, element in enumerate(elements)]
    for place, (name, element) in enumerate(zip(names, elements, strict=True)):
        where = name if names.count(name) < 2 else f"{name}/{place}"
        yield from _walked(f"{column.key}/{where}", element, 0, name)


def _signal(column: Column, properties: Mapping[str, Tree]) -> Iterator[Item]:
    yield from _walked(column.key, properties["Values"], 0, column.name)


def _output(column: Column, properties: Mapping[str, Tree]) -> Iterator[Item]:
    """Yield what a simulation's output has, without its metadata."""
    for name, part in properties["Data"].items():
        yield from _walked(f"{column.key}/{name}", part, 0)


def _name(element: Tree) -> str:
    """Return the name of a signal, of its values, or of the block that it comes from."""
    properties = _properties_of(element)
    blocks = _properties_of(properties.get("BlockPath")).get("path")
    names = (properties.get("Name"), _properties_of(properties.get("Values")).get("Name"), *_texts(blocks))
    return next((name.rpartition("/")[2] for name in names if isinstance(name, str) and name), "")


def _plain_names(properties: Mapping[str, Tree]) -> dict[str, Tree]:
    """Return properties by the names that MATLAB shows, without the ending of those that it hides."""
    return {name.removesuffix("_"): value for name, value in properties.items() if value is not None}


def _properties_of(tree: Tree) -> Mapping[str, Tree]:
    found = tree.properties if isinstance(tree, Instance) else tree
    return found if isinstance(found, Mapping) else {}


def _any(column: Column, properties: Mapping[str, Tree]) -> Iterator[Item]:
    yield from _walked(column.key, dict(properties), 0)


def _walked(path: str, tree: Tree, level: int, name: str = "") -> Iterator[Item]:
    """Yield every array in a tree under its path; objects in it in the way of their classes."""
    column = Column(name=name or path.rpartition("/")[2], path=path)
    if level > MOST_LEVELS:
        return
    if isinstance(tree, Instance) and tree.kind in READERS:
        yield from READERS[tree.kind](column, tree.properties)
    elif isinstance(tree, Instance | Mapping):
        for key, part in _properties_of(tree).items():
            yield from _walked(f"{path}/{key.removesuffix('_')}", part, level + 1)
    elif isinstance(tree, list):
        for place, part in enumerate(tree):
            yield from _walked(f"{path}/{place}", part, level + 1)
    elif isinstance(tree, Item):
        yield replace(tree, column=column)


def _variables(column: Column, data: Tree, names: Tree, units: Tree) -> Iterator[Item]:
    told = _texts(units)
    for place, (name, values) in enumerate(zip(_texts(names), data, strict=True)):
        own = Column(name=name, path=f"{column.key}/{name}", unit=(told[place] or None) if place < len(told) else None)
        if isinstance(values, Item):
            yield replace(values, column=own)
        elif isinstance(values, Instance) and values.kind in TIMES:
            yield from _times(own, values)


def _times(column: Column, values: Tree) -> Iterator[Item]:
    """Yield durations and dates in s, dates since the first."""
    if isinstance(values, Item):
        yield replace(values, column=column)
    elif isinstance(values, Instance) and values.kind in TIMES:
        item = values.properties.get(TIMES[values.kind])
        if isinstance(item, Item) and 0 not in item.shape:
            first = float(np.real(_numbers(item, ())).flat[0]) if values.kind == "datetime" else 0.0
            start = str(np.datetime64(round(first), "ms")) if values.kind == "datetime" else None
            told = replace(column, unit="s", start_time=start)
            yield replace(item, column=told, dtype=np.dtype(float), load=_seconds(item, first))


def _seconds(item: Item, first: float) -> Callable[[Index], Any]:
    """Return what loads milliseconds as seconds since `first`; an imaginary part is what the real one leaves."""

    def load(index: Index) -> NDArray[np.float64]:
        values = _numbers(item, index)
        return np.asarray(((np.real(values) - first) + np.imag(values)) * 1e-3)

    return load


def _numbers(item: Item, index: Index) -> NDArray[Any]:
    """Return a part of an array; HDF5 keeps a complex number as two fields."""
    values = np.asarray(item.load(index))
    return values["real"] + 1j * values["imag"] if values.dtype.names else values


def _regular(rows: Mapping[str, Tree]) -> tuple[Clock | None, str | None]:
    """Return the clock of a timetable that was given by rate or step, and the date of its first row if there is one."""
    rate, step, origin = rows.get("sampleRate"), rows.get("stepSize"), rows.get("origin")
    if isinstance(step, Instance) and not _truth(rows.get("specifiedAsRate")):
        millis = step.properties.get("millis")
        hertz = 1e3 / _single(millis) if isinstance(millis, Item) else 0.0
    else:
        hertz = _single(rate) if isinstance(rate, Item) else 0.0
    begun = next(_times(Column(), origin), None)
    start = _single(begun) if begun else 0.0
    return (Clock(start, hertz) if hertz else None), (begun.column.start_time if begun else None)


def _single(item: Item) -> float:
    return float(np.asarray(item.load(())).flat[0])


def _truth(value: Tree) -> bool:
    return isinstance(value, Item) and bool(_single(value))


def _texts(tree: Tree) -> list[str]:
    listed = tree if isinstance(tree, list) else [tree]
    return [text if isinstance(text, str) else "" for text in listed]


def _unit(told: Mapping[str, Tree]) -> str | None:
    unit = told.get("Units")
    return unit if isinstance(unit, str) and unit else None


TIMES = {"duration": "millis", "datetime": "data"}
"""Classes of times, and the property that has the milliseconds."""
READERS: Mapping[str, Callable[[Column, Mapping[str, Tree]], Iterator[Item]]] = {
    "table": _table,
    "timetable": _timetable,
    "timeseries": _timeseries,
    "Simulink.SimulationData.Dataset": _dataset,
    "Simulink.SimulationData.Signal": _signal,
    "Simulink.SimulationOutput": _output,
    "duration": lambda column, properties: _times(column, Instance("duration", properties)),
    "string": lambda column, properties: iter(()),
    "datetime": lambda column, properties: _times(column, Instance("datetime", properties)),
}
"""Classes whose properties mean something here; of others every array is a column under its property's path."""
