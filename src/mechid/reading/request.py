"""What is asked of the process that reads, and what it answers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Libraries:
    """Modules that will be needed, to be imported ahead."""

    names: tuple[str, ...]


@dataclass(frozen=True)
class Call:
    """A function of a module, to be called.

    Parameters
    ----------
    function : callable
    arguments : tuple
        What pickles.
    libraries : tuple of str
        Modules that it needs: imported once, where no file has been read, and there for each that reads.
    seconds : float
        Time after which it is ended.
    """

    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    libraries: tuple[str, ...]
    seconds: float


@dataclass(frozen=True)
class Returned:
    """What the function returned."""

    value: Any


@dataclass(frozen=True)
class Raised:
    """What the function raised."""

    error: Exception


@dataclass(frozen=True)
class Ended:
    """The process that called the function is no more.

    Parameters
    ----------
    signal : int
        What ended it; 0 where it ended by itself.
    """

    signal: int


Request = Libraries | Call
Answer = Returned | Raised | Ended
