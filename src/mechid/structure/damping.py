"""Modal damping in files: ratio of critical damping or percent, with a check for the ambiguous case.

Structures with more than 20 % damping are rare, tables in percent are not. A larger number without a unit is therefore
rejected as ambiguous; a value stated in percent is accepted.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mechid.arrays import FloatArray
from mechid.errors import InputFileError

RATIO, PERCENT = KEYS = ("damping", "damping_percent")
"""Names of keys, columns and variables with damping."""
ASKED_ABOVE = 0.2
"""Damping ratio of a structure's mode above which percent may be meant."""
CONTROL_ASKED_ABOVE = 2.0
"""The same for a controller, which is usually damped by 0.5 to 1."""
REMEDY = (
    "write damping_percent = {largest} if percent is meant, damping_percent = {in_percent} if the share of critical is"
)
_RATIO_UNITS, _PERCENT_UNITS = ("1", "-", "", "ratio", "of critical"), ("%", "percent", "pct", "% of critical", "%cr")
_NAMES = re.compile(r"(modal |critical )?(damping|zeta|xi|ζ|ξ)( ratio| factor)?( percent| pct)?")
_OTHER_MEASURES: Mapping[str, tuple[re.Pattern[str], str]] = {
    "a quality factor": (re.compile(r"q|(q|quality)( factor)"), "1/(2 Q)"),
    "a loss factor (structural damping)": (
        re.compile(r"eta|η|(structural|hysteretic) damping|(damping )?loss( factor)|g damping"),
        "half of it",
    ),
}
"""Other measures of damping: patterns of their column names, and the equivalent damping ratio."""


def damping_key(entry: Mapping[str, Any], place: str) -> str:
    """Return the key under which an entry states the damping; `RATIO` if it states none.

    Raises
    ------
    InputFileError
        The entry has both keys.
    """
    if RATIO in entry and PERCENT in entry:
        raise InputFileError(f"{place}: has both {RATIO} and {PERCENT}; remove one")
    return PERCENT if PERCENT in entry else RATIO


def damping_ratio(
    values: ArrayLike, key: str, place: str, *, asked_above: float = ASKED_ABOVE, remedy: str = REMEDY
) -> FloatArray:
    """Return damping as a ratio of critical damping, in the shape of `values`.

    Parameters
    ----------
    values : array_like
        Values of the file under `key`.
    key : {"damping", "damping_percent"}
    place : str
        Location in the file, for messages.
    asked_above : float
        Damping ratio above which values under `RATIO` are ambiguous.
    remedy : str
        Remedy for both cases; ``{largest}`` and ``{in_percent}`` are replaced by the largest value.

    Raises
    ------
    InputFileError
        The values are ambiguous and may be in percent.

    Examples
    --------
    >>> damping_ratio(0.5, "damping_percent", "budget.toml: structure").item()
    0.005
    >>> damping_ratio(0.5, "damping", "structure.damping")
    Traceback (most recent call last):
    mechid.errors.InputFileError: structure.damping: found 0.5, which is read as 50 % of critical damping; write \
damping_percent = 0.5 if percent is meant, damping_percent = 50 if the share of critical is
    """
    values = np.asarray(values, dtype=np.float64)
    if key == PERCENT:
        return 0.01 * values
    if np.max(values, initial=0.0) > asked_above:
        largest = float(values.max())
        in_percent = f"{100.0 * largest:.9g}"
        raise InputFileError(
            f"{place}: found {largest:.9g}, which is read as {in_percent} % of critical damping; "
            f"{remedy.format(largest=f'{largest:.9g}', in_percent=in_percent)}"
        )
    return values


def key_of_column(name: str, unit: str | None, place: str) -> tuple[str, bool] | None:
    """Return the key of a damping column, and whether its unit is stated; None for any other column.

    Raises
    ------
    InputFileError
        The column contains another measure of damping, or its unit is not valid for damping.

    Examples
    --------
    >>> key_of_column("zeta", "%", "modes.csv"), key_of_column("Damping_ratio", None, "modes.csv")
    (('damping_percent', True), ('damping', False))
    >>> key_of_column("damping", "1", "modes.csv"), key_of_column("los_x", None, "modes.csv")
    (('damping', True), None)
    """
    plain = " ".join(re.split(r"[\s_]+", name.strip().lower()))

    for what, (names, ratio) in _OTHER_MEASURES.items():
        if names.fullmatch(plain):
            raise InputFileError(f'{place}: column "{name}": is {what}; write a column "damping" with {ratio}')
    if not (found := _NAMES.fullmatch(plain)):
        return None
    stated = None if unit is None else unit.strip().lower()
    if stated is not None and stated not in (*_RATIO_UNITS, *_PERCENT_UNITS):
        raise InputFileError(f'{place}: column "{name}": unit "{unit}" is not valid here; expected 1 or %')
    percent = stated in _PERCENT_UNITS or bool(found[4])
    if found[4] and stated in _RATIO_UNITS:
        raise InputFileError(f'{place}: column "{name}": has unit "{unit}"; write "damping [%]" or "damping [1]"')
    return (PERCENT if percent else RATIO), stated is not None or percent
