"""The one map over independent tasks: threads of this process, or the workers that somebody lends.

Kernels release the interpreter's lock, so threads suffice on one machine. Work goes elsewhere within
`mechid.identification.computation.workforce.working_on`.
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
"""The number of a task, its result and the seconds that it took."""
Ended = Callable[[Sequence[Done[Result]]], None]
"""Called with all that has ended since the last call."""


class Elsewhere(Protocol):
    """Who maps in place of this process."""

    def mapped(self, function: Callable[[Any], Any], tasks: Sequence[Any], ended: Ended[Any]) -> list[Any]:
        """Return ``[function(t) for t in tasks]``."""


_elsewhere: ContextVar[Elsewhere | None] = ContextVar("elsewhere", default=None)
_alone: ContextVar[bool] = ContextVar("alone", default=False)


class _AbandonedError(BaseException):
    """Ends a task whose result nobody waits for any more."""


@contextmanager
def mapped_by(elsewhere: Elsewhere) -> Iterator[None]:
    """Let `elsewhere` do what `mapped` is asked for within."""
    token = _elsewhere.set(elsewhere)
    try:
        yield
    finally:
        _elsewhere.reset(token)


def _unheard(done: object) -> None:
    """Listen to nothing."""


def mapped(
    function: Callable[[Task], Result],
    tasks: Sequence[Task],
    workers: int,
    ended: Ended[Result] = _unheard,
) -> list[Result]:
    """Return ``[function(t) for t in tasks]``, worked on by `workers` threads, or elsewhere.

    Parameters
    ----------
    function : callable
        Of a task, a pure function that pickles: of a module, or such a one with its first arguments given by
        `functools.partial`. What all tasks share, as the problem, is given there: it goes once to each worker.
    tasks : sequence
        What pickles, small each: a point, a number, a name.
    workers : int
        Threads, where the work stays in this process.
    ended : callable
        Called in this process with the tasks that have ended, in any order; by several threads where these do the work.

    Raises
    ------
    WorkersError
        Lent workers are lost, or cannot do the work.
    """
    elsewhere = _elsewhere.get()
    if elsewhere is not None:
        found = elsewhere.mapped(
            partial(with_work, function), tasks, lambda done: ended([(n, result, s) for n, (result, _), s in done])
        )
        count(sum(work for _, work in found))
        return [result for result, _ in found]
    return in_threads(function, tasks, workers, ended)


def with_work(function: Callable[[Task], Result], task: Task) -> tuple[Result, int]:
    """Return what a function gives of a task, and the work that it took."""
    with work_counter() as own:
        result = function(task)
    return result, own.done


def in_threads(
    function: Callable[[Task], Result],
    tasks: Sequence[Task],
    workers: int,
    ended: Ended[Result] = _unheard,
) -> list[Result]:
    """Return ``[function(t) for t in tasks]``, worked on by `workers` threads of this process.

    For what is too short to be sent, as one record at one point, and for what itself waits for others' work. A thread
    works in the caller's context, so what interrupts the caller's simulations interrupts its own too. Where one task
    fails, or Ctrl-C comes, those at work end with their next block of samples.
    """

    def one(number: int) -> Result:
        began = time.perf_counter()
        result = function(tasks[number])
        ended([(number, result, time.perf_counter() - began)])
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
            abandoned.set()  # here, not where the caller waits: under load it wakes after the others' next tasks
            raise

    with interrupt_by(check):
        contexts = [copy_context() for _ in tasks]  # each is entered by one thread at a time
    with ThreadPoolExecutor(min(workers, len(tasks))) as threads:
        try:
            futures = [threads.submit(own.run, one_of_all, i) for i, own in enumerate(contexts)]
            wait(futures, return_when=FIRST_EXCEPTION)
            _raise_what_failed(futures)
            return [future.result() for future in futures]
        except BaseException:
            abandoned.set()
            threads.shutdown(wait=False, cancel_futures=True)
            raise


def _raise_what_failed(futures: Sequence[Future[Any]]) -> None:
    """Raise the error of the first task that failed by itself, or else of the first that was abandoned with it."""
    errors = [error for future in futures if future.done() and (error := future.exception()) is not None]
    if errors:
        raise min(errors, key=lambda error: isinstance(error, _AbandonedError))


def is_lent() -> bool:
    """Return whether `mapped` is done elsewhere."""
    return _elsewhere.get() is not None


def is_alone() -> bool:
    """Return whether others have the other cores (see `on_one_core`)."""
    return _alone.get()


def directed(function: Callable[[Task], Result], tasks: Sequence[Task], workers: int) -> list[Result]:
    """Return ``[function(t) for t in tasks]``, tasks that do next to nothing but ask `mapped` for one thing at a time.

    They are threads of this process: `workers` of them, or all at once where the work itself is done elsewhere.
    """
    return in_threads(function, tasks, len(tasks) if is_lent() else workers)


@contextmanager
def on_one_core() -> Iterator[None]:
    """Do all that is mapped within one task after the other, on one core: others have the cores beside it."""
    alone, elsewhere = _alone.set(True), _elsewhere.set(None)
    try:
        with one_core_algebra():
            yield
    finally:
        _alone.reset(alone)
        _elsewhere.reset(elsewhere)


def one_core_algebra() -> threadpool_limits:
    """Return a context in which linear algebra keeps to one core.

    Our matrices are small: shared among cores, each factorisation costs ten times more than it saves.
    """
    return threadpool_limits(limits=1, user_api="blas")
