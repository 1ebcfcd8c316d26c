"""Closed list of supported units, and a Pint registry that contains only these.

A general parser reads "Grad" as a gigaradian and "Ms" as a megasecond. No record of a mechanism holds these units, so
each unit is listed only with the prefixes that instruments use.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pint import UnitRegistry

_PREFIXES: Mapping[str, float] = {"n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "d": 1e-1, "k": 1e3, "M": 1e6}
_BASE_UNITS = ("m = [length]", "g = [mass]", "s = [time]", "A = [current]", "rad = [angle]")
_LIST: tuple[tuple[str, str, str], ...] = (
    # names, prefixes that instruments use, definition
    ("m", "numck", ""),
    ("g", "mkM", ""),  # Mg: tonnes of finite-element models in mm
    ("s", "num", ""),
    ("A", "numk", ""),
    ("rad", "num", ""),
    ("N", "numcdk", "kg*m/s^2"),
    ("J", "numk", "N*m"),
    ("V", "numk", "J/(A*s)"),
    ("Hz", "mk", "1/s"),
    ("deg", "um", "0.017453292519943295 rad"),  # pi/180
    ("arcmin", "", "deg/60"),
    ("arcsec", "m", "deg/3600"),
    ("gon", "m", "0.9 deg"),
    ("turn rev revs r tr U", "", "360 deg"),
    ("rpm Upm", "", "turn/min"),
    ("rps", "", "turn/s"),
    ("min", "", "60 s"),
    ("h hr", "", "3600 s"),
    ("d day", "", "86400 s"),
    ("inch in", "", "0.0254 m"),
    ("ft", "", "0.3048 m"),
    ("lb", "", "0.45359237 kg"),
    ("oz", "", "lb/16"),
    ("kgf kp", "", "9.80665 N"),
    ("gf", "", "0.00980665 N"),
    ("lbf", "", "4.4482216152605 N"),  # 0.45359237 * 9.80665
    ("ozf", "", "lbf/16"),
    ("dyn", "", "1e-5 N"),
)
SPELLED_OUT: Mapping[str, str] = {
    word: unit
    for unit, words in {
        "V": "volt volts",
        "A": "ampere amperes amp amps",
        "N": "newton newtons",
        "m": "meter meters metre metres",
        "(N*m)": "newtonmeter newtonmeters newtonmetre newtonmetres",
        "s": "second seconds sec secs sekunde sekunden sek seconde secondes",
        "ms": "msec msecs millisecond milliseconds millisekunde millisekunden",
        "us": "usec usecs microsecond microseconds mikrosekunde mikrosekunden",
        "ns": "nsec nanosecond nanoseconds nanosekunde nanosekunden",
        "min": "mins minute minutes minuten",
        "h": "hrs hour hours stunde stunden",
        "d": "days tag tage",
        "rad": "rad radian radians",
        "mrad": "milliradian milliradians",
        "deg": "deg degs degree degrees",
        "gon": "gradian gradians",
        "arcmin": "arcminute arcminutes",
        "arcsec": "arcsecond arcseconds",
        "turn": "turns revolution revolutions umdrehung umdrehungen",
        "rpm": "rpm upm",
        "inch": "in ins inches",
        "ft": "ft foot feet",
        "lb": "lb",
        "oz": "oz",
        "lbf": "lbf lbs pound pounds",
        "ozf": "ozf ozs ounce ounces",
    }.items()
    for word in words.split()
}
"""Unit symbols by their spelled-out names in lower case, as written by LabVIEW, DAQmx and others."""


@lru_cache(maxsize=1)
def unit_names() -> frozenset[str]:
    """Return the names of all listed units, with and without prefixes."""
    return frozenset(
        prefix + name for names, prefixes, _ in _LIST for name in names.split() for prefix in ("", *prefixes)
    )


@lru_cache(maxsize=1)
def unit_registry() -> UnitRegistry[float]:
    """Return a Pint registry of the closed list.

    Angle is a dimension of its own: rad/s is not compatible with Hz, nor N*m with N*m/rad.
    """
    # Imported here because loading Pint takes longer than reading a record, and records in SI units do not need it.
    import pint

    registry: UnitRegistry[float] = pint.UnitRegistry(None)
    for line in _BASE_UNITS:
        registry.define(line)
    for names, prefixes, definition in _LIST:
        first, *others = names.split()
        if definition:
            registry.define(f"{first} = {definition}")
        for name in others:
            registry.define(f"{name} = {first}")
        for prefix in prefixes:
            registry.define(f"{prefix}{first} = {_PREFIXES[prefix]!r} {first}")
    return registry
