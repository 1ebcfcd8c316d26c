"""The one map over independent tasks. Kernels release the interpreter's lock, so threads suffice."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from joblib import Parallel, delayed
from threadpoolctl import threadpool_limits

Task = TypeVar("Task")
Result = TypeVar("Result")


def mapped(function: Callable[[Task], Result], tasks: Sequence[Task], workers: int) -> list[Result]:
    """Return ``[function(t) for t in tasks]``, worked on by `workers` threads."""
    if workers == 1 or len(tasks) < 2:
        return [function(t) for t in tasks]
    return list(Parallel(n_jobs=workers, backend="threading")(delayed(function)(t) for t in tasks))


def one_core_algebra() -> threadpool_limits:
    """Return a context in which linear algebra keeps to one core.

    Our matrices are small: shared among cores, each factorisation costs ten times more than it saves.
    """
    return threadpool_limits(limits=1, user_api="blas")
