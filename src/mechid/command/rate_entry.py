"""Rate of a campaign's ``command`` table: a constant, an inline profile, or a table in a file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mechid.command.entry import format_found, number
from mechid.command.rate import RateProfile, first_fault
from mechid.command.rate_table import read_rate_table
from mechid.command.step_times import step_times_of
from mechid.errors import InputFileError, UsageError

RATE_KEYS = ("rate", "rate_profile", "rate_table", "step_times")


def rate_of(table: Mapping[str, Any], folder: Path, steps_per_full_step: int) -> RateProfile:
    """Return the rate that a ``command`` table gives.

    Parameters
    ----------
    table : Mapping
        The table.
    folder : Path
        Folder to which relative files refer.
    steps_per_full_step : int
        n of the command, by which instants of steps become a rate.

    Raises
    ------
    UsageError
        The table gives no rate, several, or an invalid one.
    """
    given = [key for key in RATE_KEYS if key in table]
    if not given:
        raise UsageError("rate: missing; write rate = 46.0 (full steps/s), or rate_profile, rate_table or step_times")
    if len(given) > 1:
        raise UsageError(f"{given[1]}: found beside {given[0]}; keep one of {', '.join(RATE_KEYS)}")
    found = table[given[0]]
    if given[0] == "rate":
        return RateProfile.constant(number("rate", found))
    if given[0] == "step_times":
        return step_times_of(found, steps_per_full_step, folder)
    return _profile(found) if given[0] == "rate_profile" else _from_file(found, folder)


def _profile(found: Any) -> RateProfile:
    """Return the profile written as [[time, rate], ...]."""
    if not isinstance(found, list | tuple) or not found:
        raise UsageError(f"rate_profile: found {format_found(found)}; write [[time in s, full steps/s], ...]")
    for at, pair in enumerate(found):
        if not isinstance(pair, list | tuple) or len(pair) != 2:
            raise UsageError(f"rate_profile[{at}]: found {format_found(pair)}; write [time in s, full steps/s]")
    fault = first_fault(*zip(*found, strict=True))
    if fault is not None:
        raise UsageError(f"rate_profile[{fault[0]}]: {fault[1]}")
    return RateProfile.through((float(time), float(rate)) for time, rate in found)


def _from_file(found: Any, folder: Path) -> RateProfile:
    """Return the profile in a file."""
    if not isinstance(found, str) or not found:
        raise UsageError(f'rate_table: found {format_found(found)}; write the name of a file, as "rate.csv"')
    try:
        return read_rate_table(folder / found)
    except InputFileError as error:
        raise UsageError(f"rate_table: {error}") from error
