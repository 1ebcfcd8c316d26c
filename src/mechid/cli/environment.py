"""Checks of the environment for settings with which libraries would fail in the middle of a command."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from mechid.errors import UsageError

NOT_COMPILED, THREADS = "NUMBA_DISABLE_JIT", "NUMBA_NUM_THREADS"


def refuse_surroundings(environment: Mapping[str, str]) -> None:
    """Refuse settings of Numba that prevent compilation, and a missing working directory.

    Raises
    ------
    UsageError
        Compilation is disabled, the number of threads is not positive, or the working directory is missing.
    """
    try:
        Path.cwd()
    except OSError as error:
        raise UsageError("the folder in which this was started is gone; change to another one") from error
    if _number(environment.get(NOT_COMPILED), 0) != 0:
        raise UsageError(f"{NOT_COMPILED} is set, and mechid's equations only run compiled; unset it")
    if (threads := _number(environment.get(THREADS), 1)) < 1:
        raise UsageError(f"{THREADS} is {threads}; unset it, or give 1 or more")


def _number(text: str | None, default: int) -> int:
    """Return the value of a variable as read by Numba, which ignores invalid numbers."""
    try:
        return int(text or default)
    except ValueError:
        return default
