"""Ending a computation that is at work: whoever began it is asked, once a block, whether it is to go on.

All long work simulates, wherever in a search, in its standard errors or in a verdict it is; so the one loop over blocks
asks. What holds here is set for what is begun within a ``with``, not for the process: another thread's fit goes on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

Check = Callable[[], None]


def _go_on() -> None:
    pass


_check: ContextVar[Check] = ContextVar("interruption", default=_go_on)


@contextmanager
def interrupted_by(check: Check) -> Iterator[None]:
    """Ask `check` before each block that is simulated within, beside what is asked outside; it raises to end the work.

    Parameters
    ----------
    check : callable
        Without arguments, quick, and callable from several threads at once. What it raises should be no `Exception`
        where nothing on its way is to take it for a fault of the simulation.

    Examples
    --------
    >>> with interrupted_by(lambda: print("asked")):
    ...     ask()
    asked
    >>> ask()
    """
    outer = _check.get()

    def both() -> None:
        outer()
        check()

    token = _check.set(both)
    try:
        yield
    finally:
        _check.reset(token)


def ask() -> None:
    """Ask whether to go on; raises what ends the work."""
    _check.get()()
