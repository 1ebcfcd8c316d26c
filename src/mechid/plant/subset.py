"""A mechanism without some of what it has beside another one: the other way round than a superset."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace

from mechid.plant.assembly import plant_of
from mechid.plant.layout import Layout
from mechid.plant.mechanism import Mechanism
from mechid.plant.tables import LISTS


def nulls_of(mechanism: Mechanism, names: Iterable[str]) -> dict[str, float]:
    """Return where there is nothing of an extension's parameters, by dotted name, in the file's units.

    Phases are left out: where an amplitude is 0 they do not count.
    """
    phases = {pair.phase for pair in mechanism.plant.polar_pairs}
    declared = mechanism.plant.declarations
    return {name: declared[name].default or 0.0 for name in names if name not in phases}


def subset_of(mechanism: Mechanism, base: Mechanism, tables: Collection[str]) -> Mechanism:
    """Return a mechanism without some tables, or with those of another one in their place.

    Parameters
    ----------
    mechanism : Mechanism
        Has all tables that `base` has; of a list first those entries.
    base : Mechanism
        Whose laws and tables stay where they are named; both are laid out by a file.
    tables : collection of str
        Dotted names of tables, ``"stepper.imbalance"``, and of entries of lists, ``"stepper.detent.2"``. Entries behind
        one that goes move up.
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
    """Return the layout with the entries of lists that are kept, and of other tables that go what `there` has."""
    gone = {name for name in here.tables - there.tables if name in tables}
    entries = {name: tuple(here.orders[name][k] for k in own) for name, own in kept.items()}
    orders = {name: own for name, own in {**here.orders, **entries}.items() if own and name not in gone}
    laws = {name: law for name, law in here.laws.items() if name not in tables}
    laws |= {name: law for name, law in there.laws.items() if name in tables}
    return replace(here, orders=orders, laws=laws, tables=here.tables - gone)
