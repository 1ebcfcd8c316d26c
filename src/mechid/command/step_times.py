"""Commands by the instants of their steps, as a rate profile that reaches each step at its instant.

Between two instants the rate is constant, one step over the time between them, so that everything that asks a command
for its rate or travel has them. The first step is approached at the rate to the second, the last one ends the motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.command.entry import format_found, is_number
from mechid.command.rate import RateProfile
from mechid.command.rate_table import TIME_NAME, rows_of_table
from mechid.errors import InputFileError, UsageError

DIRECTION = "direction"
DIRECTIONS = (1, -1)


def profile_of_steps(times_s: Sequence[float], directions: Sequence[int], steps_per_full_step: int) -> RateProfile:
    """Return the rate profile whose steps are at given instants.

    Parameters
    ----------
    times_s : (E,)
        Instants of the steps in s of command time, above 0, strictly ascending.
    directions : (E,)
        1 or -1 for each step.
    steps_per_full_step : int
        n, steps of the command in a full step.

    Raises
    ------
    UsageError
        There is no step, or an instant or a direction is invalid; the message starts with its place.

    Examples
    --------
    >>> profile_of_steps([0.1, 0.2, 0.4], [1, 1, -1], 1)
    RateProfile(times_s=(0.0, 0.1, 0.1, 0.2, 0.2, 0.4, 0.4), rates=(10.0, 10.0, 10.0, 10.0, -5.0, -5.0, 0.0))
    """
    if not len(times_s):
        raise UsageError("step_times: found none; write the instants of the steps in s")
    for at, (time, way) in enumerate(zip(times_s, directions, strict=True)):
        before = times_s[at - 1] if at else 0.0
        if not is_number(time) or time <= before:
            remedy = f"write an instant in s above {before:.9g}" + ("" if at else ", where the command starts")
            raise UsageError(f"step_times[{at}]: found {format_found(time)}; {remedy}")
        if way not in DIRECTIONS:
            raise UsageError(f"step_times[{at}]: direction {format_found(way)}; write 1 or -1")
    ends = np.asarray(times_s, dtype=np.float64)
    lapse = np.diff(ends, prepend=0.0)
    # Waiting for the first step is no motion: it is approached at the rate to the second.
    lapse[0] = min(lapse[0], lapse[1] if lapse.size > 1 else lapse[0])
    rates = np.asarray(directions, dtype=np.float64) / (lapse * steps_per_full_step)
    return _profile_of_pieces(ends, lapse, rates)


def _profile_of_pieces(ends: FloatArray, lapse: FloatArray, rates: FloatArray) -> RateProfile:
    """Return the profile of constant rates that end at given instants; 0 before the first and after the last."""
    first = float(ends[0] - lapse[0])
    times = [*([0.0] if first > 0.0 else []), first, *np.repeat(ends, 2).tolist()]
    values = [*([0.0] if first > 0.0 else []), *np.repeat(rates, 2).tolist(), 0.0]
    if first > 0.0:  # a jump from rest
        times.insert(1, first)
        values.insert(1, 0.0)
    return RateProfile(tuple(times), tuple(values))


def step_times_of(found: Any, steps_per_full_step: int, folder: Path = Path()) -> RateProfile:
    """Return the profile that ``step_times`` gives: instants, [instant, direction] pairs, or the name of a CSV file.

    Raises
    ------
    UsageError
        The entry, the file or an instant is invalid.
    """
    if isinstance(found, str) and found:
        try:
            return profile_of_steps(*read_step_times(folder / found), steps_per_full_step)
        except InputFileError as error:
            raise UsageError(f"step_times: {error}") from error
        except UsageError as error:
            raise UsageError(f"step_times: {folder / found}: {error}") from error
    if not isinstance(found, list | tuple):
        raise UsageError(f'step_times: found {format_found(found)}; write instants in s, or a file, as "steps.csv"')
    pairs = [one if isinstance(one, list | tuple) else (one, 1) for one in found]
    for at, pair in enumerate(pairs):
        if len(pair) != 2:
            raise UsageError(f"step_times[{at}]: found {format_found(pair)}; write an instant, or [instant, direction]")
    return profile_of_steps([time for time, _ in pairs], [way for _, way in pairs], steps_per_full_step)


def read_step_times(path: Path) -> tuple[list[float], list[int]]:
    """Return the instants in s and the directions in a CSV file with the columns ``time_s`` or ``time_s,direction``.

    Raises
    ------
    InputFileError
        The file cannot be read, or has another header or a line that is none of numbers.
    """
    lines = rows_of_table(path)
    headers = ([TIME_NAME], [TIME_NAME, DIRECTION])
    if not lines or lines[0][1] not in headers:
        found = format_found(",".join(lines[0][1])) if lines else "an empty file"
        remedy = f'write "{TIME_NAME}" or "{TIME_NAME},{DIRECTION}", instants in s and 1 or -1'
        raise InputFileError(f"{path}: header: found {found}; {remedy}")
    times, ways = [], []
    for line, cells in lines[1:]:
        try:
            time, *way = (float(cell) for cell in cells)
        except ValueError:
            time, way = float("nan"), [0.0] * len(cells)
        if len(cells) != len(lines[0][1]) or (way and way[0] not in DIRECTIONS):
            remedy = "write an instant in s" + (" and 1 or -1" if len(lines[0][1]) > 1 else "")
            raise InputFileError(f"{path}: line {line}: found {format_found(','.join(cells))}; {remedy}")
        times.append(time)
        ways.append(int(way[0]) if way else 1)
    return times, ways
