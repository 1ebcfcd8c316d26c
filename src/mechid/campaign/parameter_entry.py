"""Reader of a parameter entry: a bare number is a known value, a table is an estimated parameter."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from mechid.campaign.place import Place, in_unit, number, refuse_unknown_keys, required_entry
from mechid.command.entry import is_table
from mechid.parameter import Declaration, Parameter, Status

KEYS = ("value", "min", "max", "sigma")
SURE = 1e-12
"""Least standard deviation of a prior relative to its value."""
HALF_TURN_DEG = 180.0
REMEDY = "write { value = ..., min = ..., max = ... }"


def read_parameter(
    entry: Any, name: str, declaration: Declaration, place: Place, *, divides: bool = False
) -> Parameter:
    """Make a parameter from an entry of a file.

    Parameters
    ----------
    entry : number or table
        Value in the unit of `declaration`.
    name : str
        Dotted name.
    declaration : Declaration
    place : Place
        Place of the entry.
    divides : bool
        Whether the equations divide by the parameter, which then must not be 0.

    Raises
    ------
    InputFileError
        The entry has the wrong type, or a value or bound is impossible.
    """
    if not is_table(entry):
        value = _read_within_limits(entry, declaration, place)
        parameter = Parameter(name=name, value=value, declaration=declaration)
    elif declaration.structural:
        reason = "it fixes the equations and cannot be estimated"
        raise place.error(f"found a table; {reason}: write the number alone{in_unit(declaration.unit)}")
    else:
        parameter = _read_estimated(entry, name, declaration, place)
    if divides:
        _refuse_zero(parameter, place)
    return parameter


def _read_estimated(table: Mapping[str, Any], name: str, declaration: Declaration, place: Place) -> Parameter:
    refuse_unknown_keys(table, KEYS, place)
    value = _read_within_limits(required_entry(table, "value", place, REMEDY), declaration, place.key("value"))
    low, high = _read_bounds(table, declaration, place)
    parameter = Parameter(
        name=name,
        value=value,
        declaration=declaration,
        min=low,
        max=high,
        sigma=_sigma(table, value, declaration, place),
        status=Status.FREE,
    )
    if not parameter.is_periodic:
        _refuse_outside(parameter, place)
    return parameter


def _read_bounds(table: Mapping[str, Any], declaration: Declaration, place: Place) -> tuple[float, float]:
    """Return min and max, by default the physical limits, or a full turn for an angle."""
    limits = {"min": declaration.lower, "max": declaration.upper}
    if declaration.unit == "deg" and not {"min", "max"} & table.keys():
        return _turn(declaration)
    low, high = (_read_bound(table, key, limit, declaration, place) for key, limit in limits.items())
    if low == high:
        raise place.error(f"min and max are both {low:.9g}; write the number alone where it is known")
    if low > high:
        raise place.error(f"min = {low:.9g} is above max = {high:.9g}; exchange them")
    return low, high


def _read_bound(table: Mapping[str, Any], key: str, limit: float, declaration: Declaration, place: Place) -> float:
    if key in table:
        return _read_within_limits(table[key], declaration, place.key(key))
    if math.isinf(limit):
        raise place.key(key).error(f"missing, and {declaration.meaning} has no physical limit there; {REMEDY}")
    return limit


def _turn(declaration: Declaration) -> tuple[float, float]:
    low, high = declaration.lower, declaration.upper
    return (low, high) if math.isfinite(high - low) else (-HALF_TURN_DEG, HALF_TURN_DEG)


def _sigma(table: Mapping[str, Any], value: float, declaration: Declaration, place: Place) -> float | None:
    if "sigma" not in table:
        return None
    sigma = number(table["sigma"], place.key("sigma"), declaration.unit)
    if sigma <= 0.0:
        raise place.key("sigma").error(
            f"found {sigma:.9g}; write the prior's standard deviation, above 0, or leave it out"
        )
    if sigma < SURE * abs(value):
        raise place.key("sigma").error(
            f"found {sigma:.9g}, which is lost in rounding beside {value:.9g}; write {value:.9g} alone, a known value"
        )
    return sigma


def _read_within_limits(entry: Any, declaration: Declaration, place: Place) -> float:
    """Read a number and check it against the physical limits."""
    value = number(entry, place, declaration.unit)
    if declaration.lower <= value <= declaration.upper:
        return value
    low = value < declaration.lower
    limit = f"below {declaration.lower:.9g}" if low else f"above {declaration.upper:.9g}"
    unit = "" if declaration.unit == "1" else f" {declaration.unit}"
    reason = f"{declaration.meaning} cannot be {limit}{unit}"
    raise place.error(f"found {value:.9g}; {reason}")


def _refuse_outside(parameter: Parameter, place: Place) -> None:
    """Refuse an initial value outside the bounds; a value on a bound is legal."""
    value = parameter.value
    if parameter.min <= value <= parameter.max:
        return
    side, bound = ("below min", parameter.min) if value < parameter.min else ("above max", parameter.max)
    remedy = f"start within the bounds or move them{_as_hertz(parameter)}"
    raise place.error(f"value = {value:.9g} is {side} = {bound:.9g}; {remedy}")


def _as_hertz(parameter: Parameter) -> str:
    """Suggest a conversion if a value below the bounds in rad/s fits them as Hz."""
    angular = 2.0 * math.pi * parameter.value
    if parameter.declaration.unit != "rad/s" or not parameter.min <= angular <= parameter.max:
        return ""
    return f"; is it in Hz? it is read in rad/s, write {angular:.6g}"


def _refuse_zero(parameter: Parameter, place: Place) -> None:
    remedy = "the equations divide by it"
    if parameter.value == 0.0:
        raise place.error(f"found 0; {remedy}, write another number")
    if parameter.is_free and parameter.min < 0.0 < parameter.max:
        raise place.error(f"0 lies between min = {parameter.min:.9g} and max = {parameter.max:.9g}; {remedy}")
