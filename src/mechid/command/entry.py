"""Checks of single entries of a command; a message names the key, what was found and the remedy."""

from __future__ import annotations

import math
import numbers
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeVar

from mechid.errors import UsageError, did_you_mean

Word = TypeVar("Word", bound=str)

LARGEST_ANGLE_DEG = 1e6


def quoted(words: Iterable[str]) -> str:
    """Return the words in double quotes, with commas between."""
    return ", ".join(f'"{word}"' for word in words)


def shown(found: object) -> str:
    """Return what was found as a message shows it: text in double quotes, shortened where long."""
    text = f'"{found}"' if isinstance(found, str) else repr(found)
    return text if len(text) <= 60 else f"{text[:57]}..."


def is_number(found: object) -> bool:
    """Whether it is a finite number that a float can hold; a boolean is none."""
    if isinstance(found, bool) or not isinstance(found, numbers.Real):
        return False
    try:
        return math.isfinite(found)
    except OverflowError:
        return False


def is_whole(found: object, least: int, most: int) -> bool:
    """Whether it is an integer within two limits, these included; a boolean is none."""
    return not isinstance(found, bool) and isinstance(found, numbers.Integral) and least <= int(found) <= most


def is_table(found: object) -> bool:
    """Whether it is a table of keys and values."""
    return isinstance(found, Mapping)


def number(key: str, found: Any) -> float:
    """Return a finite number as a float.

    Raises
    ------
    UsageError
        If it is no number, or not finite.
    """
    if not is_number(found):
        raise UsageError(f"{key}: found {shown(found)}; write a finite number")
    return float(found)


def angle_deg(key: str, found: Any) -> float:
    """Return an angle in degrees; UsageError where it is no finite number, or so large that no part of a turn is left.

    Examples
    --------
    >>> angle_deg("start_angle_deg", 45)
    45.0
    """
    angle = number(key, found)
    if abs(angle) > LARGEST_ANGLE_DEG:
        raise UsageError(f"{key}: found {shown(found)}; write degrees, {LARGEST_ANGLE_DEG:g} at most")
    return angle


def chosen(key: str, found: Any, options: Sequence[Word]) -> Word:
    """Return the one of `options` that was found.

    Raises
    ------
    UsageError
        If it is none of them.
    """
    for option in options:
        if isinstance(found, str) and found == option:
            return option
    near = did_you_mean(found, options) if isinstance(found, str) else ""
    raise UsageError(f"{key}: found {shown(found)}{near or f'; write one of {quoted(options)}'}")


def refuse_unknown(keys: Iterable[str], known: Sequence[str]) -> None:
    """Refuse the first key that is not known.

    Raises
    ------
    UsageError
        With the nearest known key, or with all of them where none is near.
    """
    for key in keys:
        if key not in known:
            near = did_you_mean(key, known) or f"; the keys of a command are {', '.join(known)}"
            raise UsageError(f"{key}: unknown key{near}")
