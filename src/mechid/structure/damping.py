"""Damping of modes as files state it: share of critical damping, or percent, and the doubt which of them is meant.

A structure of 20 % damping is rare, a table in percent is not: a larger number without a unit is asked about. Whoever
has such damping states it in percent, which leaves no doubt.
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
"""Keys, columns and variables that hold it."""
ASKED_ABOVE = 0.2
"""Share of critical damping of a structure's mode from which on percent may be meant."""
CONTROL_ASKED_ABOVE = 2.0
"""The same of a controller, which has 0.5 to 1 on purpose."""
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
"""Other measures of damping by the names of their columns, and the damping of which they are the measure."""


def damping_key(entry: Mapping[str, Any], place: str) -> str:
    """Return the key under which an entry states the damping, `RATIO` where it has none.

    Raises
    ------
    InputFileError
        It has both.
    """
    if RATIO in entry and PERCENT in entry:
        raise InputFileError(f"{place}: has both {RATIO} and {PERCENT}; leave one out")
    return PERCENT if PERCENT in entry else RATIO


def damping_ratio(
    values: ArrayLike, key: str, place: str, *, asked_above: float = ASKED_ABOVE, remedy: str = REMEDY
) -> FloatArray:
    """Return damping as share of critical, in the shape of `values`.

    Parameters
    ----------
    values : array_like
        As the file has them under `key`.
    key : {"damping", "damping_percent"}
    place : str
        Where they stand, for messages.
    asked_above : float
        Share of critical from which on values under `RATIO` may be meant in percent.
    remedy : str
        What to write in either case; ``{largest}`` and ``{in_percent}`` stand for the largest value.

    Raises
    ------
    InputFileError
        They may be meant in percent.

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
    """Return the key of a column that holds damping, and whether its unit is stated; None of another column.

    Raises
    ------
    InputFileError
        It holds another measure of damping, or its unit is none of damping.

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
        raise InputFileError(f'{place}: column "{name}": unit "{unit}" is none for it; expected 1 or %')
    percent = stated in _PERCENT_UNITS or bool(found[4])
    if found[4] and stated in _RATIO_UNITS:
        raise InputFileError(f'{place}: column "{name}": has unit "{unit}"; write "damping [%]" or "damping [1]"')
    return (PERCENT if percent else RATIO), stated is not None or percent
