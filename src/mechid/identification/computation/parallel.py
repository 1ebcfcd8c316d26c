"""The one map over independent tasks. Kernels release the interpreter's lock, so threads suffice."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextvars import copy_context
from threading import Event
from typing import TypeVar

from joblib import Parallel, delayed
from threadpoolctl import threadpool_limits

from mechid.simulation.interruption import interrupted_by

Task = TypeVar("Task")
Result = TypeVar("Result")


class _AbandonedError(BaseException):
    """Ends a task whose result nobody waits for any more."""


def mapped(function: Callable[[Task], Result], tasks: Sequence[Task], workers: int) -> list[Result]:
    """Return ``[function(t) for t in tasks]``, worked on by `workers` threads.

    A thread works in the caller's context, so what interrupts the caller's simulations interrupts its own too. Where
    one task fails, or Ctrl-C comes, those at work end with their next block of samples.
    """
    if workers == 1 or len(tasks) < 2:
        return [function(t) for t in tasks]
    abandoned = Event()

    def check() -> None:
        if abandoned.is_set():
            raise _AbandonedError

    with interrupted_by(check):
        contexts = [copy_context() for _ in tasks]  # each is entered by one thread at a time
    try:
        jobs = (delayed(own.run)(function, t) for own, t in zip(contexts, tasks, strict=True))
        return list(Parallel(n_jobs=workers, backend="threading")(jobs))
    except BaseException:
        abandoned.set()
        raise


def one_core_algebra() -> threadpool_limits:
    """Return a context in which linear algebra keeps to one core.

    Our matrices are small: shared among cores, each factorisation costs ten times more than it saves.
    """
    return threadpool_limits(limits=1, user_api="blas")
