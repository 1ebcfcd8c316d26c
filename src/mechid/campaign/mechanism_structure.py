"""What of a mechanism file shapes the equations: assembly, detent harmonics, form of the housing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import sympy as sp

from mechid.campaign.place import Place, found, is_table_list, text
from mechid.command.entry import is_number, is_table
from mechid.errors import InputFileError
from mechid.plant.assembly import STEPPER_GEAR_MASS, check_assembly, stepper_gear_mass
from mechid.plant.plant import Plant

ASSEMBLY = "assembly"
HOUSING_FORM = "housing.form"
DETENT_TABLE = "stepper.detent"
POLES_TABLE, POLES_KEY, PERIOD_KEY = "stepper", "poles", "period_deg"
WHOLE_ORDER = 1e-9
"""How near a whole number, relative to it, the periods per electrical period are taken for it."""


@dataclass(frozen=True)
class Structure:
    """The plant that a file asks for, and the options it names.

    Attributes
    ----------
    plant : Plant
    options : mapping of str to str
        ``assembly``, and ``housing.form`` where there is a housing.
    """

    plant: Plant
    options: Mapping[str, str] = field(default_factory=dict)


def read_structure(table: Mapping[str, Any], place: Place) -> Structure:
    """Return the structure that a mechanism file has.

    Numbers that are missing or wrong are passed over here: the parameters' own reading says so.

    Raises
    ------
    InputFileError
        The assembly or the housing's form is unknown, or the detents are no list of tables.
    """
    options = {ASSEMBLY: _assembly(table, place)}
    if is_table(table.get("housing")):
        options[HOUSING_FORM] = _housing_form(table["housing"], place)
    orders = [detent_order(_poles(table), detent.get(PERIOD_KEY)) for detent in _detents(table, place)]
    form = options.get(HOUSING_FORM)
    with _in_file(place):
        return Structure(stepper_gear_mass(orders, form), options)


def detent_order(poles: Any, period_deg: Any) -> int | None:
    """Return a detent's periods per electrical period, None where that is no whole number.

    An electrical period is 720/poles degrees of the rotor.

    Examples
    --------
    >>> detent_order(100, 1.8), detent_order(100, 3.6), detent_order(100, 2.5)
    (4, 2, None)
    """
    if not (is_number(poles) and is_number(period_deg)) or poles <= 0 or period_deg <= 0:
        return None
    order = (720.0 / poles) / period_deg
    whole = round(order)
    return whole if whole >= 1 and abs(order - whole) <= WHOLE_ORDER * whole else None


@lru_cache(maxsize=32)
def divisors(plant: Plant) -> frozenset[str]:
    """Return the dotted names of the parameters that the equations divide by."""
    expressions = map(sp.sympify, (*(e for _, e in plant.terms), *plant.rates, *plant.initial))
    powers = {power for e in expressions for power in e.atoms(sp.Pow) if power.exp.is_negative}
    symbols = {symbol.name for power in powers for symbol in power.base.free_symbols}
    return frozenset(name for name, d in plant.declarations.items() if d.symbol in symbols)


def _assembly(table: Mapping[str, Any], place: Place) -> str:
    remedy = f'write {ASSEMBLY} = "{STEPPER_GEAR_MASS}", or leave it out'
    name = text(table.get(ASSEMBLY, STEPPER_GEAR_MASS), place.key(ASSEMBLY), remedy)
    with _in_file(place):
        check_assembly(name)
    return name


def _housing_form(housing: Mapping[str, Any], place: Place) -> str:
    return text(housing.get("form", "paper"), place.key(HOUSING_FORM), 'write form = "paper", or leave it out')


def _poles(table: Mapping[str, Any]) -> Any:
    stepper = table.get(POLES_TABLE)
    return stepper.get(POLES_KEY) if isinstance(stepper, Mapping) else None


def _detents(table: Mapping[str, Any], place: Place) -> list[Mapping[str, Any]]:
    stepper = table.get(POLES_TABLE)
    detents = stepper.get("detent", []) if isinstance(stepper, Mapping) else []
    if not is_table_list(detents):
        raise place.key(DETENT_TABLE).error(
            f"{found(detents)}; write each harmonic as a table under [[{DETENT_TABLE}]], in two brackets"
        )
    return list(detents)


@contextmanager
def _in_file(place: Place) -> Iterator[None]:
    """Put the file in front of what the plant refuses."""
    try:
        yield
    except InputFileError as error:
        raise place.error(str(error)) from error
