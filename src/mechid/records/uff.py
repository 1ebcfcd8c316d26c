"""Reader of universal files, data sets 58 (ASCII) and 58b (binary), by pyuff."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from mechid.errors import RecordError
from mechid.records.arrays import ArrayTable, Index, Item, array_table
from mechid.records.clock import round_rate
from mechid.records.memory import refuse_larger_than_memory
from mechid.records.table import Clock, Column
from mechid.records.third_party import import_library, wrap_parser_errors
from mechid.units import to_si_factor

KIND = "a universal file"
FUNCTION, UNITS = 58, 164
SI_UNITS_CODE = 1
TIME, FREQUENCY = 17, 18
"""Codes of an abscissa in data set 58, record 8."""
GENERAL, TIME_RESPONSE = 0, 1
FUNCTIONS = {
    2: "auto spectrum",
    3: "cross spectrum",
    4: "frequency response function",
    5: "transmissibility",
    6: "coherence",
    7: "auto correlation",
    8: "cross correlation",
    9: "power spectral density",
    12: "spectrum",
}
COMPLEX = (5, 6)
UNEVEN_SPACING = 0
EMPTY_TEXTS = ("", "NONE")
END_MARK = b"-1"
ENDS = ("rsp_ent_name", "rsp_node", "rsp_dir", "ref_ent_name", "ref_node", "ref_dir")
METADATA_KEYS = ("id1", "id2", "id3", "id4", "id5", *ENDS, "ordinate_axis_lab")


def open_uff(path: Path, label: str) -> ArrayTable:
    """Read the headers of the data sets 58 in the universal file at `path`.

    A data set's path is ``number/name``, with numbers from 0 over all data sets; the name is that of the response, or
    else of the ordinate. An uneven abscissa is a separate column, ``number/abscissa``.

    Raises
    ------
    RecordError
        The file is damaged or truncated, or contains no data set 58.
    """
    pyuff = import_library("pyuff", "pyuff", label)
    refuse_larger_than_memory(path, label, KIND)
    with wrap_parser_errors(label, KIND):
        _refuse_truncated(path, label)
        file = pyuff.UFF(str(path))
        types = [int(kind) for kind in file.get_set_types()]
        _refuse_without(types, label)
        alien = UNITS in types and file.read_sets(types.index(UNITS))["units_code"] != SI_UNITS_CODE
        heads = {n: file.read_sets(n, header_only=True) for n, kind in enumerate(types) if kind == FUNCTION}
        items = [item for n, head in heads.items() for item in _items(file, n, head, alien=alien)]
    return array_table(label, KIND, items, {})


def _refuse_truncated(path: Path, label: str) -> None:
    """Raise an error for a file without its end mark; pyuff would silently omit the last data set."""
    with path.open("rb") as file:
        file.seek(max(path.stat().st_size - 256, 0))
        tail = file.read().rstrip()
    if not tail.endswith(END_MARK):
        raise RecordError(f"{label}: no end mark (-1) at its end: cut off, or not {KIND}; write or copy it anew")


def _refuse_without(types: list[int], label: str) -> None:
    if FUNCTION not in types:
        found = ", ".join(map(str, types)) or "none"
        raise RecordError(f"{label}: contains no data set 58 (measured functions); its data sets: {found}")


def _items(file: Any, number: int, head: dict[str, Any], *, alien: bool) -> Iterator[Item]:
    samples = int(head["num_pts"])
    column = Column(
        name=_name(head),
        path=f"{number}/{_name(head)}",
        unit=_unit(head["ordinate_axis_units_lab"], alien=alien),
        fault=_find_fault(head),
        metadata={key: head[key] for key in METADATA_KEYS if head[key] not in EMPTY_TEXTS},
    )

    def load(key: str, index: Index) -> Any:
        (rows,) = index
        values = file.read_sets(number)[key]
        if values.size != samples:
            raise ValueError(f"it holds {values.size} of the {samples} samples that its head promises")
        return values[rows]

    values = Item(column=column, shape=(samples,), load=lambda index: load("data", index))
    if column.fault or head["abscissa_spacing"] != UNEVEN_SPACING:
        yield replace(values, column=column if column.fault else _with_clock(column, head))
        return
    yield values
    abscissa = Column(name="time", path=f"{number}/abscissa", unit=_unit(head["abscissa_axis_units_lab"], alien=False))
    yield Item(column=abscissa, shape=(samples,), load=lambda index: load("x", index))


def _name(head: dict[str, Any]) -> str:
    given = (str(head[key]).strip() for key in ("rsp_ent_name", "ordinate_axis_lab", "id1"))
    return next((name for name in given if name not in EMPTY_TEXTS), "")


def _unit(entry: str, *, alien: bool) -> str | None:
    """Return the label of a unit; without one, a note if data set 164 states that units are not SI, or None."""
    if entry.strip() not in EMPTY_TEXTS:
        return entry.strip()
    return "that of data set 164" if alien else None


def _find_fault(head: dict[str, Any]) -> str | None:
    function, abscissa = head["func_type"], head["abscissa_spec_data_type"]
    if head["ord_data_type"] in COMPLEX and function in (GENERAL, TIME_RESPONSE):
        return "complex numbers; a record needs real ones"
    if function not in (GENERAL, TIME_RESPONSE) or abscissa == FREQUENCY:
        kind = FUNCTIONS.get(function, f"function of type {function}")
        return f"it is no time history but a {kind}"
    if function == GENERAL and abscissa != TIME:
        return "it is no time history"
    return None


def _with_clock(column: Column, head: dict[str, Any]) -> Column:
    """Return the column with the clock of its even abscissa, or with a fault."""
    try:
        factor = to_si_factor(_unit(head["abscissa_axis_units_lab"], alien=False) or "s", "time")
    except RecordError as error:
        return replace(column, fault=f"its abscissa: {error}")
    interval = factor * float(head["abscissa_inc"])
    if not 0.0 < interval < np.inf:
        return replace(column, fault=f"its abscissa advances by {interval:.9g} s")
    return replace(column, clock=Clock(factor * float(head["abscissa_min"]), round_rate(1.0 / interval)))
