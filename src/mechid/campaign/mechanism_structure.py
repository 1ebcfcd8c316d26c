"""Structural entries of a mechanism file: assembly, laws, lists of tables, optional tables and user blocks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import sympy as sp

from mechid.campaign.phases_entry import phase_options, read_phases
from mechid.campaign.place import Place, describe_entry, is_table_list, text
from mechid.campaign.user_block import read_own_block
from mechid.command.entry import is_number, is_table
from mechid.errors import InputFileError
from mechid.plant.assembly import check_assembly, plant_of
from mechid.plant.block import Block
from mechid.plant.detent import detent_order
from mechid.plant.layout import STEPPER_GEAR_MASS, Layout
from mechid.plant.plant import Plant
from mechid.plant.tables import CHOICES, LISTS, OPTIONAL, OWN, TABLES, Table, table_of

ASSEMBLY = "assembly"
OWN_KEY, ORDER_KEY = "block", "order"
# The kernel's sines of multiple angles are tested up to this order.
HIGHEST_ORDER = 1000
"""Highest order of a harmonic in a list."""
HIGHEST_FILTER = 64
"""Highest order for which filter equations are built; the declaration of the filter may refuse lower orders."""
# 40 detents compile in about 30 s, 80 in two minutes.
MOST_ENTRIES = 64
"""Longest list of tables."""
# Far below the period of any motor, and large enough that the order does not overflow.
SHORTEST_PERIOD_DEG = 1e-6
"""Shortest period of a detent."""


@dataclass(frozen=True)
class Structure:
    """Plant and options of a mechanism file.

    Attributes
    ----------
    plant : Plant
    options : mapping of str to str
        ``assembly``; ``housing.form`` if there is a housing; every law and block named in the file.
    layout : Layout
        Layout from which the plant was made.
    """

    plant: Plant
    options: Mapping[str, str] = field(default_factory=dict)
    layout: Layout = field(default_factory=Layout)

    def law_with(self, name: str) -> tuple[str, str] | None:
        """Return the option and the law with which a table has the parameter `name`, None if no law has it."""
        table = table_of(name)
        for law in CHOICES.get(table, ()):
            other = replace(self.layout, laws={**self.layout.laws, table: law}, own={})
            try:
                if name in plant_of(other).declarations:
                    return TABLES[table].option, law
            except InputFileError:
                continue
        return None


def read_structure(table: Mapping[str, Any], place: Place, folder: Path) -> Structure:
    """Read the structure of a mechanism file.

    Missing or invalid numbers are ignored here; reading the parameters reports them.

    Raises
    ------
    InputFileError
        The assembly or a law is unknown, a list of tables is invalid, or a user block is unusable.
    """
    laws = dict(_laws(table, place))
    own = dict(_own_blocks(table, place, folder))
    if both := next((name for name in own if name in laws), None):
        key = TABLES[both].option
        raise place.key(f"{both}.{OWN_KEY}").error(f'excludes {key} = "{laws[both]}"; keep one of them')
    tables = frozenset(name for name in OPTIONAL if is_table(entry := _at(table, name)) and "value" not in entry)
    orders = {name: tuple(_orders(table, TABLES[name], place)) for name in LISTS}
    orders |= {
        name: (_order(_at(table, name), place.key(name), TABLES[name]),) for name in tables if TABLES[name].told_by
    }
    layout = Layout(
        assembly=_assembly(table, place),
        laws=laws,
        orders={name: found for name, found in orders.items() if found},
        tables=tables,
        own={name: block for name, (block, _) in own.items()},
        phases=read_phases(table, place),
    )
    options = {ASSEMBLY: layout.assembly}
    options |= {f"{name}.{TABLES[name].option}": law for name, law in laws.items()}
    options |= {f"{name}.{OWN_KEY}": where for name, (_, where) in own.items()}
    with _in_file(place):
        plant = plant_of(layout)
    return Structure(plant, {**options, **phase_options(table, plant.declarations)}, layout)


@lru_cache(maxsize=32)
def divisors(plant: Plant) -> frozenset[str]:
    """Return the dotted names of the parameters that occur as divisors in the equations."""
    system, special = plant.filter, (e for s, e in plant.coordinates.items() if s != e)
    sources = (*(e for _, e in plant.terms), *plant.rates, *plant.initial, *system.A, *system.B, *special)
    powers = {power for e in map(sp.sympify, sources) for power in e.atoms(sp.Pow) if power.exp.is_negative}
    symbols = {symbol.name for power in powers for symbol in power.base.free_symbols if power.base.is_Symbol}
    return frozenset(name for name, d in plant.declarations.items() if d.symbol in symbols)


def _assembly(table: Mapping[str, Any], place: Place) -> str:
    remedy = f'write {ASSEMBLY} = "{STEPPER_GEAR_MASS}", or leave it out'
    name = text(table.get(ASSEMBLY, STEPPER_GEAR_MASS), place.key(ASSEMBLY), remedy)
    with _in_file(place):
        check_assembly(name)
    return name


def _laws(table: Mapping[str, Any], place: Place) -> Iterator[tuple[str, str]]:
    """Yield each table that selects its block by a key, with the selected law."""
    for name, choices in CHOICES.items():
        entry, key = _at(table, name), TABLES[name].option
        if not isinstance(entry, Mapping):
            continue
        if key in entry or (TABLES[name].named and OWN_KEY not in entry):
            default = next(iter(choices))
            remedy = f'write {key} = "{default}", or leave it out'
            yield name, text(entry.get(key, default), place.key(f"{name}.{key}"), remedy)


def _own_blocks(table: Mapping[str, Any], place: Place, folder: Path) -> Iterator[tuple[str, tuple[Block, str]]]:
    for name in OWN:
        entry = table.get(name)
        if isinstance(entry, Mapping) and OWN_KEY in entry:
            yield name, read_own_block(entry[OWN_KEY], place.key(f"{name}.{OWN_KEY}"), folder)


def _orders(table: Mapping[str, Any], listed: Table, place: Place) -> Iterator[int | None]:
    """Yield the harmonic order of each entry of a list of tables, a detent's from its period; None if there is none."""
    name = listed.name
    entries = _at(table, name) or []
    if not is_table_list(entries):
        raise place.key(name).error(
            f"{describe_entry(entries)}; write each {listed.entry} as a table under [[{name}]], in two brackets"
        )
    if len(entries) > MOST_ENTRIES:
        raise place.key(name).error(
            f"{len(entries)} tables, whose equations would take minutes to compile; keep {MOST_ENTRIES} at most"
        )
    for index, entry in enumerate(entries):
        if listed.told_by == ORDER_KEY:
            yield _order(entry, place.key(f"{name}.{index}"), listed)
        elif not listed.told_by:
            yield None
        else:
            at = place.key(f"{name}.{index}.{listed.told_by}")
            yield _by_period(_at(table, listed.beside), entry.get(listed.told_by), at)


def _by_period(poles: Any, period_deg: Any, place: Place) -> int | None:
    """Return the harmonic order of a period; None if a value is missing or invalid, which is reported elsewhere."""
    if not (is_number(poles) and is_number(period_deg) and poles > 0 and period_deg > 0):
        return None
    if period_deg < SHORTEST_PERIOD_DEG:
        raise place.error(f"{describe_entry(period_deg)}; write degrees of the rotor, {SHORTEST_PERIOD_DEG:g} or above")
    return detent_order(poles, period_deg)


def _order(entry: Mapping[str, Any], place: Place, of: Table) -> int | None:
    """Return an integer order, None for one that the equations take as a value.

    A missing or invalid value is reported when the parameters are read.
    """
    order = entry.get(ORDER_KEY, of.order)
    if not is_number(order):
        return None if of.by_value else of.order
    if of.fractions and (of.by_value or order != round(order)):
        return None
    if order != round(order):
        raise place.key(ORDER_KEY).error(f"{describe_entry(order)}; write a whole number")
    if of.entry and order > HIGHEST_ORDER:
        raise place.key(ORDER_KEY).error(f"{describe_entry(order)}; write a whole number up to {HIGHEST_ORDER}")
    return None if of.by_value else max(1, min(int(order), HIGHEST_ORDER if of.entry else HIGHEST_FILTER))


def _at(table: Mapping[str, Any], name: str) -> Any:
    """Return the entry of a dotted name, None if there is none."""
    entry: Any = table
    for key in name.split("."):
        entry = entry.get(key) if is_table(entry) else None
    return entry


@contextmanager
def _in_file(place: Place) -> Iterator[None]:
    """Prefix errors of the plant with the file."""
    try:
        yield
    except InputFileError as error:
        raise place.error(str(error)) from error
