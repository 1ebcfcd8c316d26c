"""Torque lines as Nastran loads: for each order a complex load over frequency, and its bound."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.budgets.settings import LEVEL
from mechid.exports.forcing import Forcing
from mechid.exports.tables.bulk_cards import comment, darea, rload1, rload2, tabled1
from mechid.exports.tables.options import Options
from mechid.writing import write_atomically

FILE_NAME = "lines.bdf"
RELEVANT = 0.01
"""Share of the largest bound of a stepping mode; orders below it at all rates are omitted."""


@dataclass(frozen=True, eq=False)
class OrderLoad:
    """Load of one order over the rate.

    Attributes
    ----------
    stepping : str
    order : float
    frequency_hz : (n,)
        Frequencies at the tabulated rates, ascending.
    lines : (n,) complex
        Modelled lines in N m; 0 if the model has none.
    bound : (n,)
        Bounds in N m.
    """

    stepping: str
    order: float
    frequency_hz: FloatArray
    lines: ComplexArray
    bound: FloatArray


def order_loads(forcing: Forcing) -> tuple[OrderLoad, ...]:
    """Return the loads of a stepping mode whose order is relevant at any rate, in ascending order."""
    cells: dict[float, list[tuple[float, complex, float]]] = {}
    for rate, at in zip(forcing.mode.rates.tolist(), forcing.emissions, strict=True):
        rows = zip(at.orders.tolist(), at.modelled.tolist(), at.bound.tolist(), strict=True)
        for order, line, bound in rows:
            cells.setdefault(order, []).append((order * rate, line, bound))
    largest = max((bound for rows in cells.values() for _, _, bound in rows), default=0.0)
    return tuple(
        _load(forcing, order, cells[order])
        for order in sorted(cells)
        if max(bound for _, _, bound in cells[order]) >= RELEVANT * largest > 0.0
    )


def _load(forcing: Forcing, order: float, found: Sequence[tuple[float, complex, float]]) -> OrderLoad:
    """Return the load of one order, 0 at intermediate rates where it is absent."""
    ends = found[0][0], found[-1][0]
    every = (order * forcing.mode.rates).tolist()
    # Between its first and last rate, an absent order is 0 rather than interpolated.
    known = {f: (line, bound) for f, line, bound in found}
    inside = [f for f in every if ends[0] <= f <= ends[1]]
    line, bound = zip(*(known.get(f, (0.0j, 0.0)) for f in inside), strict=True)
    return OrderLoad(
        forcing.stepping.name,
        order,
        np.array(inside),
        np.array(line, dtype=np.complex128),
        np.array(bound, dtype=np.float64),
    )


def write_bulk(forcings: Sequence[Forcing], options: Options, provenance: Mapping[str, Any], folder: Path) -> str:
    """Write the loads of all stepping modes; return the file name."""
    loads = [load for forcing in forcings for load in order_loads(forcing)]
    write_atomically(folder / FILE_NAME, bulk_text(loads, options, provenance))
    return FILE_NAME


def bulk_text(loads: Sequence[OrderLoad], options: Options, provenance: Mapping[str, Any]) -> Iterator[str]:
    """Yield the text of the file: header, load location, and two load sets with tables for each order."""
    yield from _head(options, provenance)
    area = options.first_id
    yield darea(area, options.node, options.component, float(options.scale))
    for at, load in enumerate(loads):
        # Nastran numbers loads and tables separately, so that equal numbers do not collide.
        nominal, bound, table = area + 1 + 2 * at, area + 2 + 2 * at, area + 3 * at
        title = f"{load.stepping}, order {load.order:g}, {load.frequency_hz[0]:.6g} to {load.frequency_hz[-1]:.6g} Hz"
        f = load.frequency_hz.tolist()
        yield "$\n"
        yield from comment(title)
        if np.any(load.lines):
            yield from comment(f"Load {nominal}: the model's line, at most {np.abs(load.lines).max():.4g} N m")
            yield rload1(nominal, area, table, table + 1)
            yield from tabled1(table, f, load.lines.real.tolist())
            yield from tabled1(table + 1, f, load.lines.imag.tolist())
        yield from comment(f"Load {bound}: its bound, at most {load.bound.max():.4g} N m")
        yield rload2(bound, area, table + 2)
        yield from tabled1(table + 2, f, load.bound.tolist())


def _head(options: Options, provenance: Mapping[str, Any]) -> Iterator[str]:
    yield from comment(
        f"Torque of a stepper mechanism, lines over the step rate, by mechid {provenance['mechid']}. "
        f"{provenance['mechanism']} {provenance['trust']}"
    )
    yield "$\n"
    yield from comment(
        "Units: frequency Hz, torque N m times the last field of the DAREA card: 1.0 for a model in m, kg, s; 1000.0 "
        "for one in mm, t, s (N mm)."
    )
    yield from comment(
        f"REPLACE on the DAREA card grid {options.node} and component {options.component} by the grid point and the "
        "rotation about the mechanism's axis in its output frame. All loads act through it."
    )
    yield from comment(
        "A load is one order of the step rate: at f Hz the mechanism runs at f/order full steps a second. Orders are "
        "different frequencies at one rate: one subcase each, never summed in one. Outside the tables it is 0."
    )
    yield from comment(
        f"RLOAD1 is the model's line with its phase. RLOAD2 is the amplitude that it stays below with "
        f"{LEVEL.bound:.0%}, at phase 0: the model, the errors of its parameters, and what it lacks."
    )
    yield "$\n"
