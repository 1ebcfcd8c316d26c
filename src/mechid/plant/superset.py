"""A mechanism extended by all terms that its blocks allow, each at its null value."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from sympy import Expr

from mechid.parameter import Parameter, Status
from mechid.plant.assembly import plant_of
from mechid.plant.block import Extension, Rival, Series
from mechid.plant.detent import period_name
from mechid.plant.law import Law
from mechid.plant.layout import Layout
from mechid.plant.mechanism import Mechanism
from mechid.plant.tables import LISTS, TABLES

MOST_PERIODS = 1000
"""Largest number of periods per turn in the name of an effect."""
WIDEST = 10.0
"""Largest value of a term, in widths: far beyond the reach of its narrow prior."""


@dataclass(frozen=True)
class Term:
    """An extension of a mechanism.

    Attributes
    ----------
    name : str
        Name of the term in a diagnosis, e.g. ``"stepper.detent:0.9deg"``.
    words : str
        Plain description of the effect for a report.
    widths : mapping of str to float
        Standard deviation about the null value of each free parameter, by dotted name.
    rarer : bool
        Whether it is tried only if the usual terms do not suffice.
    """

    name: str
    words: str
    widths: Mapping[str, float]
    rarer: bool = False


@dataclass(frozen=True)
class Superset:
    """A mechanism extended by all terms that its blocks allow.

    One plant serves every selection of free terms: the others stay at null values, without recompilation.

    Attributes
    ----------
    mechanism : Mechanism
        The given mechanism with all terms added, held at their null values.
    terms : tuple of Term
    """

    mechanism: Mechanism
    terms: tuple[Term, ...]

    @cached_property
    def widths(self) -> dict[str, float]:
        """Standard deviations of all terms' free parameters, by dotted name."""
        return {name: width for term in self.terms for name, width in term.widths.items()}

    def with_free_terms(self, names: Collection[str]) -> Mechanism:
        """Return the mechanism with the named terms free, at their null values."""
        freed: dict[str, Parameter] = {}
        for term in self.terms:
            if term.name in names:
                for name, width in term.widths.items():
                    freed |= dict(self._free(name, width, self._phases.get(name)))
        return self.mechanism.with_parameters(freed)

    @cached_property
    def term_of(self) -> dict[str, str]:
        """Name of the term of each parameter that its term frees, phases included, by dotted name."""
        with_phases = ((term, (name, self._phases.get(name))) for term in self.terms for name in term.widths)
        return {name: term.name for term, names in with_phases for name in names if name}

    @cached_property
    def _phases(self) -> dict[str, str]:
        return {pair.amplitude: pair.phase for pair in self.mechanism.plant.polar_pairs}

    def _free(self, name: str, width: float, phase: str | None) -> Iterator[tuple[str, Parameter]]:
        known = self.mechanism.parameters
        most = min(WIDEST * width, known[name].declaration.upper)
        # With a free phase a negative amplitude would describe the same wave twice.
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
    """Return the superset of a mechanism; None if no term can be added, or it has no layout.

    Parameters
    ----------
    mechanism : Mechanism
    grown_only : bool
        Include only the terms that growth frees from zero (`Extension.grown`).
    only : collection of str or None
        Include only the named terms.
    further : sequence of Extension
        Terms in addition to those that its blocks list.
    tables : collection of str
        Optional tables that the superset has in any case, with their defaults.
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
        f"{place}.{key}": _number(mechanism, e)
        for place, extension in zip(places, extensions, strict=True)
        for key, e in extension.structure.items()
    }
    terms = _merge_terms(_term(mechanism, *each) for each in zip(places, extensions, strict=True))
    return Superset(_lay_out(mechanism, wide, values), terms)


def with_tables(mechanism: Mechanism, tables: Collection[str]) -> Mechanism:
    """Return the mechanism with some optional tables added, at their defaults; itself if it has them all."""
    layout = mechanism.plant.layout
    if layout is None or layout.tables >= set(tables):
        return mechanism
    return _lay_out(mechanism, replace(layout, tables=layout.tables | set(tables)), {})


def extensions_at(mechanism: Mechanism, per_step: float, near: int) -> list[Extension]:
    """Return the extensions with a given number of periods per full step of the motor, and with neighbouring numbers.

    Parameters
    ----------
    mechanism : Mechanism
    per_step : float
        Periods per full step, as observed in a record; the number per turn is an integer.
    near : int
        Number of neighbours per turn, either way, that a record may not distinguish.

    Returns
    -------
    list of Extension
        Without those in the file or listed by a block; empty if one of these has the observed number of periods.
    """
    layout, found = mechanism.plant.layout, list[Extension]()
    if layout is None:
        return []
    listed = {_name(mechanism, e) for e in _extensions(mechanism, layout)}
    for series in (s for s in _series(mechanism) if s.is_line):
        seen = round(mechanism.per_quarter(per_step) / abs(float(series.per_step.subs(mechanism.by_symbol))))
        if seen < 1:
            continue
        if _is_there(mechanism, layout, series.entry(seen)) or _name(mechanism, series.entry(seen)) in listed:
            return []
        # The most likely numbers of periods come first.
        for periods in sorted(range(max(seen - near, 1), seen + near + 1), key=lambda n: abs(n - seen)):
            extension = series.entry(periods)
            if not (_is_there(mechanism, layout, extension) or _name(mechanism, extension) in listed):
                listed.add(_name(mechanism, extension))
                found.append(extension)
    return found


def unlisted_extensions(mechanism: Mechanism) -> dict[str, Extension]:
    """Return the extensions with any integer number of periods per turn, by name.

    Those in the file and those that growth frees anyway (`Extension.grown`) are left out, as are those whose number of
    periods changes the plant.
    """
    layout = mechanism.plant.layout
    if layout is None:
        return {}
    listed = {_name(mechanism, e) for e in _extensions(mechanism, layout) if e.grown}
    entries = (one.entry(number) for one in _series(mechanism) for number in range(1, one.most + 1))
    alike = [e for e in entries if e.order is None and not _is_there(mechanism, layout, e)]
    return {name: e for name, e in ((_name(mechanism, e), e) for e in alike) if name not in listed}


def extension_named(mechanism: Mechanism, name: str) -> Extension | None:
    """Return the extension of a given name from the blocks' series, or None."""
    entries = (one.entry(periods) for one in _series(mechanism) for periods in range(1, MOST_PERIODS + 1))
    return next((entry for entry in entries if _name(mechanism, entry) == name), None)


def _series(mechanism: Mechanism) -> Iterator[Series]:
    """Yield the series of all blocks whose turns the mechanism determines."""
    for series in (s for block in mechanism.plant.blocks for s in block.series):
        if _has_known_sizes(mechanism, [series.per_step]):
            yield series


def _is_there(mechanism: Mechanism, layout: Layout, extension: Extension) -> bool:
    """Return whether a mechanism has an entry with the structure of an extension."""
    shape = _shape(mechanism, extension)
    entries = (f"{extension.table}.{index}" for index in range(len(layout.orders.get(extension.table, ()))))
    return any(all(math.isclose(mechanism.value(f"{e}.{k}"), v) for k, v in shape.items()) for e in entries)


def rivals_of(mechanism: Mechanism, *, grown_only: bool = False) -> Iterator[Law]:
    """Yield the alternative laws and tables of a mechanism; with `grown_only`, those that growth tries."""
    layout = mechanism.plant.layout
    if layout is None:
        return
    for rival in _rivals(mechanism, layout):
        if rival.grown or not grown_only:
            other = _with_rival(mechanism, layout, rival)
            # Otherwise it would replace another law, whose parameters it drops; settings of the hardware may go.
            kept = {name for name, q in mechanism.parameters.items() if not q.declaration.structural}
            if kept <= other.parameters.keys():
                null = f"{rival.table}.{rival.null}" if rival.null else ""
                size = f"{rival.table}.{rival.size}" if rival.size else ""
                tries = ({f"{rival.table}.{key}": v} for key, values in rival.tried.items() for v in values)
                own = tuple(f"{rival.table}.{key}" for key in rival.free)
                yield Law(rival.name, other, rival.imitated_by, own, null, size, tuple(tries), rival.hides)


def words_of(mechanism: Mechanism) -> dict[str, str]:
    """Return the description of each term and law that may be added to a mechanism, by name."""
    layout = mechanism.plant.layout
    if layout is None:
        return {}
    terms = (_term(mechanism, e.table, e) for e in _extensions(mechanism, layout))
    return {t.name: t.words for t in terms} | {r.name: r.words for r in _rivals(mechanism, layout)}


def _extensions(mechanism: Mechanism, layout: Layout) -> Iterator[Extension]:
    """Yield the blocks' extensions, without present ones and those of unknown size (offsets of measured voltages)."""
    seen = set[tuple[str, str]]()
    for extension in (e for block in mechanism.plant.blocks for e in block.extensions):
        sizes = (*extension.structure.values(), *extension.widths.values())
        if (extension.law and extension.table in layout.own) or not _has_known_sizes(mechanism, sizes):
            continue
        # Wheels on one shaft have one order, and so may a wheel and a harmonic.
        one = extension.table, f"{_shape(mechanism, extension).get('order', 0.0):.9g}"
        by_value = extension.order is None and "order" in extension.structure
        if not by_value or not (one in seen or _is_there(mechanism, layout, extension)):
            seen.add(one)
            yield extension


def _rivals(mechanism: Mechanism, layout: Layout) -> Iterator[Rival]:
    """Yield the blocks' alternatives, without those present and those of undetermined size."""
    for rival in (r for block in mechanism.plant.blocks for r in block.rivals):
        limits = (e for each in rival.free.values() for e in each)
        is_new = rival.table not in layout.tables or (rival.law and layout.laws.get(rival.table) != rival.law)
        if rival.table not in layout.own and is_new and _has_known_sizes(mechanism, limits):
            yield rival


def _has_known_sizes(mechanism: Mechanism, sizes: Iterable[Expr]) -> bool:
    return all(e.free_symbols <= mechanism.by_symbol.keys() for e in sizes)


def _with_rival(mechanism: Mechanism, layout: Layout, rival: Rival) -> Mechanism:
    laws = {**layout.laws, **({rival.table: rival.law} if rival.law else {})}
    orders = {**layout.orders, **({rival.table: (rival.order,)} if rival.order else {})}
    wide = replace(layout, laws=laws, orders=orders, tables=layout.tables | _optional([rival]))
    known = {f"{rival.table}.{TABLES[rival.table].told_by}": float(rival.order)} if rival.order else {}
    other = _lay_out(mechanism, wide, known)
    freed = {}
    for key, limits in rival.free.items():
        name = f"{rival.table}.{key}"
        value, least, most = (_number(mechanism, e) for e in limits)
        freed[name] = replace(other.parameters[name], value=value, min=least, max=most, status=Status.FREE)
    return other.with_parameters(freed)


def _optional(some: Sequence[Extension | Rival]) -> frozenset[str]:
    """Return the optional tables among those of terms or laws."""
    return frozenset(each.table for each in some if TABLES[each.table].optional)


def _lay_out(mechanism: Mechanism, layout: Layout, values: Mapping[str, float]) -> Mechanism:
    """Return a mechanism in another layout: own parameters kept, new ones at a value, a default or 0, or tied."""
    plant, measured = plant_of(layout), tuple(mechanism.plant.outputs)
    plant = plant if tuple(plant.outputs) == measured else plant.with_outputs(measured)
    new = {
        name: Parameter(name=name, value=values.get(name, d.default or 0.0), declaration=d)
        for name, d in plant.declarations.items()
        if name not in mechanism.parameters
    }
    for name, master in plant.related_parameters("tied_to").items():
        if name in new and name not in values:
            new[name] = replace(new[name], value=mechanism.value(master), status=Status.TIED, tied_to=master)
    parameters = {name: mechanism.parameters.get(name) or new[name] for name in plant.declarations}
    before = mechanism.plant.layout.laws if mechanism.plant.layout else {}
    chosen = {f"{t}.{TABLES[t].option}": law for t, law in layout.laws.items() if before.get(t) != law}
    return Mechanism(plant, parameters, {**mechanism.options, **chosen})


def _place(orders: dict[str, tuple[int | None, ...]], extension: Extension) -> str:
    """Return the dotted name of an extension's table; an entry is appended to its list."""
    if extension.table not in LISTS:
        return extension.table
    listed: Sequence[int | None] = orders.get(extension.table, ())
    orders[extension.table] = (*listed, extension.order)
    return f"{extension.table}.{len(listed)}"


def _merge_terms(terms: Iterable[Term]) -> tuple[Term, ...]:
    """Merge the terms of the same name."""
    found: dict[str, Term] = {}
    for term in terms:
        before = found.get(term.name, term)
        found[term.name] = replace(term, widths={**before.widths, **term.widths})
    return tuple(found.values())


def _term(mechanism: Mechanism, place: str, extension: Extension) -> Term:
    widths = {f"{place}.{key}": abs(_number(mechanism, e)) for key, e in extension.widths.items()}
    values = {key: _number(mechanism, e) for key, e in extension.values.items()}
    words = extension.words.format(**_shape(mechanism, extension), **values)
    return Term(_name(mechanism, extension), words, widths, extension.rarer)


def _name(mechanism: Mechanism, extension: Extension) -> str:
    period = _shape(mechanism, extension).get("period_deg")
    return extension.name if period is None else f"{extension.name}:{period_name(period)}"


def _shape(mechanism: Mechanism, extension: Extension) -> dict[str, float]:
    return {key: _number(mechanism, e) for key, e in extension.structure.items()}


def _number(mechanism: Mechanism, expr: Expr) -> float:
    # Most are numbers, of which there are a thousand; a substitution takes milliseconds.
    return float(expr if expr.is_Number else expr.subs(mechanism.by_symbol))
