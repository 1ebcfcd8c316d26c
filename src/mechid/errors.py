"""The errors a user can cause, each with the exit code of the command line.

A message says where, what was found and what to do:
``campaign.toml: stage[1].free[2]: unknown parameter "gear.stifness"; did you mean "gear.stiffness"?``
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable

DEBUG = "MECHID_DEBUG"
"""Variable of the environment that is 1 where tracebacks are wanted."""


class MechidError(Exception):
    """Base of every error mechid raises on purpose; `exit_code` is what the command returns."""

    exit_code = 1


class UsageError(MechidError):
    """The command line or a call asks for something that does not exist."""

    exit_code = 2


class UnwritableError(UsageError):
    """A file or a folder cannot be written to: no room, no permission, a name that is too long."""


class WorkersError(MechidError):
    """Workers that were lent for a computation, or their scheduler, cannot be reached, are lost or are not alike."""

    exit_code = 2


class InputFileError(MechidError):
    """A mechanism or campaign file is wrong."""

    exit_code = 3


class RecordError(MechidError):
    """A measured record is missing or cannot be used."""

    exit_code = 4


class FitError(MechidError):
    """The simulation or the fit did not succeed."""

    exit_code = 5


def did_you_mean(found: str, known: Iterable[str]) -> str:
    """Return ``'; did you mean "x"?'`` for the nearest of `known`, or an empty string."""
    near = difflib.get_close_matches(found, list(known), n=1, cutoff=0.6)
    return f'; did you mean "{near[0]}"?' if near else ""
