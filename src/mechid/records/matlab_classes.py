"""Interpretation of MATLAB classes: tables, timetables, time series, Simulink Datasets, and any other class.

The properties of tables follow the description by mat-io; those of time series and Simulink Datasets were derived from
third-party files written by R2024b.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechid.arrays import FloatArray
from mechid.records.arrays import Index, Item, fact
from mechid.records.mcos import Instance, Tree
from mechid.records.table import Clock, Column, Fact

MAX_LEVELS = 16
EXPORT = {
    "timeseries": "t = x.Time; y = x.Data",
    "table": "t = x.t; y = x.y",
    "timetable": "t = seconds(x.Time - x.Time(1)); y = x.y",
    "Simulink.SimulationData.Dataset": "s = x{1}.Values; t = s.Time; y = s.Data",
}
"""MATLAB statements that convert objects to plain arrays, by class."""


def object_fault(kind: str) -> str:
    """Return the reason why an object of a MATLAB class cannot be read, with a remedy in MATLAB."""
    line = EXPORT.get(kind, "t = seconds(x.Time); y = x.y")
    return (
        f'an object of the MATLAB class "{kind}" without a readable array of numbers; in MATLAB save plain '
        f"arrays, as {line}; save('run.mat', 't', 'y')"
    )


def unpack_object(column: Column, instance: Instance, metadata: dict[str, Fact]) -> list[Item]:
    """Return the series of an object; single numbers and texts become metadata."""
    found: list[Item] = []
    # A class of that name with other properties.
    with suppress(KeyError, ValueError, TypeError, AttributeError):
        found = [
            item for item in READERS.get(instance.kind, _any_class)(column, instance.properties) if 0 not in item.shape
        ]
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
    clock, start = _regular_clock(rows) if isinstance(rows, Mapping) else (None, None)
    names = _texts(saved.get("dimNames"))
    time = Column(name="Time", path=f"{column.key}/{names[0] if names else 'Time'}")
    if clock is None:
        yield from _times(time, rows)
    for item in _variables(column, saved["data"], saved["varNames"], saved.get("varUnits")):
        yield replace(item, column=replace(item.column, clock=clock, start_time=start))


def _timeseries(column: Column, properties: Mapping[str, Tree]) -> Iterator[Item]:
    """Yield the data, and the time unless it is a regular clock with start and increment in TimeInfo."""
    kept = _plain_names(properties)
    info = _plain_names(_properties_of(kept.get("TimeInfo")))
    time = next((part for part in (kept.get("Time"), info.get("Time")) if isinstance(part, Item)), None)
    start, step = (info.get(name) for name in ("Start", "Increment"))
    clock = None
    if time is None and isinstance(step, Item) and _single(step) > 0.0:
        clock = Clock(_single(start) if isinstance(start, Item) else 0.0, 1.0 / _single(step))
    if time is not None:
        yield replace(time, column=Column(name="Time", path=f"{column.key}/Time", unit=_unit(info)))
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
        yield from _walk_tree(f"{column.key}/{where}", element, 0, name)


def _signal(column: Column, properties: Mapping[str, Tree]) -> Iterator[Item]:
    yield from _walk_tree(column.key, properties["Values"], 0, column.name)


def _output(column: Column, properties: Mapping[str, Tree]) -> Iterator[Item]:
    """Yield the series of a simulation output, without its metadata."""
    for name, part in properties["Data"].items():
        yield from _walk_tree(f"{column.key}/{name}", part, 0)


def _name(element: Tree) -> str:
    """Return the name of a signal, of its values, or of its source block."""
    properties = _properties_of(element)
    blocks = _properties_of(properties.get("BlockPath")).get("path")
    names = (properties.get("Name"), _properties_of(properties.get("Values")).get("Name"), *_texts(blocks))
    return next((name.rpartition("/")[2] for name in names if isinstance(name, str) and name), "")


def _plain_names(properties: Mapping[str, Tree]) -> dict[str, Tree]:
    """Return properties by the names shown in MATLAB, without the trailing underscore of hidden ones."""
    return {name.removesuffix("_"): value for name, value in properties.items() if value is not None}


def _properties_of(tree: Tree) -> Mapping[str, Tree]:
    found = tree.properties if isinstance(tree, Instance) else tree
    return found if isinstance(found, Mapping) else {}


def _any_class(column: Column, properties: Mapping[str, Tree]) -> Iterator[Item]:
    yield from _walk_tree(column.key, dict(properties), 0)


def _walk_tree(path: str, tree: Tree, level: int, name: str = "") -> Iterator[Item]:
    """Yield every array in a tree with its path; objects are interpreted according to their classes."""
    column = Column(name=name or path.rpartition("/")[2], path=path)
    if level > MAX_LEVELS:
        return
    if isinstance(tree, Instance) and tree.kind in READERS:
        yield from READERS[tree.kind](column, tree.properties)
    elif isinstance(tree, Instance | Mapping):
        for key, part in _properties_of(tree).items():
            yield from _walk_tree(f"{path}/{key.removesuffix('_')}", part, level + 1)
    elif isinstance(tree, list):
        for place, part in enumerate(tree):
            yield from _walk_tree(f"{path}/{place}", part, level + 1)
    elif isinstance(tree, Item):
        yield replace(tree, column=column)


def _variables(column: Column, data: Tree, names: Tree, units: Tree) -> Iterator[Item]:
    own_units = _texts(units)
    for place, (name, values) in enumerate(zip(_texts(names), data, strict=True)):
        own = Column(
            name=name, path=f"{column.key}/{name}", unit=(own_units[place] or None) if place < len(own_units) else None
        )
        if isinstance(values, Item):
            yield replace(values, column=own)
        elif isinstance(values, Instance) and values.kind in TIMES:
            yield from _times(own, values)


def _times(column: Column, values: Tree) -> Iterator[Item]:
    """Yield durations in s, and dates in s since the first one."""
    if isinstance(values, Item):
        yield replace(values, column=column)
    elif isinstance(values, Instance) and values.kind in TIMES:
        item = values.properties.get(TIMES[values.kind])
        if isinstance(item, Item) and 0 not in item.shape:
            first = float(np.real(_numbers(item, ())).flat[0]) if values.kind == "datetime" else 0.0
            start = str(np.datetime64(round(first), "ms")) if values.kind == "datetime" else None
            in_seconds = replace(column, unit="s", start_time=start)
            yield replace(item, column=in_seconds, dtype=np.dtype(float), load=_seconds(item, first))


def _seconds(item: Item, first: float) -> Callable[[Index], Any]:
    """Return a function that loads milliseconds as seconds since `first`.

    The imaginary part of a value is the rounding error of its real part.
    """

    def load(index: Index) -> FloatArray:
        values = _numbers(item, index)
        return np.asarray(((np.real(values) - first) + np.imag(values)) * 1e-3)

    return load


def _numbers(item: Item, index: Index) -> NDArray[Any]:
    """Return a part of an array; HDF5 stores a complex number as two fields."""
    values = np.asarray(item.load(index))
    return values["real"] + 1j * values["imag"] if values.dtype.names else values


def _regular_clock(rows: Mapping[str, Tree]) -> tuple[Clock | None, str | None]:
    """Return the clock of a timetable defined by rate or step, and the date of its first row, if any."""
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


def _unit(info: Mapping[str, Tree]) -> str | None:
    unit = info.get("Units")
    return unit if isinstance(unit, str) and unit else None


TIMES = {"duration": "millis", "datetime": "data"}
"""Classes of times, with the property that contains the milliseconds."""
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
"""Interpreted classes; for others every array is a column with the path of its property."""
