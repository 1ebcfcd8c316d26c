"""Identification in a thread: its reports, its state, and its cancellation."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from enum import Enum

from mechid.errors import MechidError
from mechid.identification.computation.progress import Listener, Progress
from mechid.simulation.interruption import interrupt_by
from mechid.web.estimate import Estimate

Work = Callable[[Listener], Estimate]


class RunState(Enum):
    """State of a run, in words."""

    RUNNING = "running"
    FINISHED = "finished"
    CANCELLED = "cancelled"
    FAILED = "failed"


class _CancelledError(BaseException):
    """Ends the work at the next block of samples; a BaseException, so that no handler of errors catches it."""


class FitRun:
    """Run of a fit in its own thread; `reports` only grows, and `state` leaves RUNNING once.

    Parameters
    ----------
    work : callable
        Takes a listener and returns the estimate.
    """

    is_elsewhere = False

    def __init__(self, work: Work) -> None:
        self.work = work
        self.began = self.ended = time.perf_counter()
        self.reports: list[Progress] = []
        self.state = RunState.RUNNING
        self.result: Estimate | None = None
        self.fault = ""
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="fit", daemon=True)

    @property
    def elapsed_s(self) -> float:
        """Seconds since the start, or total duration."""
        return (time.perf_counter() if self.state is RunState.RUNNING else self.ended) - self.began

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def cancel(self) -> None:
        """Request a stop and discard the results so far."""
        self._stop.set()
        if self.state is RunState.RUNNING:
            self.ended, self.state = time.perf_counter(), RunState.CANCELLED

    def wait(self, seconds: float) -> bool:
        """Wait for the thread; return whether it has ended."""
        self._thread.join(seconds)
        return not self._thread.is_alive()

    def _check(self) -> None:
        if self._stop.is_set():
            raise _CancelledError

    def _listen(self, progress: Progress) -> None:
        self._check()
        self.reports.append(progress)

    def _run(self) -> None:
        try:
            # The kernel calls the check between blocks, which limits the time until a cancellation.
            with interrupt_by(self._check):
                result = self.work(self._listen)
        except _CancelledError:
            return
        except MechidError as error:
            self._end(RunState.FAILED, str(error))
        except Exception as error:
            self._end(RunState.FAILED, " ".join(f"{type(error).__name__}: {error}".split()))
        else:
            self.result = result
            self._end(RunState.FINISHED)

    def _end(self, state: RunState, fault: str = "") -> None:
        if not self._stop.is_set():
            self.fault, self.ended, self.state = fault, time.perf_counter(), state
