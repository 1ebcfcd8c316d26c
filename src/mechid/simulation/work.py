"""Work of a search, counted as it is simulated: the same on every machine, whatever else is done there.

A run of n samples with m derivatives takes n n_p (1 + m / 6) units, n_p being the parameters of the kernel. A unit took
3.8 to 5.4 ns of CPU with kernels of 22 and 86 parameters and 0 to 68 derivatives: a parameter that stands at its null
value takes as long as another.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Lock

DERIVATIVES_A_RUN = 6
"""Derivatives that take as long as the run itself."""
RUNS_A_BATCH = 4
"""Runs side by side that take as long as one alone."""


class WorkSpentError(BaseException):
    """Ends work whose limit is reached; no `Exception`, which a search may take for a fault of the simulation."""


class Work:
    """A count of work, with a limit; it counts in those around it too.

    Attributes
    ----------
    done : int
    limit : float
        From which on whatever counts raises `WorkSpentError`.
    """

    def __init__(self, limit: float = math.inf, outer: Work | None = None) -> None:
        self.done, self.limit, self.outer = 0, limit, outer
        self._lock = Lock()

    @property
    def is_spent(self) -> bool:
        """Whether the limit is reached."""
        return self.done > self.limit

    def add(self, work: int) -> None:
        """Count so much more work.

        Raises
        ------
        WorkSpentError
            The limit is reached, or that of a count around.
        """
        with self._lock:
            self.done += work
        if self.outer is not None:
            self.outer.add(work)
        if self.is_spent:
            raise WorkSpentError


_counted: ContextVar[Work | None] = ContextVar("work", default=None)


@contextmanager
def counted(limit: float = math.inf) -> Iterator[Work]:
    """Count the work that is done within, and end it by `WorkSpentError` where it takes more than a limit.

    Examples
    --------
    >>> with counted() as work:
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
def uncounted() -> Iterator[None]:
    """Do what is within whatever limit is reached; it counts nowhere."""
    token = _counted.set(None)
    try:
        yield
    finally:
        _counted.reset(token)


def count(work: int) -> None:
    """Count work; raises `WorkSpentError` where a limit is reached."""
    own = _counted.get()
    if own is not None and work:
        own.add(work)


def work_of_run(samples: int, parameters: int, derivatives: int) -> int:
    """Return the work of a run, in units."""
    return samples * parameters * (DERIVATIVES_A_RUN + derivatives) // DERIVATIVES_A_RUN


def count_run(steps: int, parameters: int, derivatives: int) -> None:
    """Count the work of so many steps of a run."""
    count(work_of_run(steps, parameters, derivatives))


def count_batch(steps: int, parameters: int) -> None:
    """Count the work of so many steps, those of all runs together, of runs side by side without derivatives."""
    count(work_of_run(steps, parameters, 0) // RUNS_A_BATCH)
