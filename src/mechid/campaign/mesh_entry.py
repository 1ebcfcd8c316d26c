"""Reader of tooth meshes: numbers of teeth, and orders that a file states by the name of a mesh."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from sympy import Expr, Symbol

from mechid.campaign.place import Place, describe_entry, is_table_list
from mechid.command.entry import is_number
from mechid.errors import did_you_mean
from mechid.plant.gear import ERROR, STIFFNESS
from mechid.plant.gear_mesh import DRIVEN, DRIVER, MOST_TEETH, TABLE, TEETH, mesh_lines, meshes

ORDER = "order"
EXAMPLE = f"write {TEETH} = [69, 74], the teeth of the driving and of the driven wheel"


def with_mesh_numbers(table: Mapping[str, Any], place: Place) -> Mapping[str, Any]:
    """Return the table of a mechanism file with the teeth of each mesh under two keys, and all orders as numbers.

    Parameters
    ----------
    table : mapping
        The file; lists that are no lists of tables are left to the reader of the structure.
    place : Place

    Raises
    ------
    InputFileError
        Numbers of teeth are missing, not two, not whole, below 1 or too large; or an order names no line of a mesh.
    """
    gear = table.get("gear")
    if not isinstance(gear, Mapping):
        return table
    entries = gear.get(_key(TABLE), [])
    if not is_table_list(entries):
        return table
    read = [_with_teeth(entry, place.key(f"{TABLE}.{k}")) for k, entry in enumerate(entries)]
    orders = _orders(read)
    changed: dict[str, Any] = {_key(TABLE): read} if read else {}
    for name in (ERROR, STIFFNESS):
        listed = gear.get(_key(name), [])
        if is_table_list(listed) and listed:
            changed[_key(name)] = [
                _with_order(entry, orders, place.key(f"{name}.{k}.{ORDER}")) for k, entry in enumerate(listed)
            ]
    return {**table, "gear": {**gear, **changed}} if changed else table


def join_teeth(entries: Mapping[str, str]) -> dict[str, str]:
    """Return the lines of a mesh, by key, with both numbers of teeth in one."""
    teeth = [entries[key].partition(" = ")[2] for key in (DRIVER, DRIVEN)]
    others = {key: line for key, line in entries.items() if key not in (DRIVER, DRIVEN)}
    return {TEETH: f"{TEETH} = [{', '.join(teeth)}]", **others}


def _key(name: str) -> str:
    return name.rpartition(".")[2]


def _with_teeth(entry: Mapping[str, Any], place: Place) -> dict[str, Any]:
    """Return the table of one mesh with its two numbers of teeth."""
    at = place.key(TEETH)
    if TEETH not in entry:
        raise at.error(f"missing; {EXAMPLE}")
    teeth = entry[TEETH]
    if not isinstance(teeth, list) or len(teeth) != 2:
        raise at.error(f"{describe_entry(teeth)}; {EXAMPLE}")
    for k, number in enumerate(teeth):
        if not is_number(number) or number != round(number) or not 1 <= number <= MOST_TEETH:
            raise at.item(k).error(
                f"{describe_entry(number)}; a number of teeth is a whole number from 1 to {MOST_TEETH:.0f}"
            )
    others = {key: value for key, value in entry.items() if key != TEETH}
    return {DRIVER: int(teeth[0]), DRIVEN: int(teeth[1]), **others}


def _orders(read: list[dict[str, Any]]) -> dict[str, float]:
    """Return the orders per turn of the input, by the names of the meshes' lines."""
    values = dict(_values(read))
    return {one.name: float(one.cycles.subs(values)) for one in mesh_lines(len(read))}


def _values(read: list[dict[str, Any]]) -> Iterator[tuple[Expr, float]]:
    """Yield the value of each symbol of the meshes; one that is missing or wrong is reported with the parameters."""
    for mesh, entry in zip(meshes(len(read)), read, strict=True):
        for declaration in mesh.declarations:
            value: Any = entry.get(_key(declaration.key), declaration.default)
            yield Symbol(declaration.symbol), float(value) if is_number(value) and value > 0.0 else 1.0


def _with_order(entry: Mapping[str, Any], orders: Mapping[str, float], place: Place) -> Mapping[str, Any]:
    """Return an entry of a list with its order as a number."""
    order = entry.get(ORDER)
    if not isinstance(order, str):
        return entry
    if not orders:
        raise place.error(f"{describe_entry(order)}, and the file has no [[{TABLE}]]; write it, or the number")
    if order not in orders:
        near = did_you_mean(order, tuple(orders)) or f"; the lines of the meshes are {', '.join(orders)}"
        raise place.error(f"{describe_entry(order)}{near}")
    return {**entry, ORDER: orders[order]}
