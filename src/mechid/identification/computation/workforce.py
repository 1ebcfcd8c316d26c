"""Distribution of tasks to an external executor, as the workers of a Dask scheduler."""

from __future__ import annotations

import hashlib
import logging
import math
import os
import pickle
import sys
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from statistics import median
from typing import Any

from mechid.errors import UsageError, WorkersError
from mechid.identification.computation.parallel import Done, Ended, mapped_by
from mechid.identification.computation.progress import Tell
from mechid.identification.computation.settings import WORK
from mechid.identification.computation.worker import (
    DONE,
    LACKING,
    REFUSED,
    Answer,
    Batch,
    installation,
    processor,
    work,
)
from mechid.simulation.interruption import check_interruption


def warn(line: str) -> None:
    """Tell by a warning."""
    warnings.warn(line, stacklevel=2)


@contextmanager
def working_on(executor: Executor | None, say: Tell = warn) -> Iterator[None]:
    """Let the workers of an executor do what is mapped within; None leaves it to the threads of this process.

    Parameters
    ----------
    executor : concurrent.futures.Executor or None
        As ``ProcessPoolExecutor()``, ``distributed.Client(...).get_executor()``, ``mpi4py.futures.MPIPoolExecutor()``.
        It stays open.
    say : callable
        Called with a line on what is odd about a worker.
    """
    if executor is None:
        yield
        return
    with mapped_by(Workforce(executor, say)):
        yield


@dataclass(eq=False)
class _Parcel:
    """A function with all that its tasks share: pickled, its digest, and the same as a value of a Dask cluster.

    `owed` is how many workers have not been sent it.
    """

    function: Callable[[Any], Any]
    digest: str
    content: bytes
    on_cluster: Any | None
    owed: int

    def to_send(self, *, lacking: bool) -> Any | None:
        """Return what goes with a batch, None where its worker should know the function."""
        if self.on_cluster is not None:
            return self.on_cluster
        if not lacking and self.owed <= 0:
            return None
        self.owed -= 1
        return self.content


class Workforce:
    """The workers of an executor, and what they have been given."""

    def __init__(self, executor: Executor, say: Tell = warn) -> None:
        self.executor, self.say = executor, say
        self.seen: set[str] = set()
        self.said: set[str] = set()
        self.parcel: _Parcel | None = None

    def mapped(self, function: Callable[[Any], Any], tasks: Sequence[Any], ended: Ended[Any]) -> list[Any]:
        """Return ``[function(t) for t in tasks]``.

        Raises
        ------
        WorkersError
            All workers or their scheduler are lost, or one has another mechid.
        """
        if not tasks:
            return []
        course = _Course(self, self._packed(function), tasks, ended)
        try:
            return course.done()
        finally:
            course.cancel()

    def width(self) -> int:
        """Return how many batches can be at work at once, as far as that is known."""
        client = _dask_client(self.executor)
        known = sum(client.nthreads().values()) if client else getattr(self.executor, "_max_workers", os.cpu_count())
        return max(int(known or 1), 1)

    def met(self, worker: str, batch: Batch) -> None:
        """Tell once what is odd about a worker."""
        host = worker.rpartition(":")[0]
        remarks = list(batch.remarks)
        if batch.processor != processor():
            remarks.append(f"has another processor, {batch.processor} for {processor()} here: last digits may differ")
        for line in (f"worker {host}: {remark}" for remark in remarks):
            if line not in self.said:
                self.said.add(line)
                self.say(line)

    def _packed(self, function: Callable[[Any], Any]) -> _Parcel:
        """Return a function ready to be sent; the last one is kept, since maps over one problem follow one another."""
        last = self.parcel
        if last is not None and _is_same(last.function, function):
            return last
        content = pickle.dumps(function, protocol=pickle.HIGHEST_PROTOCOL)
        digest = hashlib.sha256(content).hexdigest()
        client = _dask_client(self.executor)
        made = _Parcel(function, digest, content, _on_cluster(client, content) if client else None, self.width())
        self.parcel = made
        return made


def _is_same(one: object, other: object) -> bool:
    """Tell whether two functions are one and the same, or were made of the same one and the same arguments."""
    if one is other or not (isinstance(one, partial) and isinstance(other, partial)):
        return one is other
    made_of = [(each.func, *each.args, *each.keywords.values()) for each in (one, other)]
    return [*one.keywords] == [*other.keywords] and all(map(_is_same, *made_of)) and len(made_of[0]) == len(made_of[1])


def _dask_client(executor: Executor) -> Any | None:
    """Return the client of a Dask executor; None for another one."""
    dask = sys.modules.get("distributed.cfexecutor")
    return executor._client if dask and isinstance(executor, dask.ClientExecutor) else None


def _on_cluster(client: Any, content: bytes) -> Any:
    """Return a value of a Dask cluster, made by a task: one that was only put there is gone with its worker."""
    import dask

    with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1GB"}):
        return client.submit(bytes, content, pure=False)


@dataclass(eq=False)
class _Course:
    """One map on its way."""

    force: Workforce
    parcel: _Parcel
    tasks: Sequence[Any]
    ended: Ended[Any]
    results: dict[int, Any] = field(default_factory=dict)
    running: dict[Future[Answer], list[int]] = field(default_factory=dict)
    seconds: deque[float] = field(default_factory=lambda: deque(maxlen=WORK.recent))

    def done(self) -> list[Any]:
        """Send all batches, take what comes back, and return it in order."""
        todo, width = deque(range(len(self.tasks))), self.force.width()
        while todo or self.running:
            width = max(width, len(self.force.seen))
            while todo and len(self.running) < WORK.ahead * width:
                size = self._size(len(todo), width)
                self._send([todo.popleft() for _ in range(size)], lacking=False)
            check_interruption()
            ready, _ = wait(self.running, timeout=WORK.asked_s, return_when=FIRST_COMPLETED)
            self._take(ready)
        return [self.results[i] for i in range(len(self.tasks))]

    def cancel(self) -> None:
        """Take back what is still under way."""
        for future in self.running:
            future.cancel()

    def _size(self, left: int, width: int) -> int:
        """Return how many tasks the next batch has: as take long enough, and no more than leaves the others as many."""
        batch_s = max(WORK.batch_s, WORK.served_s * width)
        wanted = math.ceil(batch_s / max(median(self.seconds), 1e-6)) if self.seconds else 1
        return max(min(wanted, math.ceil(left / width)), 1)

    def _send(self, batch: list[int], *, lacking: bool) -> None:
        """Send a batch, with what it needs where the worker has said that it lacks that."""
        content = pickle.dumps([self.tasks[i] for i in batch], protocol=pickle.HIGHEST_PROTOCOL)
        function = self.parcel.to_send(lacking=lacking)
        try:
            future = self.force.executor.submit(work, installation(), self.parcel.digest, function, content)
        except Exception as error:
            raise _lost(error) from error
        self.running[future] = batch

    def _take(self, ready: Iterable[Future[Answer]]) -> None:
        """Take what has come back of all batches that are ready, and raise then what one of them has raised."""
        done: list[Done[Any]] = []
        faults: list[Exception] = []
        for future in ready:
            try:
                done.extend(self._of(future, self.running.pop(future)))
            except Exception as error:
                faults.append(error)
        if done:
            self.ended(done)
        if faults:
            raise faults[0]

    def _of(self, future: Future[Answer], batch: list[int]) -> Iterator[Done[Any]]:
        """Yield what has come back of a batch; nothing where it is to be sent again."""
        try:
            how, worker, content = future.result()
        except Exception as error:
            raise _lost(error) from error
        self.force.seen.add(worker)
        if how == REFUSED:
            raise WorkersError(
                f"worker {worker.rpartition(':')[0]} is refused: it has {content.decode()}; here is "
                f"{installation()}; install the same there, or leave it out"
            )
        if how == LACKING:
            self._send(batch, lacking=True)
            return
        assert how == DONE
        found = pickle.loads(content)
        self.force.met(worker, found)
        self.seconds.extend(found.seconds)
        for i, result, seconds in zip(batch, found.results, found.seconds, strict=False):
            self.results[i] = result
            yield i, result, seconds
        if found.error is not None:
            raise found.error


def _lost(error: BaseException) -> WorkersError:
    """Return what is said where workers, or who gives them work, are gone."""
    what = " ".join(f"{type(error).__name__}: {error}".split())
    if isinstance(error, CancelledError):
        what = "their scheduler is gone"
    return WorkersError(
        f"the workers are lost ({what}); what they had finished is kept where there is a journal: "
        "--resume goes on, also without them"
    )


QUIET = ("distributed", "distributed.client", "distributed.core", "distributed.comm", "asyncio", "tornado.application")
"""Loggers that print a traceback where a connection is lost; a scheduler may also go when its work is done."""


@contextmanager
def lent_by(address: str | None, say: Tell = warn) -> Iterator[None]:
    """Let the workers of the Dask scheduler at an address do what is mapped within; None leaves it to this process.

    Parameters
    ----------
    address : str or None
        As ``tcp://host:8786``, which a scheduler writes when it starts.
    say : callable
        Called with a line on what is odd about workers.

    Raises
    ------
    UsageError
        Dask is not installed.
    WorkersError
        There is no scheduler at the address, or it is lost on the way.
    """
    if address is None:
        yield
        return
    with _client(address) as client:
        if not client.nthreads():
            say(f"scheduler {address}: it has no workers yet; waiting for them")
        with working_on(client.get_executor(), say):
            yield


def _client(address: str) -> Any:
    """Return a client of a scheduler; what that would say of a lost connection is said in the error."""
    try:
        from distributed import Client
    except ImportError as error:
        raise UsageError('--scheduler needs Dask; install it with pip install "mechid[cluster]"') from error
    for name in QUIET:
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        return Client(address, timeout=WORK.scheduler_patience_s, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        what = " ".join(str(error).split())
        raise WorkersError(
            f"--scheduler {address}: no Dask scheduler answers there ({what}); "
            "give the address that it writes when it starts, as tcp://host:8786"
        ) from error
