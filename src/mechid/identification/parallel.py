"""The one map over independent tasks. Kernels release the interpreter's lock, so threads suffice."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from joblib import Parallel, delayed

Task = TypeVar("Task")
Result = TypeVar("Result")


def mapped(function: Callable[[Task], Result], tasks: Sequence[Task], workers: int) -> list[Result]:
    """Return ``[function(t) for t in tasks]``, worked on by `workers` threads."""
    if workers == 1 or len(tasks) < 2:
        return [function(t) for t in tasks]
    return list(Parallel(n_jobs=workers, backend="threading")(delayed(function)(t) for t in tasks))
