"""Kernels of the layouts that the ladder needs, compiled by another process beside the search.

Three quarters of a compilation hold the interpreter's lock, so that a thread takes as much from the search as it saves.
The process fills the cache that all processes share: a search that needs a kernel at work there waits for it, and loads
it. Whatever goes wrong there shows where the kernel is really needed, since the search then compiles it itself.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from threading import Thread
from types import TracebackType
from typing import Self

from mechid.campaign import Campaign
from mechid.identification.computation.parallel import is_alone
from mechid.identification.output_error.problem import Problem
from mechid.identification.stages.families import OF_RECORDS, Families
from mechid.kernel.compiled import is_compiled, kernel_for, version_folder
from mechid.kernel.source import fingerprint, lanes_for
from mechid.plant.plant import Plant
from mechid.writing import write_atomically

START = "import sys; sys.path[:] = {path!r}; from {module} import compile_layouts; compile_layouts()"
PIPE_BYTES = 1 << 20
"""Of the pipe to it: what it is sent never waits for it."""
LINE = "the layouts that further effects need are compiled beside the search (first time, cached afterwards)"


class KernelsAhead:
    """Compiles the layouts of a campaign's further effects beside what is done within a ``with``, and ends there.

    Parameters
    ----------
    problem : Problem
        Of the mechanism as written.
    campaign : Campaign
    """

    def __init__(self, problem: Problem, campaign: Campaign) -> None:
        self.problem, self.campaign = problem, campaign
        self._child: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.end()

    def start_if_new(self) -> bool:
        """Start, and tell so, where this mechanism is searched for the first time: then nothing stands in the cache."""
        mechanism = self.problem.space.mechanism
        mark = self._mark(mechanism.plant)
        if mark.exists() or not self._may_start:
            return False
        with suppress(OSError):
            mark.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(mark, "The kernels of its further effects have been begun.\n")
            return self._start()
        return False

    def start_if_lacking(self, families: Families) -> bool:
        """Start, and tell so, where a layout of these families is not in the cache: a search is about to need it."""
        return self._may_start and not all(is_compiled(*one) for one in layouts(families)) and self._start()

    def end(self) -> None:
        """End the process, whatever it is at: what it leaves half done is made anew where it is needed."""
        child, self._child = self._child, None
        if child is not None:
            child.kill()
            with suppress(OSError):
                child.communicate()

    @property
    def _may_start(self) -> bool:
        """Whether there is a second core, and nobody else's work on it; without locks two would do the same work."""
        options = self.campaign.options
        adds = options.terms or options.disturbances != "none"
        alone = is_alone() or usable_cores() < 2 or not sys.executable or find_spec("fcntl") is None
        return adds and self._child is None and not alone

    @property
    def _light(self) -> Families:
        """The families without the records, which tell nothing of layouts and take long to be sent."""
        return Families(replace(self.problem, targets=()), replace(self.campaign, records=(), source=None))

    def _mark(self, plant: Plant) -> Path:
        return version_folder() / f"ahead_{fingerprint(plant, lanes_for(self.problem.coordinates.lanes))}.txt"

    def _start(self) -> bool:
        command = START.format(path=[str(place) for place in sys.path], module=__name__)
        try:
            message = pickle.dumps((self._light, self.problem.coordinates.lanes))
            child = subprocess.Popen(
                [sys.executable, "-P", "-c", command],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                pipesize=PIPE_BYTES,
                start_new_session=True,  # Ctrl-C is for the search, which ends this process
            )
        except Exception:  # what does not pickle, or a system without processes: the search compiles by itself
            return False
        self._child = child
        assert child.stdin is not None
        with suppress(OSError):  # it has ended already
            child.stdin.write(message)
            child.stdin.flush()  # and stays open: where this process is gone, the other sees its end
        return True


def layouts(families: Families, lanes: int | None = None) -> Iterator[tuple[Plant, int]]:
    """Yield the plants that the ladder may need, each with the derivatives wanted, the first needed first.

    Parameters
    ----------
    families : Families
    lanes : int or None
        Derivatives wanted of the mechanism as written; None takes those of the families' problem.
    """
    written = families.plain.space.mechanism
    lanes = families.plain.coordinates.lanes if lanes is None else lanes
    if families.superset is not None:
        yield families.record_layout, lanes + len(OF_RECORDS)
    if families.superset is not None and families.allows_terms:
        plant = families.superset.mechanism.plant
        yield plant, len(plant.parameters)
    for law in families.laws():
        yield law.mechanism.plant, lanes + len(law.mechanism.free) - len(written.free)


def compile_layouts() -> None:
    """Compile the layouts that standard input tells of, and end where it ends."""
    families, lanes = pickle.load(sys.stdin.buffer)

    def watch() -> None:
        sys.stdin.buffer.read()
        os._exit(0)

    Thread(target=watch, daemon=True).start()
    for plant, wanted in layouts(families, lanes):
        kernel_for(plant, wanted)


def usable_cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
