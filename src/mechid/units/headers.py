"""Units in column headers: as a suffix, in brackets, or within the name."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from itertools import pairwise

from mechid.units.quantities import FORCES, RATES, TORQUES

HEADER_SUFFIXES: Mapping[str, str] = {
    **{unit: unit for unit in ("N", "mN", "kN", "Nm", "mNm", "uNm", "kNm", "Nmm", "Ncm")},
    **{unit: unit for unit in ("rad", "mrad", "deg", "rpm", "RPM", "rad/s", "deg/s", "m/s", "mm/s")},
    **{unit: unit for unit in ("m", "mm", "um", "A", "mA", "uA", "V", "mV", "kV")},
    **{unit: unit for unit in ("s", "ms", "us", "ns", "min", "h", "N*m", "mN*m", "N.m", "mN.m")},
    **{f"{top}_{way}s": f"{top}/s" for top in ("rad", "deg", "m", "mm") for way in ("", "per_")},
    **{f"{top}ps": f"{top}/s" for top in ("rad", "deg")},
    **{f"{prefix}N_m": f"{prefix}N*m" for prefix in ("", "m")},
}
"""Units accepted as a suffix of a column name without brackets, as in ``torque_Nm`` or ``rate_rad_s``.

The list is closed: the suffix of ``phase_a`` is not an ampere, and that of ``u_B`` is not a unit.
"""

_ANGLE_WORDS = frozenset(
    ("deg", "degs", "degree", "degrees", "grad", "gon", "mrad", "urad", "arcsec", "arcmin", "rev", "revs", "turns")
)
_WORDS_OF: Mapping[tuple[str, ...], frozenset[str]] = {
    TORQUES: frozenset(
        (
            *("mnm", "unm", "knm", "nmm", "ncm", "cnm", "gcm", "gfcm", "kgcm", "kgfcm", "kgm", "kgf"),
            *("ozin", "ozfin", "ozf", "inoz", "lbin", "lbfin", "lbf", "inlb", "inlbf", "ftlb", "lbft", "ftlbf"),
        )
    ),
    FORCES: frozenset(("mn", "kn", "lbf", "lbs", "ozf", "kgf", "kp")),
    ("time",): frozenset(("ms", "msec", "millis", "us", "usec", "ns", "min", "minutes", "h", "hours", "days")),
    ("rotor_angle", "output_angle"): _ANGLE_WORDS,
    RATES: _ANGLE_WORDS | {"rpm", "upm", "rps", "dps"},
    ("position",): frozenset(("mm", "um", "cm", "nm", "inch")),
    ("velocity",): frozenset(("mm", "mms", "um", "ums", "cms")),
    ("current", "current_phase_a", "current_phase_b", "current_phase_c", "current_phase_d"): frozenset(("ma",)),
    ("voltage", *(f"voltage_phase_{x}" for x in "abcd")): frozenset(("mv", "kv")),
}
WORDS_OF_UNITS: Mapping[str, frozenset[str]] = {name: words for names, words in _WORDS_OF.items() for name in names}
"""Lower-case words that may denote a non-SI unit anywhere in a column name, by quantity."""


def split_header(column: str) -> tuple[str, str | None]:
    """Split a column header into its name and its unit; the unit is None if the header states none.

    The unit is in brackets, or follows a slash or an underscore. In the second case it must be in `HEADER_SUFFIXES`,
    because names contain slashes and underscores too.

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
    """Return the first word of a header that may be a non-SI unit, as in ``torque_mNm_filtered``, or None.

    Examples
    --------
    >>> unit_within("torque_mNm_filtered", "torque"), unit_within("Torque in Ncm", "torque")
    ('mNm', 'Ncm')
    >>> unit_within("torque_oz_in", "torque"), unit_within("time_msec", "time")
    ('oz in', 'msec')
    >>> unit_within("torque filtered", "torque") is None
    True
    """
    known = WORDS_OF_UNITS.get(quantity, frozenset())
    return next((text for text in _words(column) if _in_small_letters(text) in known), None)


def _in_small_letters(text: str) -> str:
    return re.sub("[ µμ]", lambda sign: "" if sign[0] == " " else "u", text).lower()


def _words(column: str) -> Iterator[str]:
    """Yield pairs of adjacent words of a header, then the single words."""
    words = [word for word in re.split(r"[^A-Za-zµμ]+", column) if word]
    # Pairs come first because "oz in" is one unit of torque, while "in" alone is a length.
    yield from (f"{first} {second}" for first, second in pairwise(words))
    yield from words
