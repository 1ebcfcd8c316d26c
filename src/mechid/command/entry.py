"""Validation of single entries of a command; a message names the key, the value found and the remedy."""

from __future__ import annotations

import math
import numbers
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeVar

from mechid.errors import UsageError, did_you_mean

Word = TypeVar("Word", bound=str)

LARGEST_ANGLE_DEG = 1e6


def quote_words(words: Iterable[str]) -> str:
    """Return the words in double quotes, separated by commas."""
    return ", ".join(f'"{word}"' for word in words)


def format_found(found: object) -> str:
    """Format a value for a message: text in double quotes, long values shortened."""
    text = f'"{found}"' if isinstance(found, str) else repr(found)
    return text if len(text) <= 60 else f"{text[:57]}..."


def is_number(found: object) -> bool:
    """Return whether the value is a finite number that a float can hold; a boolean is not."""
    if isinstance(found, bool) or not isinstance(found, numbers.Real):
        return False
    try:
        return math.isfinite(found)
    except OverflowError:
        return False


def is_whole(found: object, least: int, most: int) -> bool:
    """Return whether the value is an integer within two inclusive limits; a boolean is not."""
    return not isinstance(found, bool) and isinstance(found, numbers.Integral) and least <= int(found) <= most


def is_table(found: object) -> bool:
    """Return whether the value is a table of keys and values."""
    return isinstance(found, Mapping)


def number(key: str, found: Any) -> float:
    """Return a finite number as a float.

    Raises
    ------
    UsageError
        The value is not a number, or not finite.
    """
    if not is_number(found):
        raise UsageError(f"{key}: found {format_found(found)}; write a finite number")
    return float(found)


def angle_deg(key: str, found: Any) -> float:
    """Return an angle in degrees; raise UsageError if it is not a finite number or exceeds `LARGEST_ANGLE_DEG`.

    Examples
    --------
    >>> angle_deg("start_angle_deg", 45)
    45.0
    """
    angle = number(key, found)
    # The larger a float, the coarser the part of a turn that it resolves.
    if abs(angle) > LARGEST_ANGLE_DEG:
        raise UsageError(f"{key}: found {format_found(found)}; write degrees, {LARGEST_ANGLE_DEG:g} at most")
    return angle


def choose_option(key: str, found: Any, options: Sequence[Word]) -> Word:
    """Return the member of `options` that equals the value.

    Raises
    ------
    UsageError
        The value is not among them.
    """
    for option in options:
        if isinstance(found, str) and found == option:
            return option
    near = did_you_mean(found, options) if isinstance(found, str) else ""
    raise UsageError(f"{key}: found {format_found(found)}{near or f'; write one of {quote_words(options)}'}")


def refuse_unknown(keys: Iterable[str], known: Sequence[str]) -> None:
    """Refuse the first unknown key.

    Raises
    ------
    UsageError
        With the nearest known key, or with all known keys if none is near.
    """
    for key in keys:
        if key not in known:
            near = did_you_mean(key, known) or f"; the keys of a command are {', '.join(known)}"
            raise UsageError(f"{key}: unknown key{near}")
