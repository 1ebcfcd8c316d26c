"""Conversion factors to SI from units as engineers write them; ambiguous units are rejected with both meanings."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from mechid.errors import RecordError
from mechid.units.closed_list import SPELLED_OUT, unit_names, unit_registry
from mechid.units.quantities import FORCES, RATES, SI_UNIT, TORQUES, si_unit

if TYPE_CHECKING:
    from pint import Unit, UnitRegistry

_GERMAN_DEGREE = "Grad"
_AS_FORCE: Mapping[str, str] = {"kg": "kgf", "g": "gf", "lb": "lbf", "oz": "ozf"}
"""Mass units that denote the corresponding weight in torques and forces, as in kg cm, oz in and in lb."""
_RUN_TOGETHER = re.compile(r"([numcdk]?N|kgf?|kp)([mc]?m)|(gf?)([mc]m)|(ozf?|lbf?)(in|ft)|(in|ft)(ozf?|lbf?|lbs)")
"""Torque units without an operator between force and length, such as Nm, kgcm, ozin and ftlb."""
_SIGNS = str.maketrans(
    {
        **dict.fromkeys("·⋅∙•‧×", "*"),
        **dict.fromkeys("µμ", "u"),
        "°": "deg",
        "−": "-",
        "⁻": "-",
        "¹": "1",
        "²": "2",
        "³": "3",
    }
)
_BETWEEN = re.compile(r"(?<=[A-Za-z])(?:\s*[.* -]\s*)+(?=[A-Za-z(])|(?<=\))\s*\*?\s*(?=[A-Za-z(])")
_EXPONENT = re.compile(r"(?<=[A-Za-z)])\s*(?:\^|\*\*)?\s*(-?\d+(?:\.\d+)?)")
_PLAIN = re.compile(r"[A-Za-z0-9*/^(). -]{1,40}")
_POWER_OF_NUMBER = re.compile(r"[0-9).]\s*(?:\^|\*\s*\*)")
_PER_MINUTE = ("1/min", "/min", "min^-1")


def to_si_factor(unit: str, quantity: str) -> float:
    """Return the factor that converts a value in `unit` to the SI unit of `quantity`.

    Parameters
    ----------
    unit : str
        In common engineering notation: ``"N*m"``, ``"Nm"``, ``"mN.m"``, ``"oz-in"``, ``"deg"``, ``"U/min"``, ``"us"``.
    quantity : str
        One of the keys of `SI_UNIT`.

    Raises
    ------
    RecordError
        The quantity or the unit is unknown, the unit does not measure the quantity, or the unit is ambiguous.

    Examples
    --------
    >>> to_si_factor("mNm", "torque")
    0.001
    >>> to_si_factor("rpm", "rotor_rate")
    0.10471975511965977
    """
    expected = si_unit(quantity)
    spelling = _normalise(unit, quantity)
    return 1.0 if spelling == expected else _factor(spelling, unit, quantity)


def is_unit(text: str) -> bool:
    """Return whether a text is a unit of a supported quantity; ambiguous units count.

    Examples
    --------
    >>> is_unit("N m"), is_unit("us"), is_unit("grad"), is_unit("torque")
    (True, True, True, False)
    """
    if _doubt(text) is not None or any(_normalise(text, quantity) == si for quantity, si in SI_UNIT.items()):
        return True
    words = re.findall(r"[A-Za-z]+", _normalise(text))
    # This runs on every header: the cheap look-up comes first, so that Pint is loaded for texts of known units only.
    return bool(words) and all(map(_is_listed, words)) and any(measures(text, quantity) for quantity in SI_UNIT)


def measures(unit: str, quantity: str) -> bool:
    """Return whether a unit measures a quantity.

    Examples
    --------
    >>> measures("oz in", "torque"), measures("ms", "torque")
    (True, False)
    """
    try:
        to_si_factor(unit, quantity)
    except RecordError:
        return False
    return True


def conversion_factor(unit: str, to: str) -> float | None:
    """Return the factor that converts a value in `unit` to `to`, or None if their dimensions differ.

    Use it for units that belong to no channel of a record, such as those of a transfer function.

    Examples
    --------
    >>> conversion_factor("urad/(N*m)", "rad/(N*m)")
    1e-06
    >>> conversion_factor("rad/N", "rad/(N*m)") is None
    True
    """
    spelling = _normalise(unit)
    if spelling == to:
        return 1.0
    parsed, expected = _parse(spelling), _parse(_normalise(to))
    if parsed is None or expected is None or not parsed.is_compatible_with(expected):
        return None
    return float(unit_registry().Quantity(1.0, parsed).to(expected).magnitude)


def time_power(unit: str) -> float | None:
    """Return the exponent of time in a parameter's unit expressed in N, m and s, or None if the unit is unknown.

    Blocks declare their units in code, so all units of Pint's default registry are accepted.

    Examples
    --------
    >>> time_power("kg*m^2"), time_power("N m s/rad"), time_power("ohm")
    (2.0, 1.0, -1.0)
    """
    try:
        powers: Mapping[str, Any] = _all_units().parse_units(_normalise(unit)).dimensionality
    # Errors of Pint's parser have no common base class: malformed input raises AttributeError, TypeError and others.
    except Exception:
        return None
    # A newton is kg m/s^2, so each power of mass adds two powers of time when newton replaces kilogram.
    return float(powers.get("[time]", 0)) + 2.0 * float(powers.get("[mass]", 0))


@lru_cache(maxsize=1)
def _all_units() -> UnitRegistry[float]:
    import pint

    return pint.UnitRegistry()


def _normalise(unit: str, quantity: str | None = None) -> str:
    """Return a unit in canonical notation: ``*`` for products, ``^`` for powers, and names of the closed list."""
    text = re.sub(r"\s+per\s+", "/", unit.strip().translate(_SIGNS))
    # Abbreviations may end in a full stop, as in "lb." and "in.-lbs"; it must not be read as a product.
    text = re.sub(r"(?<=[A-Za-z])\.(?=$|[)\s/*-])", "", text)
    text = re.sub(r"[A-Za-z]+", lambda word: _known_word(word[0], quantity), text)
    text = _BETWEEN.sub("*", text)
    text = _EXPONENT.sub(r"^\1", re.sub(r"\s*\*\s*", "*", text))
    text = re.sub(r"^\(([^()]*)\)$", r"\1", text)
    return "turn/min" if quantity in RATES and text in _PER_MINUTE else text


def _known_word(word: str, quantity: str | None) -> str:
    """Return the name of the closed list for a word of a unit; an unlisted word is returned unchanged."""
    if word == _GERMAN_DEGREE:
        return "deg"
    known = word if word in unit_names() else SPELLED_OUT.get(word.lower(), word)
    if quantity in (*TORQUES, *FORCES) and (known != "g" or quantity in TORQUES):
        known = _AS_FORCE.get(known, known)
    if known not in unit_names() and (parts := _RUN_TOGETHER.fullmatch(known)):
        pair = [part for part in parts.groups() if part]
        return "({})".format("*".join(_AS_FORCE.get(part, SPELLED_OUT.get(part, part)) for part in pair))
    return known


@lru_cache(maxsize=256)
def _factor(spelling: str, unit: str, quantity: str) -> float:
    """Return the factor computed by Pint; `unit` is the user's spelling, used in messages."""
    doubt = _doubt(unit)
    parsed, expected = (None if doubt else _parse(spelling)), _parse(SI_UNIT[quantity])
    expectation = f"expected {SI_UNIT[quantity]} or a multiple of it"
    if parsed is None or expected is None:
        raise RecordError(f'unknown unit "{unit}" for {quantity}; {doubt or expectation}')
    if not parsed.is_compatible_with(expected):
        raise RecordError(f'unit "{unit}" does not measure {quantity}; {expectation}')
    return float(unit_registry().Quantity(1.0, parsed).to(expected).magnitude)


def _doubt(unit: str) -> str | None:
    """Return a message with both meanings of an ambiguous unit and their notation, or None if it is unambiguous."""
    for word in re.findall(r"[A-Za-z]+", unit):
        if word.lower() == "grad" and word != _GERMAN_DEGREE:
            return 'it may be degrees or gon (0.9 deg); write unit = "deg" or unit = "gon"'
        milli = "m" + word[1:]
        if word[0] == "M" and not _is_listed(word) and _is_listed(milli):
            return f'"M" means mega, which no record uses; if milli is meant, write "{milli}"'
    return None


def _is_listed(word: str) -> bool:
    return all(part in unit_names() for part in _known_word(word, None).strip("()").split("*"))


def _parse(spelling: str) -> Unit | None:
    """Return the Pint unit of a spelling, or None if it cannot be parsed."""
    if not _PLAIN.fullmatch(spelling) or _POWER_OF_NUMBER.search(spelling):
        return None
    try:
        return unit_registry().parse_units(spelling)
    except Exception:
        return None
