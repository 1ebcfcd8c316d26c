"""Errors that a user can cause, each with the exit code of the command line.

A message states where the fault is, what was found and what to do:
``campaign.toml: stage[1].free[2]: unknown parameter "gear.stifness"; did you mean "gear.stiffness"?``
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable

DEBUG = "MECHID_DEBUG"
"""Environment variable; set it to 1 to see tracebacks."""


class MechidError(Exception):
    """Base class of all errors that mechid raises on purpose; `exit_code` is the exit code of the command."""

    exit_code = 1


class UsageError(MechidError):
    """The command line or a call asks for something that does not exist."""

    exit_code = 2


class UnwritableError(UsageError):
    """A file or a folder cannot be written to, e.g. no space, no permission, or too long a name."""


class WorkersError(MechidError):
    """The workers of an external executor, or its scheduler, are unreachable, lost or inconsistent."""

    exit_code = 2


class InputFileError(MechidError):
    """A mechanism or campaign file is wrong."""

    exit_code = 3


class RecordError(MechidError):
    """A measured record is missing or unusable."""

    exit_code = 4


class FitError(MechidError):
    """The simulation or the fit failed."""

    exit_code = 5


def did_you_mean(found: str, known: Iterable[str]) -> str:
    """Return ``'; did you mean "x"?'`` for the nearest of `known`, or an empty string."""
    # difflib's default, written out: a looser threshold would suggest keys that have nothing in common.
    near = difflib.get_close_matches(found, list(known), n=1, cutoff=0.6)
    return f'; did you mean "{near[0]}"?' if near else ""
