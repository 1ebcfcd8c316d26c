"""Units at the border: what a file says becomes SI once, and nothing inside knows another unit.

Pint is imported only when a unit is met that is not the SI one already: loading it costs more
than reading a record.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeVar

from mechid.arrays import FloatArray
from mechid.errors import RecordError, did_you_mean

if TYPE_CHECKING:
    from pint import Unit, UnitRegistry

Angle = TypeVar("Angle", float, FloatArray)

SI_UNIT: Mapping[str, str] = {
    "time": "s",
    "torque": "N*m",
    "force": "N",
    "rotor_angle": "rad",
    "rotor_rate": "rad/s",
    "output_angle": "rad",
    "output_rate": "rad/s",
    "position": "m",
    "velocity": "m/s",
    "current": "A",
    "voltage": "V",
    "current_phase_a": "A",
    "current_phase_b": "A",
    "voltage_phase_a": "V",
    "voltage_phase_b": "V",
    **dict.fromkeys(("force_x", "force_y", "force_z"), "N"),
    **dict.fromkeys(("moment_x", "moment_y", "moment_z"), "N*m"),
}
"""The quantities a record can hold, each with the unit it has inside mechid."""

HEADER_SUFFIXES: Mapping[str, str] = {
    **{unit: unit for unit in ("N", "mN", "kN", "Nm", "mNm", "uNm", "kNm", "Nmm", "Ncm")},
    **{unit: unit for unit in ("rad", "mrad", "deg", "rpm", "rad/s", "deg/s", "m/s", "mm/s")},
    **{unit: unit for unit in ("m", "mm", "um", "A", "mA", "uA", "V", "mV", "kV")},
    **{unit: unit for unit in ("s", "ms", "us", "ns", "min", "h", "N*m", "mN*m", "N.m", "mN.m")},
    **{f"{top}_{way}s": f"{top}/s" for top in ("rad", "deg", "m", "mm") for way in ("", "per_")},
    **{f"{top}ps": f"{top}/s" for top in ("rad", "deg")},
    **{f"{prefix}N_m": f"{prefix}N*m" for prefix in ("", "m")},
}
"""Units that a column name may end in without brackets, as in ``torque_Nm`` or ``rate_rad_s``.

A closed list: to Pint the end of ``phase_a`` is a year and that of ``u_B`` a byte.
"""

WORDS_OF_UNITS: Mapping[str, frozenset[str]] = {
    "torque": frozenset(
        (
            *("mnm", "unm", "µnm", "μnm", "knm", "nmm", "ncm", "gcm", "kgcm", "kgfcm", "kgf"),
            *("ozin", "ozfin", "ozf", "lbin", "lbfin", "lbf", "inlb", "ftlb"),
        )
    ),
    "time": frozenset(("ms", "msec", "millis", "us", "µs", "μs", "usec", "ns", "min", "minutes", "h", "hours")),
}
"""Words of a column's name that may be its unit where they stand elsewhere, in small letters; none is the SI one."""

SPELLED_OUT: Mapping[str, str] = {
    **dict.fromkeys(("volt", "volts"), "V"),
    **dict.fromkeys(("ampere", "amperes", "amp", "amps"), "A"),
    **dict.fromkeys(("newton", "newtons"), "N"),
    **dict.fromkeys(("newton-meter", "newton-meters", "newton meters", "newton metres"), "N*m"),
    **dict.fromkeys(("inch-pounds", "in-lbs", "in.-lbs", "inch-pound"), "inch*lbf"),
    **dict.fromkeys(("foot-pounds", "ft-lbs", "foot-pound"), "foot*lbf"),
    **dict.fromkeys(("inch-ounces", "in-ozs", "in.-ozs"), "inch*force_ounce"),
    **dict.fromkeys(("radian", "radians"), "rad"),
    **dict.fromkeys(("degree", "degrees"), "deg"),
    **dict.fromkeys(("meter", "meters", "metre", "metres"), "m"),
    **dict.fromkeys(("second", "seconds", "sec"), "s"),
}
"""Units as LabVIEW, DAQmx and others write them in words, in whatever case."""

_ANGLE_UNITS = ("radian", "degree", "arcminute", "arcsecond", "grade", "turn", "revolutions_per_minute")
_PLAIN_TEXT = re.compile(r"[A-Za-z0-9µμ°·*/^(). -]{1,40}")
_POWER_OF_NUMBER = re.compile(r"[0-9).]\s*(?:\^|\*\s*\*)")


def angle_difference(angle_deg: Angle, from_deg: float = 0.0) -> Angle:
    """Return how far an angle is from another one the short way round, in [-180, 180) deg.

    Examples
    --------
    >>> angle_difference(179.0, -179.0), angle_difference(-179.0, 179.0), angle_difference(180.0)
    (-2.0, 2.0, -180.0)
    """
    return (angle_deg - from_deg + 180.0) % 360.0 - 180.0


def to_si_factor(unit: str, quantity: str) -> float:
    """Return what a value in `unit` is multiplied by to be in the SI unit of `quantity`.

    Parameters
    ----------
    unit : str
        As an engineer writes it: ``"N*m"``, ``"Nm"``, ``"mN.m"``, ``"deg"``, ``"rpm"``, ``"us"``.
    quantity : str
        One of the keys of `SI_UNIT`.

    Raises
    ------
    RecordError
        The quantity or the unit is unknown, or the unit measures something else.

    Examples
    --------
    >>> to_si_factor("mNm", "torque")
    0.001
    >>> to_si_factor("rpm", "rotor_rate")
    0.10471975511965977
    """
    expected = si_unit(quantity)
    spelling = _one_spelling(unit)
    return 1.0 if spelling == expected else _factor(spelling, unit, quantity)


def is_unit(text: str) -> bool:
    """Whether a text is a unit of some quantity that mechid knows.

    Examples
    --------
    >>> is_unit("N m"), is_unit("us"), is_unit("torque")
    (True, True, False)
    """
    for quantity in SI_UNIT:
        try:
            to_si_factor(text, quantity)
        except RecordError:
            continue
        return True
    return False


def conversion_factor(unit: str, to: str) -> float | None:
    """Return what a value in `unit` is multiplied by to be in `to`; None where it measures something else.

    For units that belong to no channel of a record, as those of a transfer function.

    Examples
    --------
    >>> conversion_factor("urad/(N*m)", "rad/(N*m)")
    1e-06
    >>> conversion_factor("rad/N", "rad/(N*m)") is None
    True
    """
    spelling = _one_spelling(unit)
    if spelling == to:
        return 1.0
    parsed, expected = _parse(spelling), _parse(to)
    if parsed is None or expected is None or not parsed.is_compatible_with(expected):
        return None
    if _angle_power(parsed) != _angle_power(expected):
        return None
    return float(_registry().Quantity(1.0, parsed).to(expected).magnitude)


def si_unit(quantity: str) -> str:
    """Return the SI unit of `quantity`, e.g. ``"N*m"``; RecordError where it is none that mechid knows."""
    if quantity not in SI_UNIT:
        near = did_you_mean(quantity, SI_UNIT)
        raise RecordError(f'unknown quantity "{quantity}"{near or "; known are " + ", ".join(SI_UNIT)}')
    return SI_UNIT[quantity]


def unit_words(quantity: str) -> str:
    """Return the SI unit of a quantity as it is written in a sentence.

    Examples
    --------
    >>> unit_words("torque")
    'N m'
    """
    return si_unit(quantity).replace("*", " ")


def split_header(column: str) -> tuple[str, str | None]:
    """Split a column's header into its name and its unit, None where it states none.

    The unit stands in brackets, or after a slash or an underscore; after those it counts as one
    only if it is in `HEADER_SUFFIXES`, because names hold slashes and underscores too.

    Examples
    --------
    >>> split_header("torque_Nm"), split_header("Mz [N*m]"), split_header("t/s")
    (('torque', 'Nm'), ('Mz', 'N*m'), ('t', 's'))
    >>> split_header("iA"), split_header("dz/dt"), split_header("phase_a")
    (('iA', None), ('dz/dt', None), ('phase_a', None))
    """
    text = column.strip()
    bracketed = re.search(r"[\s_/]*(?:\[([^\]]*)\]|\(([^()]*)\)$)", text)
    if bracketed:
        name = text[: bracketed.start()] + text[bracketed.end() :]
        return name, (bracketed[1] or bracketed[2] or "").strip() or None
    for mark in re.finditer(r"\s*[_/]\s*", text):
        if mark.start() and text[mark.end() :] in HEADER_SUFFIXES:
            return text[: mark.start()], HEADER_SUFFIXES[text[mark.end() :]]
    return text, None


def unit_within(column: str, quantity: str) -> str | None:
    """Return the word of a header without a unit that may be one all the same, as in ``torque_mNm_filtered``.

    Examples
    --------
    >>> unit_within("torque_mNm_filtered", "torque"), unit_within("Torque in Ncm", "torque")
    ('mNm', 'Ncm')
    >>> unit_within("torque filtered", "torque"), unit_within("time_msec", "time")
    (None, 'msec')
    """
    known = WORDS_OF_UNITS.get(quantity, frozenset())
    return next((word for word in re.split(r"[^A-Za-zµμ]+", column) if word.lower() in known), None)


def _one_spelling(unit: str) -> str:
    """Write products with ``*`` and take newton metres apart; to Pint, "Nm" is a yarn count."""
    unit = SPELLED_OUT.get(unit.strip().lower(), unit)
    text = re.sub(r"(?<=[A-Za-z])\s*[.·* -]\s*(?=[A-Za-z])", "*", unit.strip())
    text = re.sub(r"\brev\b", "turn", text)
    return re.sub(r"\b([pnuµμmck]?N)([mc]?m)\b", r"\1*\2", text)


@lru_cache(maxsize=256)
def _factor(spelling: str, unit: str, quantity: str) -> float:
    """Convert by Pint; `unit` is how the user wrote `spelling`, for the message."""
    parsed = _parse(spelling)
    expected = _parse(SI_UNIT[quantity])
    if parsed is None or expected is None:
        raise RecordError(f'unknown unit "{unit}" for {quantity}; expected {_expected(quantity)}')
    if not parsed.is_compatible_with(expected) or _angle_power(parsed) != _angle_power(expected):
        raise RecordError(f'unit "{unit}" does not measure {quantity}; expected {_expected(quantity)}')
    return float(_registry().Quantity(1.0, parsed).to(expected).magnitude)


def _expected(quantity: str) -> str:
    return f"{SI_UNIT[quantity]} or a multiple of it"


def _parse(spelling: str) -> Unit | None:
    """Return Pint's unit, or None: on nonsense its parser raises whatever it stumbles over."""
    if not _PLAIN_TEXT.fullmatch(spelling) or _POWER_OF_NUMBER.search(spelling):
        return None
    try:
        return _registry().parse_units(spelling)
    except Exception:
        return None


def _angle_power(unit: Unit) -> float:
    """Return the exponent of angle, which Pint counts as no dimension: rad/s is not Hz, N*m not N*m/rad."""
    powers: Iterable[tuple[str, Any]] = _registry().Quantity(1.0, unit).unit_items()
    return float(sum(power for name, power in powers if name.endswith(_ANGLE_UNITS)))


@lru_cache(maxsize=1)
def _registry() -> UnitRegistry[float]:
    import pint

    return pint.UnitRegistry()


def time_power(unit: str) -> float | None:
    """Return the power of time in a unit whose newton and metre stay as they are; None of a unit that is not known.

    Examples
    --------
    >>> time_power("kg*m^2"), time_power("N m s/rad"), time_power("ohm")
    (2.0, 1.0, -1.0)
    """
    parsed = _parse(re.sub(r"(?<=[A-Za-z])(?=[0-9])", "^", _one_spelling(unit)))
    if parsed is None:
        return None
    powers: Mapping[str, Any] = parsed.dimensionality
    return float(powers.get("[time]", 0)) + 2.0 * float(powers.get("[mass]", 0))
