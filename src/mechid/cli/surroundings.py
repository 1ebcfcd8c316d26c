"""Surroundings in which libraries stumble in the middle of a command: refused before it begins."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from mechid.errors import UsageError

NOT_COMPILED, THREADS = "NUMBA_DISABLE_JIT", "NUMBA_NUM_THREADS"


def refuse_surroundings(environment: Mapping[str, str]) -> None:
    """Refuse variables of the environment with which Numba compiles nothing, and a working directory that is gone.

    Raises
    ------
    UsageError
        It says that nothing is to be compiled, or asks for no thread at all; there is no working directory.
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
    """Return a variable's number as Numba reads it: one that is no whole number counts as left out."""
    try:
        return int(text or default)
    except ValueError:
        return default
