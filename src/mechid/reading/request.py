"""Requests to the reading process, and its answers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Libraries:
    """Request to import modules ahead of the calls that need them."""

    names: tuple[str, ...]


@dataclass(frozen=True)
class Call:
    """Request to call a module-level function.

    Parameters
    ----------
    function : callable
    arguments : tuple
        Picklable arguments.
    libraries : tuple of str
        Modules that the function needs. The parent process, which reads no files, imports them once for all its copies.
    seconds : float
        Time limit.
    """

    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    libraries: tuple[str, ...]
    seconds: float


@dataclass(frozen=True)
class CallResult:
    """Result of the function."""

    value: Any


@dataclass(frozen=True)
class CallError:
    """Exception of the function."""

    error: Exception


@dataclass(frozen=True)
class ProcessEnd:
    """Notice that the process that ran the function has ended.

    Parameters
    ----------
    signal : int
        Signal that ended the process; 0 if it exited by itself.
    """

    signal: int


Request = Libraries | Call
Answer = CallResult | CallError | ProcessEnd
