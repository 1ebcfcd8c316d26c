"""Compilation of the kernels that the ladder will need, in another process in parallel with the search.

A compilation holds the interpreter's lock for three quarters of its time, so a thread would cost the search as much as
it saves. The process fills the cache that all processes share. A search that needs a kernel in the making waits for it
and loads it. Errors appear where the kernel is really needed, because the search then compiles it itself.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from threading import Thread
from types import TracebackType
from typing import Self

from mechid.campaign import Campaign
from mechid.identification.computation.parallel import is_on_one_core
from mechid.identification.output_error.problem import Problem
from mechid.identification.stages.families import FREE_FROM_START, Families
from mechid.kernel.compiled import is_compiled, kernel_for, version_folder
from mechid.kernel.source import fingerprint, lanes_for
from mechid.plant.plant import Plant
from mechid.writing import write_atomically

START = "import sys; sys.path[:] = {path!r}; from {module} import compile_layouts; compile_layouts()"
Layout = tuple[Plant, int]
"""A plant, and the number of derivatives that its kernel has room for."""
PIPE_BYTES = 1 << 20
"""Size of the pipe to the process: sending to it never blocks."""
LINE = "the layouts for further effects are compiled in parallel with the search (first time, cached afterwards)"


class CompilationAhead:
    """Context in which kernels are compiled in another process; the process ends with it."""

    def __init__(self) -> None:
        self._child: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.end()

    def start(self, layouts: Callable[[], Iterable[Layout]]) -> bool:
        """Start the process, unless it has been or no core is free for it, and return whether it has started.

        `layouts` is sent to the process, which calls it.
        """
        if not self._may_start:
            return False
        # The child gets this process's import path, however that was set.
        command = START.format(path=[str(place) for place in sys.path], module=__name__)
        try:
            message = pickle.dumps(layouts)
            child = subprocess.Popen(
                [sys.executable, "-P", "-c", command],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                pipesize=PIPE_BYTES,
                # Ctrl-C must reach only the search, which ends this process.
                start_new_session=True,
            )
        # Not picklable, or no processes on this system: the search then compiles by itself.
        except Exception:
            return False
        self._child = child
        assert child.stdin is not None
        with suppress(OSError):
            child.stdin.write(message)
            # The pipe stays open, since its end tells the child that this process is gone.
            child.stdin.flush()
        return True

    def end(self) -> None:
        """End the process at any point; unfinished kernels are compiled again where they are needed."""
        child, self._child = self._child, None
        if child is not None:
            child.kill()
            with suppress(OSError):
                child.communicate()

    @property
    def _may_start(self) -> bool:
        """Whether a second core is free for the process."""
        # Without file locks, two processes would compile the same kernels.
        alone = is_on_one_core() or usable_cores() < 2 or not sys.executable or find_spec("fcntl") is None
        return self._child is None and not alone


class KernelsAhead(CompilationAhead):
    """Context in which the layouts of a campaign's further effects are compiled; the process ends with it.

    Parameters
    ----------
    problem : Problem
        Problem of the mechanism as written.
    campaign : Campaign
    """

    def __init__(self, problem: Problem, campaign: Campaign) -> None:
        super().__init__()
        self.problem, self.campaign = problem, campaign

    def start_if_new(self) -> bool:
        """Start if this mechanism is searched for the first time, with nothing in the cache yet.

        Return whether the process has started.
        """
        mechanism = self.problem.space.mechanism
        mark = self._mark(mechanism.plant)
        if mark.exists() or not self._may_start:
            return False
        with suppress(OSError):
            mark.parent.mkdir(parents=True, exist_ok=True)
            # The mark is written first, so that only one search of a mechanism starts ahead of need.
            write_atomically(mark, "The kernels of its further effects have been begun.\n")
            return self._start()
        return False

    def start_if_missing(self, families: Families) -> bool:
        """Start if a layout of these families, which a search is about to need, is not cached.

        Return whether the process has started.
        """
        return self._may_start and not all(is_compiled(*one) for one in layouts(families)) and self._start()

    @property
    def _may_start(self) -> bool:
        """Whether effects may be added, and a second core is free for the process."""
        options = self.campaign.options
        return (options.terms or options.disturbances != "none") and super()._may_start

    @property
    def _families_without_records(self) -> Families:
        """Families without records, which do not affect layouts and would take long to send."""
        return Families(replace(self.problem, targets=()), replace(self.campaign, records=(), source=None))

    def _mark(self, plant: Plant) -> Path:
        return version_folder() / f"ahead_{fingerprint(plant, lanes_for(self.problem.coordinates.lanes))}.txt"

    def _start(self) -> bool:
        return self.start(partial(layouts, self._families_without_records, self.problem.coordinates.lanes))


def layouts(families: Families, lanes: int | None = None) -> Iterator[Layout]:
    """Yield the plants that the ladder may need, each with its number of derivatives, in order of need.

    Parameters
    ----------
    families : Families
    lanes : int or None
        Derivatives of the mechanism as written; None takes those of the families' problem.
    """
    written = families.plain.space.mechanism
    lanes = families.plain.coordinates.lanes if lanes is None else lanes
    if families.superset is not None:
        yield families.record_layout, lanes + len(FREE_FROM_START)
    if families.superset is not None and families.allows_terms:
        plant = families.superset.mechanism.plant
        yield plant, len(plant.parameters)
    for law in families.laws():
        yield law.mechanism.plant, lanes + len(law.mechanism.free) - len(written.free)


def compile_layouts() -> None:
    """Compile the layouts that a callable on standard input returns, and exit when it closes."""
    needed = pickle.load(sys.stdin.buffer)

    def watch() -> None:
        sys.stdin.buffer.read()
        # `sys.exit` would end only this thread, and the compilation would continue.
        os._exit(0)

    Thread(target=watch, daemon=True).start()
    for plant, wanted in needed():
        kernel_for(plant, wanted)


def usable_cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
