"""Computational work of a search, counted per simulated step, hence identical on every machine.

A run of n samples with m derivatives takes n n_p (1 + m / 6) units, n_p being the number of kernel parameters. A unit
took 3.8 to 5.4 ns of CPU with kernels of 22 and 86 parameters and 0 to 68 derivatives; a parameter at its null value
costs as much as any other.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Lock

DERIVATIVES_A_RUN = 6
"""Number of derivatives that cost as much as the run itself."""
RUNS_A_BATCH = 4
"""Number of simultaneous runs that cost as much as one alone."""


class WorkSpentError(BaseException):
    """Ends work whose limit is exceeded; not an `Exception`, which a search may mistake for a failed simulation."""


class Work:
    """Counter of work with a limit; it also adds to the counter around it.

    Attributes
    ----------
    done : int
    limit : float
        Limit above which counting raises `WorkSpentError`.
    """

    def __init__(self, limit: float = math.inf, outer: Work | None = None) -> None:
        self.done, self.limit, self.outer = 0, limit, outer
        self._lock = Lock()

    @property
    def is_spent(self) -> bool:
        """Whether the limit is exceeded."""
        return self.done > self.limit

    def add(self, work: int) -> None:
        """Add work.

        Raises
        ------
        WorkSpentError
            The limit of this counter, or of one around it, is exceeded.
        """
        # Several threads may count into one counter.
        with self._lock:
            self.done += work
        if self.outer is not None:
            self.outer.add(work)
        if self.is_spent:
            raise WorkSpentError


_counted: ContextVar[Work | None] = ContextVar("work", default=None)


@contextmanager
def work_counter(limit: float = math.inf) -> Iterator[Work]:
    """Count the work done inside, and end it by `WorkSpentError` if it exceeds a limit.

    Examples
    --------
    >>> with work_counter() as work:
    ...     count(3)
    >>> work.done
    3
    """
    own = Work(limit, _counted.get())
    token = _counted.set(own)
    try:
        yield own
    finally:
        _counted.reset(token)


@contextmanager
def suspend_counting() -> Iterator[None]:
    """Work inside the block is not counted and has no limit."""
    token = _counted.set(None)
    try:
        yield
    finally:
        _counted.reset(token)


def count(work: int) -> None:
    """Add work to the current counter; raise `WorkSpentError` if a limit is exceeded."""
    own = _counted.get()
    if own is not None and work:
        own.add(work)


def work_of_run(samples: int, parameters: int, derivatives: int) -> int:
    """Return the work of a run, in units."""
    return samples * parameters * (DERIVATIVES_A_RUN + derivatives) // DERIVATIVES_A_RUN


def count_run(steps: int, parameters: int, derivatives: int) -> None:
    """Count the work of a number of steps of a run."""
    count(work_of_run(steps, parameters, derivatives))


def count_batch(steps: int, parameters: int) -> None:
    """Count the work of a batch without derivatives; `steps` is the sum over its runs."""
    count(work_of_run(steps, parameters, 0) // RUNS_A_BATCH)
