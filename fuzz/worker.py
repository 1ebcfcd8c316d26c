"""The process that tries inputs: a crash or a hang of it is a finding, and costs one input."""

import multiprocessing
import os
import resource
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from multiprocessing.connection import Connection
from pathlib import Path

from fuzz import branches
from fuzz.trial import FINDING, LIMIT_S, Kind, Outcome, tried

MOST_BYTES = 6 * 2**30
GRACE_S = 900.0
"""Beyond that an input has no end: it is much, since a run in the background may get little of a processor."""


IMPORTED = (
    "mechid.campaign",
    "mechid.records.undeclared",
    "mechid.checks.data_file",
    "mechid.budgets.budget_file",
    "mechid.structure",
    "mechid.budgets.example",
    "mechid.fleets.fleet_file",
    "mechid.fleets.estimates",
    "mechid.designs.design_file",
    "mechid.cli.app",
    "mechid.identification.result.fit_file",
    "mechid.identification.result.diagnosis_file",
    "layouts",
    "mechid.identification.computation.journal",
    "scipy.io",
    "scipy.interpolate",
    "h5py",
    "pyuff",
    "nptdms",
    "pyarrow.parquet",
)


@dataclass(frozen=True)
class Tried:
    """An input that has been tried, and the branches that none before it had taken."""

    number: int
    outcome: Outcome
    new: tuple[str, ...]


class Worker:
    """A process that tries inputs of any kind, started anew after a crash."""

    def __init__(self, kinds: tuple[Kind, ...], known: frozenset[str], kept: Path) -> None:
        self.kinds, self.known, self.kept = {kind.name: kind for kind in kinds}, set(known), kept
        self._process: multiprocessing.Process | None = None
        self._pipe: Connection | None = None

    def tried(self, kind: str, numbers: range) -> Iterator[Tried]:
        """Yield each input of a kind, as soon as it has been tried."""
        left = numbers
        while left:
            pipe = self._running()
            pipe.send((kind, left))
            for number in left:
                answer = self._answer(pipe)
                if answer is None:
                    yield Tried(number, self._ended(kind, number), ())
                    left = range(number + 1, left.stop)
                    break
                new = tuple(sorted(set(answer.new) - self.known))
                self.known.update(new)
                yield Tried(answer.number, answer.outcome, new)
            else:
                return

    def end(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._process = None

    def _answer(self, pipe: Connection) -> Tried | None:
        try:
            return pipe.recv() if pipe.poll(LIMIT_S + GRACE_S) else None
        except (EOFError, OSError):
            return None

    def _ended(self, kind: str, number: int) -> Outcome:
        """Return what has become of an input that ended its process, or did not end."""
        assert self._process is not None
        self._process.join(0.5)
        code = self._process.exitcode
        self.end()
        words = "no end, and no way to interrupt it" if code is None else f"the process ended with {code}"
        return Outcome(kind, FINDING, words, f"{kind} {words}")

    def _running(self) -> Connection:
        if self._process is None:
            self._pipe, theirs = multiprocessing.Pipe()
            self._process = multiprocessing.Process(target=_serve, args=(self.kinds, theirs, self.kept), daemon=True)
            self._process.start()
            theirs.close()
        assert self._pipe is not None
        return self._pipe


def _serve(kinds: dict[str, Kind], pipe: Connection, kept: Path) -> None:
    """Try what is asked for, until nobody asks."""
    resource.setrlimit(resource.RLIMIT_DATA, (MOST_BYTES, MOST_BYTES))
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    prepare()
    told: set[str] = set()
    root = Path(tempfile.mkdtemp(prefix="fuzz-"))
    os.chdir(root)
    try:
        while True:
            name, numbers = pipe.recv()
            for number in numbers:
                folder = root / "input"
                shutil.rmtree(folder, ignore_errors=True)
                folder.mkdir()
                outcome = tried(kinds[name], number, folder)
                if outcome.what == FINDING:
                    shutil.copytree(folder, kept / f"{name}-{number}", dirs_exist_ok=True)
                new = branches.taken - told
                told.update(new)
                pipe.send(Tried(number, outcome, tuple(new)))
    except (EOFError, BrokenPipeError, KeyboardInterrupt):
        pass
    finally:
        shutil.rmtree(root, ignore_errors=True)


def prepare() -> None:
    """Watch mechid's branches, here and in the process that reads."""
    branches.watch()
    from fuzz.elsewhere import watch_the_process_that_reads

    watch_the_process_that_reads()
    for name in IMPORTED:  # no input's time
        import_module(name)
