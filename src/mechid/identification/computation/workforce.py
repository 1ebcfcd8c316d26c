"""Distribution of tasks to an external executor, such as the workers of a Dask scheduler."""

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
from mechid.identification.computation.parallel import Done, OnDone, mapping_through
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
    """Issue a line as a warning."""
    warnings.warn(line, stacklevel=2)


@contextmanager
def working_on(executor: Executor | None, say: Tell = warn) -> Iterator[None]:
    """Within this context, let the workers of an executor execute mapped tasks; None uses threads of this process.

    Parameters
    ----------
    executor : concurrent.futures.Executor or None
        Such as ``ProcessPoolExecutor()``, ``distributed.Client(...).get_executor()`` or
        ``mpi4py.futures.MPIPoolExecutor()``. It stays open.
    say : callable
        Called with a line about each irregularity of a worker.
    """
    if executor is None:
        yield
        return
    with mapping_through(Workforce(executor, say)):
        yield


@dataclass(eq=False)
class _PackedFunction:
    """Pickled function with the data that its tasks share, its digest, and its copy on a Dask cluster.

    `unsent` is the number of workers that have not received it.
    """

    function: Callable[[Any], Any]
    digest: str
    content: bytes
    on_cluster: Any | None
    unsent: int

    def content_to_send(self, *, lacking: bool) -> Any | None:
        """Return the content to send with a batch, None if its worker should have the function."""
        if self.on_cluster is not None:
            return self.on_cluster
        if not lacking and self.unsent <= 0:
            return None
        self.unsent -= 1
        return self.content


class Workforce:
    """Workers of an executor, and the function that they have received."""

    def __init__(self, executor: Executor, say: Tell = warn) -> None:
        self.executor, self.say = executor, say
        self.seen: set[str] = set()
        self.reported: set[str] = set()
        self.parcel: _PackedFunction | None = None

    def map_tasks(self, function: Callable[[Any], Any], tasks: Sequence[Any], on_done: OnDone[Any]) -> list[Any]:
        """Return ``[function(t) for t in tasks]``.

        Raises
        ------
        WorkersError
            All workers or their scheduler are lost, or one has another mechid.
        """
        if not tasks:
            return []
        task_map = _TaskMap(self, self._pack_function(function), tasks, on_done)
        try:
            return task_map.run()
        finally:
            task_map.cancel()

    def width(self) -> int:
        """Return the number of batches that can run at once, as far as it is known."""
        client = _dask_client(self.executor)
        known = sum(client.nthreads().values()) if client else getattr(self.executor, "_max_workers", os.cpu_count())
        return max(int(known or 1), 1)

    def report_oddities(self, worker: str, batch: Batch) -> None:
        """Report each irregularity of a worker once."""
        host = worker.rpartition(":")[0]
        remarks = list(batch.remarks)
        if batch.processor != processor():
            remarks.append(f"has another processor, {batch.processor} for {processor()} here: last digits may differ")
        for line in (f"worker {host}: {remark}" for remark in remarks):
            if line not in self.reported:
                self.reported.add(line)
                self.say(line)

    def _pack_function(self, function: Callable[[Any], Any]) -> _PackedFunction:
        """Return a function ready to be sent.

        The last one is kept, because maps over one problem follow one another.
        """
        last = self.parcel
        if last is not None and _is_same(last.function, function):
            return last
        content = pickle.dumps(function, protocol=pickle.HIGHEST_PROTOCOL)
        digest = hashlib.sha256(content).hexdigest()
        client = _dask_client(self.executor)
        made = _PackedFunction(
            function, digest, content, _on_cluster(client, content) if client else None, self.width()
        )
        self.parcel = made
        return made


def _is_same(one: object, other: object) -> bool:
    """Tell whether two functions are identical, or partial functions of the same one with identical arguments."""
    if one is other or not (isinstance(one, partial) and isinstance(other, partial)):
        return one is other
    made_of = [(each.func, *each.args, *each.keywords.values()) for each in (one, other)]
    return [*one.keywords] == [*other.keywords] and all(map(_is_same, *made_of)) and len(made_of[0]) == len(made_of[1])


def _dask_client(executor: Executor) -> Any | None:
    """Return the client of a Dask executor; None for any other one."""
    dask = sys.modules.get("distributed.cfexecutor")
    return executor._client if dask and isinstance(executor, dask.ClientExecutor) else None


def _on_cluster(client: Any, content: bytes) -> Any:
    """Return a value on a Dask cluster."""
    import dask

    with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1GB"}):
        # A task computes the value: one that was only stored there would be lost with its worker.
        return client.submit(bytes, content, pure=False)


@dataclass(eq=False)
class _TaskMap:
    """One map in progress."""

    force: Workforce
    parcel: _PackedFunction
    tasks: Sequence[Any]
    on_done: OnDone[Any]
    results: dict[int, Any] = field(default_factory=dict)
    running: dict[Future[Answer], list[int]] = field(default_factory=dict)
    seconds: deque[float] = field(default_factory=lambda: deque(maxlen=WORK.recent))

    def run(self) -> list[Any]:
        """Send all batches, receive their results, and return them in order."""
        todo, width = deque(range(len(self.tasks))), self.force.width()
        while todo or self.running:
            # Workers may join later, so that more batches can run than at the start.
            width = max(width, len(self.force.seen))
            while todo and len(self.running) < WORK.ahead * width:
                size = self._size(len(todo), width)
                self._send([todo.popleft() for _ in range(size)], lacking=False)
            check_interruption()
            ready, _ = wait(self.running, timeout=WORK.asked_s, return_when=FIRST_COMPLETED)
            self._take(ready)
        return [self.results[i] for i in range(len(self.tasks))]

    def cancel(self) -> None:
        """Cancel the batches in flight."""
        for future in self.running:
            future.cancel()

    def _size(self, left: int, width: int) -> int:
        """Return the size of the next batch: long enough, but leaving as many tasks for each other worker."""
        batch_s = max(WORK.batch_s, WORK.served_s * width)
        # Batches start with one task, until the first times are known.
        wanted = math.ceil(batch_s / max(median(self.seconds), 1e-6)) if self.seconds else 1
        return max(min(wanted, math.ceil(left / width)), 1)

    def _send(self, batch: list[int], *, lacking: bool) -> None:
        """Send a batch, including the function if the worker reported that it lacks it."""
        content = pickle.dumps([self.tasks[i] for i in batch], protocol=pickle.HIGHEST_PROTOCOL)
        function = self.parcel.content_to_send(lacking=lacking)
        try:
            future = self.force.executor.submit(work, installation(), self.parcel.digest, function, content)
        except Exception as error:
            raise _workers_lost(error) from error
        self.running[future] = batch

    def _take(self, ready: Iterable[Future[Answer]]) -> None:
        """Process all finished batches, and then raise the first error among them."""
        done: list[Done[Any]] = []
        faults: list[Exception] = []
        for future in ready:
            try:
                done.extend(self._results_of(future, self.running.pop(future)))
            except Exception as error:
                faults.append(error)
        # Finished results are reported before an error is raised, so that a journal keeps them.
        if done:
            self.on_done(done)
        if faults:
            raise faults[0]

    def _results_of(self, future: Future[Answer], batch: list[int]) -> Iterator[Done[Any]]:
        """Yield the results of a batch; nothing if it must be sent again."""
        try:
            how, worker, content = future.result()
        except Exception as error:
            raise _workers_lost(error) from error
        self.force.seen.add(worker)
        if how == REFUSED:
            raise WorkersError(
                f"worker {worker.rpartition(':')[0]} is refused: it has {content.decode()}; here is "
                f"{installation()}; install the same version there, or exclude the worker"
            )
        if how == LACKING:
            self._send(batch, lacking=True)
            return
        assert how == DONE
        found = pickle.loads(content)
        self.force.report_oddities(worker, found)
        self.seconds.extend(found.seconds)
        for i, result, seconds in zip(batch, found.results, found.seconds, strict=False):
            self.results[i] = result
            yield i, result, seconds
        if found.error is not None:
            raise found.error


def _workers_lost(error: BaseException) -> WorkersError:
    """Return the error for lost workers, or a lost scheduler."""
    reason = " ".join(f"{type(error).__name__}: {error}".split())
    if isinstance(error, CancelledError):
        reason = "their scheduler is gone"
    return WorkersError(
        f"the workers are lost ({reason}); a journal, if there is one, keeps their finished work: "
        "continue with --resume, with or without them"
    )


QUIET = ("distributed", "distributed.client", "distributed.core", "distributed.comm", "asyncio", "tornado.application")
"""Loggers that print a traceback when a connection is lost; a scheduler may also close after its work is done."""


@contextmanager
def working_on_scheduler(address: str | None, say: Tell = warn) -> Iterator[None]:
    """Within this context, let the workers of a Dask scheduler execute mapped tasks; None uses this process.

    Parameters
    ----------
    address : str or None
        Such as ``tcp://host:8786``, which a scheduler prints when it starts.
    say : callable
        Called with a line about each irregularity of the workers.

    Raises
    ------
    UsageError
        Dask is not installed.
    WorkersError
        There is no scheduler at the address, or it is lost during the work.
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
    """Return a client of a scheduler, with Dask's own messages silenced in favour of the error raised here."""
    try:
        from distributed import Client
    except ImportError as error:
        raise UsageError('--scheduler needs Dask; install it with pip install "mechid[cluster]"') from error
    for name in QUIET:
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        return Client(address, timeout=WORK.scheduler_patience_s, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        reason = " ".join(str(error).split())
        raise WorkersError(
            f"--scheduler {address}: no Dask scheduler answers there ({reason}); "
            "give the address that it prints when it starts, such as tcp://host:8786"
        ) from error
