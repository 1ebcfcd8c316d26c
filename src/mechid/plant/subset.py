"""Removal of tables from a mechanism, the reverse of a superset."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace

from mechid.plant.assembly import plant_of
from mechid.plant.layout import Layout
from mechid.plant.mechanism import Mechanism
from mechid.plant.tables import LISTS


def nulls_of(mechanism: Mechanism, names: Iterable[str]) -> dict[str, float]:
    """Return the null values of an extension's parameters, by dotted name, in the file's units.

    Phases are left out, since they have no effect at amplitude 0.
    """
    phases = {pair.phase for pair in mechanism.plant.polar_pairs}
    declared = mechanism.plant.declarations
    return {name: declared[name].default or 0.0 for name in names if name not in phases}


def subset_of(mechanism: Mechanism, base: Mechanism, tables: Collection[str]) -> Mechanism:
    """Return a mechanism without some tables, or with those of another mechanism in their place.

    Parameters
    ----------
    mechanism : Mechanism
        Has all tables of `base`, and in each list first the entries of `base`.
    base : Mechanism
        Its laws and tables replace the removed ones, where it has them; both have a layout.
    tables : collection of str
        Dotted names of tables, ``"stepper.imbalance"``, and of entries of lists, ``"stepper.detent.2"``. Later entries
        of a list move up.
    """
    here, there = mechanism.plant.layout, base.plant.layout
    assert here is not None
    assert there is not None
    kept = {
        name: [k for k in range(len(orders)) if f"{name}.{k}" not in tables or k < len(there.orders.get(name, ()))]
        for name, orders in here.orders.items()
        if name in LISTS
    }
    plant = plant_of(_layout(here, there, kept, tables))
    # Entries of a list are known by their position, which changes where an earlier one goes.
    moved = {f"{name}.{new}": f"{name}.{old}" for name, own in kept.items() for new, old in enumerate(own)}
    parameters = {}
    for name, declaration in plant.declarations.items():
        table, _, key = name.rpartition(".")
        parameter = mechanism.parameters[f"{moved.get(table, table)}.{key}"]
        parameters[name] = replace(parameter, name=name, declaration=declaration)
    options = {
        o: law for o, law in mechanism.options.items() if o.rpartition(".")[0] not in tables or o in base.options
    }
    changed = {o: base.options[o] for o in options if o.rpartition(".")[0] in tables}
    return Mechanism(plant, parameters, {**options, **changed})


def _layout(here: Layout, there: Layout, kept: dict[str, list[int]], tables: Collection[str]) -> Layout:
    """Return the layout with the kept entries of lists, and with the tables of `there` in place of removed ones."""
    gone = {name for name in here.tables - there.tables if name in tables}
    entries = {name: tuple(here.orders[name][k] for k in own) for name, own in kept.items()}
    orders = {name: own for name, own in {**here.orders, **entries}.items() if own and name not in gone}
    laws = {name: law for name, law in here.laws.items() if name not in tables}
    laws |= {name: law for name, law in there.laws.items() if name in tables}
    return replace(here, orders=orders, laws=laws, tables=here.tables - gone)
