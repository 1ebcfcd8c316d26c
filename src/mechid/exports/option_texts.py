"""Readers of target options given as strings on the command line."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from mechid.errors import UsageError, did_you_mean
from mechid.plant.plant import Plant

YES, NO = "yes", "no"


def refuse_unknown(name: str, known: Sequence[str], *, also: str = "") -> None:
    """Raise UsageError for an unknown option, and suggest the most similar known one."""
    if name not in known:
        remedy = did_you_mean(name, known) or f"; the options are {', '.join(known)}{also}"
        raise UsageError(f'--option: found "{name}"{remedy}')


def yes_or_no(name: str, text: str) -> bool:
    """Read a yes-or-no option.

    Raises
    ------
    UsageError
        The text is neither ``yes`` nor ``no``.
    """
    if text not in (YES, NO):
        raise UsageError(f'--option {name}: found "{text}"; write {YES} or {NO}')
    return text == YES


def refuse_values(values: Mapping[str, float], plant: Plant) -> None:
    """Raise UsageError for a value of an unknown parameter, or one outside the limits of its parameter."""
    for name, value in values.items():
        if name not in plant.declarations:
            raise UsageError(f"values: unknown parameter {name}{did_you_mean(name, plant.declarations)}")
        least, most = plant.declarations[name].lower, plant.declarations[name].upper
        # NaN fails the first comparison, infinity the second.
        if not (least <= value <= most and math.isfinite(value)):
            raise UsageError(f"values: {name}: found {value:g}; write a number from {least:g} to {most:g}")


def read_rates(text: str) -> tuple[float, ...]:
    """Read comma-separated rates, sorted and without duplicates.

    Raises
    ------
    UsageError
        A part of the text is not a number.

    Examples
    --------
    >>> read_rates("46,23,46")
    (23.0, 46.0)
    """
    return tuple(sorted({_rate(part) for part in text.split(",")}))


def _rate(part: str) -> float:
    try:
        return float(part)
    except ValueError as error:
        raise UsageError(f'--option rates: found "{part}"; write numbers with commas between') from error
