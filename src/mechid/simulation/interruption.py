"""Interruption of a running computation by a check that is called once per block.

All long computations simulate, whether in a search, in standard errors or in a verdict, so the one loop over blocks
calls the check. The check applies to the work inside a ``with`` block, not to the process: fits in other threads
are not affected.
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
def interrupt_by(check: Check) -> Iterator[None]:
    """Call `check` before each block simulated inside, in addition to outer checks; it raises to end the work.

    Parameters
    ----------
    check : callable
        Takes no arguments, is fast and may be called from several threads at once. It should raise an exception that is
        not an `Exception`, if no handler in between may mistake it for a failed simulation.

    Examples
    --------
    >>> with interrupt_by(lambda: print("asked")):
    ...     check_interruption()
    asked
    >>> check_interruption()
    """
    # Checks nest: an inner one must not hide those outside.
    outer = _check.get()

    def both() -> None:
        outer()
        check()

    token = _check.set(both)
    try:
        yield
    finally:
        _check.reset(token)


def check_interruption() -> None:
    """Call the current check, which raises to end the work."""
    _check.get()()
