"""A mechanism with the terms beside that its blocks say a real one may have, each at its null value."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from sympy import Expr

from mechid.parameter import Parameter, Status
from mechid.plant.assembly import plant_of
from mechid.plant.block import Extension, Rival, Series
from mechid.plant.law import Law
from mechid.plant.layout import Layout
from mechid.plant.mechanism import Mechanism
from mechid.plant.tables import LISTS, TABLES

MOST_PERIODS = 1000
"""In a turn, that an effect is called by."""
WIDEST = 10.0
"""Widths that a term may reach: far from where its small prior lets it go."""


@dataclass(frozen=True)
class Term:
    """An extension in a mechanism.

    Attributes
    ----------
    name : str
        As diagnosis calls it, e.g. ``"stepper.detent:0.9deg"``.
    words : str
        What the effect is, in a plain phrase for a report.
    widths : mapping of str to float
        Its parameters that are free, by dotted name, and the standard deviation of each about its null value.
    rarer : bool
        Whether it is looked for only where the usual ones do not suffice.
    """

    name: str
    words: str
    widths: Mapping[str, float]
    rarer: bool = False


@dataclass(frozen=True)
class Superset:
    """A mechanism and all terms that its blocks may have beside.

    One plant for all of them, whichever are free: those that are not stay at their null value, and nothing is compiled
    anew.

    Attributes
    ----------
    mechanism : Mechanism
        As written, with all terms beside, at their null values and held there.
    terms : tuple of Term
    """

    mechanism: Mechanism
    terms: tuple[Term, ...]

    @cached_property
    def widths(self) -> dict[str, float]:
        """Standard deviations of all terms' free parameters, by dotted name."""
        return {name: width for term in self.terms for name, width in term.widths.items()}

    def freeing(self, names: Collection[str]) -> Mechanism:
        """Return the mechanism with the terms of some names free from their null values."""
        freed: dict[str, Parameter] = {}
        for term in self.terms:
            if term.name in names:
                for name, width in term.widths.items():
                    freed |= dict(self._free(name, width, self._phases.get(name)))
        return self.mechanism.with_parameters(freed)

    @cached_property
    def term_of(self) -> dict[str, str]:
        """The term of each parameter that its term frees, phases among them, by dotted name."""
        with_phases = ((term, (name, self._phases.get(name))) for term in self.terms for name in term.widths)
        return {name: term.name for term, names in with_phases for name in names if name}

    @cached_property
    def _phases(self) -> dict[str, str]:
        return {pair.amplitude: pair.phase for pair in self.mechanism.plant.polar_pairs}

    def _free(self, name: str, width: float, phase: str | None) -> Iterator[tuple[str, Parameter]]:
        known = self.mechanism.parameters
        most = min(WIDEST * width, known[name].declaration.upper)
        least = 0.0 if phase else max(-most, known[name].declaration.lower)
        yield name, replace(known[name], status=Status.FREE, min=least, max=most)
        if phase:
            yield phase, replace(known[phase], status=Status.FREE, min=-180.0, max=180.0)


def superset_of(
    mechanism: Mechanism,
    *,
    grown_only: bool = False,
    only: Collection[str] | None = None,
    further: Sequence[Extension] = (),
    tables: Collection[str] = (),
) -> Superset | None:
    """Return the superset of a mechanism; None where nothing can be beside it, or no file laid it out.

    Parameters
    ----------
    mechanism : Mechanism
    grown_only : bool
        Of the terms alone that growth frees from nothing (`Extension.grown`).
    only : collection of str or None
        Of those named.
    further : sequence of Extension
        Beside those that its blocks list.
    tables : collection of str
        Optional tables that its mechanism has in any case, with their defaults.
    """
    layout = mechanism.plant.layout
    if layout is None:
        return None
    listed = [e for e in _extensions(mechanism, layout) if e.grown or not grown_only]
    named = {_name(mechanism, e) for e in listed}
    every = (*listed, *(e for e in further if _name(mechanism, e) not in named))
    extensions = [e for e in every if only is None or _name(mechanism, e) in only]
    if not extensions:
        return None
    orders, places = dict(layout.orders), []
    for extension in extensions:
        places.append(_place(orders, extension))
    laws = {**layout.laws, **{e.table: e.law for e in extensions if e.law}}
    wide = replace(layout, orders=orders, laws=laws, tables=layout.tables | _optional(extensions) | frozenset(tables))
    values = {
        f"{place}.{key}": float(e.subs(mechanism.by_symbol))
        for place, extension in zip(places, extensions, strict=True)
        for key, e in extension.structure.items()
    }
    terms = _joined(_term(mechanism, *each) for each in zip(places, extensions, strict=True))
    return Superset(_laid_out(mechanism, wide, values), terms)


def with_tables(mechanism: Mechanism, tables: Collection[str]) -> Mechanism:
    """Return a mechanism that has some optional tables too, with their defaults; itself where it has them all."""
    layout = mechanism.plant.layout
    if layout is None or layout.tables >= set(tables):
        return mechanism
    return _laid_out(mechanism, replace(layout, tables=layout.tables | set(tables)), {})


def extensions_at(mechanism: Mechanism, per_step: float, near: int) -> list[Extension]:
    """Return what blocks may have beside with some periods per full step of the motor, and with a few more or fewer.

    Parameters
    ----------
    mechanism : Mechanism
    per_step : float
        Periods in a full step, as seen in a record: a turn has a whole number of them.
    near : int
        How many more and fewer in a turn a record may not tell from these.

    Returns
    -------
    list of Extension
        None of those that are in a file or listed by a block; nothing where one of these has the periods seen.
    """
    layout, found = mechanism.plant.layout, list[Extension]()
    if layout is None:
        return []
    listed = {_name(mechanism, e) for e in _extensions(mechanism, layout)}
    for series in (s for s in _series(mechanism) if s.is_line):
        seen = round(per_step / abs(float(series.per_step.subs(mechanism.by_symbol))))
        if seen < 1:
            continue
        if _is_there(mechanism, layout, series.entry(seen)) or _name(mechanism, series.entry(seen)) in listed:
            return []
        for periods in sorted(range(max(seen - near, 1), seen + near + 1), key=lambda n: abs(n - seen)):
            extension = series.entry(periods)
            if not (_is_there(mechanism, layout, extension) or _name(mechanism, extension) in listed):
                listed.add(_name(mechanism, extension))
                found.append(extension)
    return found


def unlisted_extensions(mechanism: Mechanism) -> dict[str, Extension]:
    """Return what blocks may have beside with any whole number of periods in a turn, by its name.

    None of those that are in the file, or that growth frees anyway (`Extension.grown`); and of those alone that lay out
    as one and the same plant, whatever their number of periods is.
    """
    layout = mechanism.plant.layout
    if layout is None:
        return {}
    listed = {_name(mechanism, e) for e in _extensions(mechanism, layout) if e.grown}
    entries = (one.entry(number) for one in _series(mechanism) for number in range(1, one.most + 1))
    alike = [e for e in entries if e.order is None and not _is_there(mechanism, layout, e)]
    return {name: e for name, e in ((_name(mechanism, e), e) for e in alike) if name not in listed}


def extension_named(mechanism: Mechanism, name: str) -> Extension | None:
    """Return what blocks may have beside beyond what they list, by its name; None where nothing is called so."""
    entries = (one.entry(periods) for one in _series(mechanism) for periods in range(1, MOST_PERIODS + 1))
    return next((entry for entry in entries if _name(mechanism, entry) == name), None)


def _series(mechanism: Mechanism) -> Iterator[Series]:
    """Yield the series of all blocks whose turns the mechanism sizes."""
    for series in (s for block in mechanism.plant.blocks for s in block.series):
        if _known(mechanism, [series.per_step]):
            yield series


def _is_there(mechanism: Mechanism, layout: Layout, extension: Extension) -> bool:
    """Tell whether a mechanism has an entry of the shape of an extension."""
    shape = _shape(mechanism, extension)
    entries = (f"{extension.table}.{index}" for index in range(len(layout.orders.get(extension.table, ()))))
    return any(all(math.isclose(mechanism.value(f"{e}.{k}"), v) for k, v in shape.items()) for e in entries)


def rivals_of(mechanism: Mechanism, *, grown_only: bool = False) -> Iterator[Law]:
    """Yield the laws and tables that may stand in place of what a mechanism has.

    With `grown_only` those alone that growth tries (`Rival.grown`).
    """
    layout = mechanism.plant.layout
    if layout is None:
        return
    for rival in _rivals(mechanism, layout):
        if rival.grown or not grown_only:
            other = _with_rival(mechanism, layout, rival)
            if mechanism.parameters.keys() <= other.parameters.keys():  # else it would take another law's place
                null = f"{rival.table}.{rival.null}" if rival.null else ""
                tries = ({f"{rival.table}.{key}": v} for key, values in rival.tried.items() for v in values)
                own = tuple(f"{rival.table}.{key}" for key in rival.free)
                yield Law(rival.name, other, rival.imitated_by, own, null, tuple(tries), rival.hides)


def words_of(mechanism: Mechanism) -> dict[str, str]:
    """Return what each term and law that may stand beside a mechanism is in words, by its name."""
    layout = mechanism.plant.layout
    if layout is None:
        return {}
    terms = (_term(mechanism, e.table, e) for e in _extensions(mechanism, layout))
    return {t.name: t.words for t in terms} | {r.name: r.words for r in _rivals(mechanism, layout)}


def _extensions(mechanism: Mechanism, layout: Layout) -> Iterator[Extension]:
    """Yield what blocks may have beside, less what it has and does not size (offsets of measured voltages)."""
    for extension in (e for block in mechanism.plant.blocks for e in block.extensions):
        sizes = (*extension.structure.values(), *extension.widths.values())
        of_own = extension.law and extension.table in layout.own
        is_there = TABLES[extension.table].by_value and _is_there(mechanism, layout, extension)
        if not (of_own or is_there) and _known(mechanism, sizes):
            yield extension


def _rivals(mechanism: Mechanism, layout: Layout) -> Iterator[Rival]:
    """Yield what may stand in place of something, likewise."""
    for rival in (r for block in mechanism.plant.blocks for r in block.rivals):
        limits = (e for each in rival.free.values() for e in each)
        if rival.table not in layout.own and rival.table not in layout.tables and _known(mechanism, limits):
            yield rival


def _known(mechanism: Mechanism, sizes: Iterable[Expr]) -> bool:
    return all(e.free_symbols <= mechanism.by_symbol.keys() for e in sizes)


def _with_rival(mechanism: Mechanism, layout: Layout, rival: Rival) -> Mechanism:
    laws = {**layout.laws, **({rival.table: rival.law} if rival.law else {})}
    orders = {**layout.orders, **({rival.table: (rival.order,)} if rival.order else {})}
    wide = replace(layout, laws=laws, orders=orders, tables=layout.tables | _optional([rival]))
    known = {f"{rival.table}.{TABLES[rival.table].told_by}": float(rival.order)} if rival.order else {}
    other = _laid_out(mechanism, wide, known)
    freed = {}
    for key, limits in rival.free.items():
        name = f"{rival.table}.{key}"
        value, least, most = (float(e.subs(mechanism.by_symbol)) for e in limits)
        freed[name] = replace(other.parameters[name], value=value, min=least, max=most, status=Status.FREE)
    return other.with_parameters(freed)


def _optional(some: Sequence[Extension | Rival]) -> frozenset[str]:
    """Return the optional tables among those that terms or laws stand in."""
    return frozenset(each.table for each in some if TABLES[each.table].optional)


def _laid_out(mechanism: Mechanism, layout: Layout, values: Mapping[str, float]) -> Mechanism:
    """Return a mechanism in another layout: its own parameters, and what is new at a value, a default or 0, or tied."""
    plant, measured = plant_of(layout), tuple(mechanism.plant.outputs)
    plant = plant if tuple(plant.outputs) == measured else plant.measuring(measured)
    new = {
        name: Parameter(name=name, value=values.get(name, d.default or 0.0), declaration=d)
        for name, d in plant.declarations.items()
        if name not in mechanism.parameters
    }
    for name, master in plant.related("tied_to").items():
        if name in new and name not in values:
            new[name] = replace(new[name], value=mechanism.value(master), status=Status.TIED, tied_to=master)
    parameters = {name: mechanism.parameters.get(name) or new[name] for name in plant.declarations}
    before = mechanism.plant.layout.laws if mechanism.plant.layout else {}
    chosen = {f"{t}.{TABLES[t].option}": law for t, law in layout.laws.items() if before.get(t) != law}
    return Mechanism(plant, parameters, {**mechanism.options, **chosen})


def _place(orders: dict[str, tuple[int | None, ...]], extension: Extension) -> str:
    """Return the dotted name of the table that an extension stands in; an entry is appended to its list."""
    if extension.table not in LISTS:
        return extension.table
    listed: Sequence[int | None] = orders.get(extension.table, ())
    orders[extension.table] = (*listed, extension.order)
    return f"{extension.table}.{len(listed)}"


def _joined(terms: Iterable[Term]) -> tuple[Term, ...]:
    """Return the terms, those of one name as one."""
    found: dict[str, Term] = {}
    for term in terms:
        before = found.get(term.name, term)
        found[term.name] = replace(term, widths={**before.widths, **term.widths})
    return tuple(found.values())


def _term(mechanism: Mechanism, place: str, extension: Extension) -> Term:
    widths = {f"{place}.{key}": abs(float(e.subs(mechanism.by_symbol))) for key, e in extension.widths.items()}
    words = extension.words.format(**_shape(mechanism, extension))
    return Term(_name(mechanism, extension), words, widths, extension.rarer)


def _name(mechanism: Mechanism, extension: Extension) -> str:
    period = _shape(mechanism, extension).get("period_deg")
    return extension.name if period is None else f"{extension.name}:{period_name(period)}"


def period_name(period_deg: float) -> str:
    """Return a period as names have it: with three digits, or as many as tell its whole number of periods in a turn.

    Examples
    --------
    >>> period_name(1.2), period_name(360.0 / 301.0), period_name(360.0 / 350.0)
    ('1.2deg', '1.196deg', '1.03deg')
    """
    periods = round(360.0 / period_deg)
    texts = (f"{period_deg:.{digits}g}" for digits in range(3, 7))
    told = next((text for text in texts if round(360.0 / float(text)) == periods), f"{period_deg:.3g}")
    return f"{told}deg"


def _shape(mechanism: Mechanism, extension: Extension) -> dict[str, float]:
    return {key: float(e.subs(mechanism.by_symbol)) for key, e in extension.structure.items()}
