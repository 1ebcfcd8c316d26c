"""Map over independent tasks: in threads of this process, or through an external executor.

Kernels release the interpreter's lock, so threads suffice on one machine. Within
`mechid.identification.computation.workforce.working_on`, the tasks go to an external executor.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_EXCEPTION, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from contextvars import ContextVar, copy_context
from functools import partial
from threading import Event
from typing import Any, Protocol, TypeVar

from threadpoolctl import threadpool_limits

from mechid.simulation.interruption import interrupt_by
from mechid.simulation.work import count, work_counter

Task = TypeVar("Task")
Result = TypeVar("Result")
Done = tuple[int, Result, float]
"""Number of a task, its result and its time in seconds."""
OnDone = Callable[[Sequence[Done[Result]]], None]
"""Function that is called with all tasks that have ended since the last call."""


class ExternalMap(Protocol):
    """Map outside of this process."""

    def map_tasks(self, function: Callable[[Any], Any], tasks: Sequence[Any], on_done: OnDone[Any]) -> list[Any]:
        """Return ``[function(t) for t in tasks]``."""


_external_map: ContextVar[ExternalMap | None] = ContextVar("external", default=None)
_alone: ContextVar[bool] = ContextVar("alone", default=False)


class _AbandonedError(BaseException):
    """Ends a task whose result is no longer needed."""


@contextmanager
def mapping_through(external: ExternalMap) -> Iterator[None]:
    """Within this context, let `external` execute the tasks of `map_tasks`."""
    token = _external_map.set(external)
    try:
        yield
    finally:
        _external_map.reset(token)


def _ignore(done: object) -> None:
    """Ignore a report."""


def map_tasks(
    function: Callable[[Task], Result],
    tasks: Sequence[Task],
    workers: int,
    on_done: OnDone[Result] = _ignore,
) -> list[Result]:
    """Return ``[function(t) for t in tasks]``, computed by `workers` threads, or externally.

    Parameters
    ----------
    function : callable
        Pure function of a task that pickles: a function of a module, or such a function with its first arguments
        bound by `functools.partial`. Data shared by all tasks, as the problem, is bound there: it is sent once to
        each worker.
    tasks : sequence
        Small objects that pickle: points, numbers, names.
    workers : int
        Threads, if the work stays in this process.
    on_done : callable
        Called in this process with the tasks that have ended, in any order; by several threads if these do the work.

    Raises
    ------
    WorkersError
        External workers are lost, or cannot do the work.
    """
    external = _external_map.get()
    if external is not None:
        found = external.map_tasks(
            partial(count_work, function), tasks, lambda done: on_done([(n, result, s) for n, (result, _), s in done])
        )
        count(sum(work for _, work in found))
        return [result for result, _ in found]
    return in_threads(function, tasks, workers, on_done)


def count_work(function: Callable[[Task], Result], task: Task) -> tuple[Result, int]:
    """Return the result of a function for a task, and the work that it took."""
    with work_counter() as own:
        result = function(task)
    return result, own.done


def in_threads(
    function: Callable[[Task], Result],
    tasks: Sequence[Task],
    workers: int,
    on_done: OnDone[Result] = _ignore,
) -> list[Result]:
    """Return ``[function(t) for t in tasks]``, computed by `workers` threads of this process.

    It serves tasks that are too short to be sent, as one record at one point, and tasks that themselves wait for
    external work. A thread runs in the caller's context, so interrupts of the caller's simulations also reach its own.
    If a task fails, or Ctrl-C is pressed, the running tasks end with their next block of samples.
    """

    def one(number: int) -> Result:
        began = time.perf_counter()
        result = function(tasks[number])
        on_done([(number, result, time.perf_counter() - began)])
        return result

    if workers == 1 or len(tasks) < 2 or _alone.get():
        return [one(i) for i in range(len(tasks))]
    abandoned = Event()

    def check() -> None:
        if abandoned.is_set():
            raise _AbandonedError

    def one_of_all(number: int) -> Result:
        check()
        try:
            return one(number)
        except BaseException:
            # Set here and not where the caller waits, which under load may wake after further tasks have initial.
            abandoned.set()
            raise

    with interrupt_by(check):
        # One context for each task, because only one thread at a time can enter a context.
        contexts = [copy_context() for _ in tasks]
    with ThreadPoolExecutor(min(workers, len(tasks))) as threads:
        try:
            futures = [threads.submit(own.run, one_of_all, i) for i, own in enumerate(contexts)]
            wait(futures, return_when=FIRST_EXCEPTION)
            _raise_first_error(futures)
            return [future.result() for future in futures]
        except BaseException:
            abandoned.set()
            threads.shutdown(wait=False, cancel_futures=True)
            raise


def _raise_first_error(futures: Sequence[Future[Any]]) -> None:
    """Raise the error of the first task that failed by itself, or else that of the first abandoned one."""
    errors = [error for future in futures if future.done() and (error := future.exception()) is not None]
    if errors:
        raise min(errors, key=lambda error: isinstance(error, _AbandonedError))


def is_external() -> bool:
    """Tell whether `map_tasks` uses an external executor."""
    return _external_map.get() is not None


def is_on_one_core() -> bool:
    """Tell whether the other cores are in use by others (see `on_one_core`)."""
    return _alone.get()


def map_coordinators(function: Callable[[Task], Result], tasks: Sequence[Task], workers: int) -> list[Result]:
    """Return ``[function(t) for t in tasks]`` for tasks that only request one piece of work at a time from `map_tasks`.

    They run in threads of this process: `workers` of them, or all at once if the work itself is external.
    """
    # A coordinator of external work only waits, so that its thread needs no core of its own.
    return in_threads(function, tasks, len(tasks) if is_external() else workers)


@contextmanager
def on_one_core() -> Iterator[None]:
    """Within this context, execute mapped tasks one after the other on one core, because others use the other cores."""
    alone, external = _alone.set(True), _external_map.set(None)
    try:
        with one_core_algebra():
            yield
    finally:
        _alone.reset(alone)
        _external_map.reset(external)


def one_core_algebra() -> threadpool_limits:
    """Return a context in which linear algebra is limited to one core.

    The matrices are small: shared among cores, each factorisation costs ten times more than it saves.
    """
    return threadpool_limits(limits=1, user_api="blas")
