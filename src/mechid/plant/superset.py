"""A mechanism with the terms beside that its blocks say a real one may have, each at its null value."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from mechid.parameter import Parameter, Status
from mechid.plant.assembly import plant_of
from mechid.plant.block import Extension
from mechid.plant.mechanism import Mechanism
from mechid.plant.tables import LISTS

WIDEST = 10.0
"""Widths that a term may reach: far from where its small prior lets it go."""


@dataclass(frozen=True)
class Term:
    """An extension in a mechanism.

    Attributes
    ----------
    name : str
        As diagnosis calls it, e.g. ``"stepper.detent:0.9deg"``.
    widths : mapping of str to float
        Its parameters that are free, by dotted name, and the standard deviation of each about its null value.
    """

    name: str
    widths: Mapping[str, float]


@dataclass(frozen=True)
class Superset:
    """A mechanism and all terms that its blocks may have beside.

    One plant for all of them, whichever are free: those that are not stay at their null value, and nothing is compiled
    anew.

    Attributes
    ----------
    plain : Mechanism
        As written.
    mechanism : Mechanism
        The same with all terms beside, at their null values and held there.
    terms : tuple of Term
    """

    plain: Mechanism
    mechanism: Mechanism
    terms: tuple[Term, ...]

    @cached_property
    def widths(self) -> dict[str, float]:
        """Standard deviations of all terms' free parameters, by dotted name."""
        return {name: width for term in self.terms for name, width in term.widths.items()}

    def freeing(self, names: Collection[str]) -> Mechanism:
        """Return the mechanism with the terms of some names free from their null values."""
        pairs = {pair.amplitude: pair.phase for pair in self.mechanism.plant.polar_pairs}
        freed = {}
        for term in self.terms:
            if term.name in names:
                for name, width in term.widths.items():
                    freed |= dict(self._free(name, width, pairs.get(name)))
        return self.mechanism.with_parameters(freed)

    def _free(self, name: str, width: float, phase: str | None) -> Iterator[tuple[str, Parameter]]:
        known, most = self.mechanism.parameters, WIDEST * width
        least = 0.0 if phase else max(-most, known[name].declaration.lower)
        yield name, replace(known[name], status=Status.FREE, min=least, max=most)
        if phase:
            yield phase, replace(known[phase], status=Status.FREE, min=-180.0, max=180.0)


def superset_of(mechanism: Mechanism) -> Superset | None:
    """Return the superset of a mechanism; None where nothing can be beside it, or no file laid it out."""
    layout = mechanism.plant.layout
    extensions = [e for block in mechanism.plant.blocks for e in block.extensions]
    if layout is None or not extensions:
        return None
    orders, places = dict(layout.orders), []
    for extension in extensions:
        places.append(_place(orders, extension))
    tables = layout.tables | {e.table for e in extensions if e.table not in LISTS}
    plant = plant_of(replace(layout, orders=orders, tables=tables))
    values = {
        f"{place}.{key}": float(e.subs(mechanism.by_symbol))
        for place, extension in zip(places, extensions, strict=True)
        for key, e in extension.structure.items()
    }
    parameters = {
        name: mechanism.parameters.get(name)
        or Parameter(name=name, value=values.get(name, d.default or 0.0), declaration=d)
        for name, d in plant.declarations.items()
    }
    whole = Mechanism(plant, parameters, mechanism.options)
    terms = tuple(_term(mechanism, *each) for each in zip(places, extensions, strict=True))
    return Superset(mechanism, whole, terms)


def _place(orders: dict[str, tuple[int | None, ...]], extension: Extension) -> str:
    """Return the dotted name of the table that an extension stands in; an entry is appended to its list."""
    if extension.table not in LISTS:
        return extension.table
    listed: Sequence[int | None] = orders.get(extension.table, ())
    orders[extension.table] = (*listed, extension.order)
    return f"{extension.table}.{len(listed)}"


def _term(mechanism: Mechanism, place: str, extension: Extension) -> Term:
    values = {key: float(e.subs(mechanism.by_symbol)) for key, e in extension.structure.items()}
    period = f":{values['period_deg']:.3g}deg" if "period_deg" in values else ""
    widths = {f"{place}.{key}": abs(float(e.subs(mechanism.by_symbol))) for key, e in extension.widths.items()}
    return Term(f"{extension.name}{period}", widths)
