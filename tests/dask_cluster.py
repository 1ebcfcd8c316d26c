"""A real Dask scheduler and real workers, processes of this machine."""

import os
import subprocess
import sys
import time
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import pytest

WAIT_S = 60.0


@dataclass
class Cluster:
    """The scheduler's address, and the processes."""

    folder: Path
    address: str = ""
    scheduler: subprocess.Popen | None = None
    workers: list[subprocess.Popen] = field(default_factory=list)

    def add_worker(self, **environment):
        """Start a worker of one thread that nobody restarts; return its process."""
        log = self.folder / f"dask_worker_{len(self.workers)}.log"
        self.workers.append(self._started("dask_worker", self.address, "--nthreads", "1", "--no-nanny", **environment))
        _until(lambda: "Registered to" in log.read_text())
        return self.workers[-1]

    def start(self):
        file = self.folder / "scheduler.json"
        self.scheduler = self._started("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", file)
        _until(file.is_file)
        self.address = _until(lambda: _address(file))

    def end(self):
        for process in (*self.workers, self.scheduler):
            if process:
                process.kill()
                process.wait()

    def _started(self, program, *arguments, **environment):
        command = [sys.executable, "-W", "ignore", "-m", f"distributed.cli.{program}", "--no-dashboard"]
        with (self.folder / f"{program}_{len(self.workers)}.log").open("w") as log:
            return subprocess.Popen(
                [*command, *map(str, arguments)],
                stdout=log,
                stderr=log,
                cwd=self.folder,
                env=os.environ | _paths() | environment,
            )


def _paths():
    """Let a worker find what these tests find: mechid, and the tasks that stand beside them."""
    return {"PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])}


def _address(file):
    """Return the address in a scheduler's file, nothing where it is not written to its end."""
    text = file.read_text()
    return text.split('"address": "')[1].split('"')[0] if '"address"' in text else ""


def _until(what):
    for _ in range(int(WAIT_S / 0.05)):
        if found := what():
            return found
        time.sleep(0.05)
    raise AssertionError("the cluster did not come up")


@contextmanager
def cluster(folder, workers=1):
    """Start a scheduler and so many workers; all end with the context."""
    pytest.importorskip("distributed")
    here = Cluster(folder)
    try:
        here.start()
        for _ in range(workers):
            here.add_worker()
        yield here
    finally:
        here.end()
