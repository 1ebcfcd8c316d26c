"""Rate profiles from CSV files: a header line, then lines of a time in s and a rate in full steps/s."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from io import StringIO
from pathlib import Path

from mechid.command.entry import format_found, quote_words
from mechid.command.rate import RateProfile, first_fault
from mechid.errors import InputFileError
from mechid.reading.whole import read_text
from mechid.writing import mark_as_read

TIME_NAME = "time_s"
RATE_NAMES = ("rate", "rate_steps_per_s", "rate_full_steps_per_s")


def read_rate_table(path: Path) -> RateProfile:
    """Return the rate profile in a CSV file with the columns ``time_s,rate``.

    The rate is in full steps/s; the header may use any of `RATE_NAMES`. Empty lines are skipped.

    Parameters
    ----------
    path : Path
        File, UTF-8, comma-separated.

    Raises
    ------
    InputFileError
        The file cannot be read, has another header, or has a line that is not a breakpoint.
    """
    rows = rows_of_table(path)
    if not rows:
        raise InputFileError(f'{path}: the file is empty; write a header line "{TIME_NAME},rate", then the rates')
    _check_header(path, rows[0][1])
    lines = [line for line, _ in rows[1:]]
    points = [_breakpoint(f"{path}: line {line}", cells) for line, cells in rows[1:]]
    if not points:
        raise InputFileError(f"{path}: no line after the header; write one time and rate or more")
    fault = first_fault(*zip(*points, strict=True))
    if fault is not None:
        raise InputFileError(f"{path}: line {lines[fault[0]]}: {fault[1]}")
    return RateProfile.through(points)


def rows_of_table(path: Path) -> list[tuple[int, list[str]]]:
    """Return the non-empty lines of a CSV file, as cells, with their numbers in the file.

    Raises
    ------
    InputFileError
        The file cannot be read, or is no text.
    """
    try:
        text = read_text(path)
        mark_as_read(path)
        return _nonempty_lines(csv.reader(StringIO(text)))
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise InputFileError(f"{path}: cannot be read ({reason}); check the path") from error
    except (ValueError, csv.Error) as error:
        raise InputFileError(f"{path}: is not plain text; save it as CSV in UTF-8") from error


def _nonempty_lines(lines: Iterable[list[str]]) -> list[tuple[int, list[str]]]:
    """Return the non-empty lines, numbered from 1, with their cells stripped."""
    stripped = ((at, [cell.strip() for cell in cells]) for at, cells in enumerate(lines, start=1))
    return [(at, cells) for at, cells in stripped if any(cells)]


def _check_header(path: Path, cells: list[str]) -> None:
    """Refuse other columns; a unit in a header must never be ignored."""
    if len(cells) == 2 and cells[0] == TIME_NAME and cells[1] in RATE_NAMES:
        return
    remedy = f'write "{TIME_NAME},rate", times in s and rates in full steps/s'
    others = f"(the rate may also be called {quote_words(RATE_NAMES[1:])})"
    raise InputFileError(f"{path}: header: found {format_found(','.join(cells))}; {remedy} {others}")


def _breakpoint(place: str, cells: list[str]) -> tuple[float, float]:
    """Return the two numbers of one line."""
    try:
        time, rate = (float(cell) for cell in cells)
    except ValueError:
        raise InputFileError(f"{place}: found {format_found(','.join(cells))}; write a time and a rate") from None
    return time, rate
