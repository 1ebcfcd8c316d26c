"""Commands in a process of their own that are sent a signal, and what they do until they have ended."""

import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path

WAIT_S = 150.0
TICKS = os.sysconf("SC_CLK_TCK") if hasattr(os, "sysconf") else 100


@dataclass
class Ending:
    """How a command ended: exit code, CPU seconds and seconds after the signal, what it printed."""

    code: int
    cpu_s: float
    wall_s: float
    stdout: str
    stderr: str


class Command:
    """A running ``mechid``, the leader of a group of processes of its own."""

    def __init__(self, arguments, *, environment=()):
        self.files = [Path(f"/proc/self/fd/{os.memfd_create(name)}") for name in ("stdout", "stderr")]
        with self.files[0].open("wb") as out, self.files[1].open("wb") as err:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "mechid", *map(str, arguments)],
                stdout=out,
                stderr=err,
                env=os.environ | {"PYTHONUNBUFFERED": "1"} | dict(environment),
                start_new_session=True,
            )
        self.watchdog = threading.Timer(WAIT_S, self.process.kill)
        self.watchdog.start()

    def said(self):
        """Return what has been said on stderr."""
        return self.files[1].read_text()

    def until(self, is_so):
        """Wait until something is so; fail where the command ends before."""
        while not is_so():
            assert self.process.poll() is None, f"ended before: {self.process.returncode}\n{self.said()}"
            time.sleep(0.005)

    def listens(self):
        """Return whether the command has its handler of SIGTERM in place."""
        lines = Path(f"/proc/{self.process.pid}/status").read_text().splitlines()
        caught = next(line for line in lines if line.startswith("SigCgt"))
        return bool(int(caught.split()[1], 16) >> (signal.SIGTERM - 1) & 1)

    def cpu_s(self):
        """Return the CPU seconds that the command's own process has taken; also after it has ended."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / TICKS

    def end(self, *numbers, group=False, pause_s=0.5):
        """Send signals one after another, wait for the end, and return it."""
        before, began = self.cpu_s(), time.monotonic()
        for k, number in enumerate(numbers):
            time.sleep(pause_s if k else 0.0)
            (os.killpg if group else os.kill)(self.process.pid, number)
        os.waitid(os.P_PID, self.process.pid, os.WEXITED | os.WNOWAIT)  # its numbers stay until it is waited for
        cpu_s, wall_s = self.cpu_s() - before, time.monotonic() - began
        self.close()
        return Ending(self.process.returncode, cpu_s, wall_s, *(file.read_text() for file in self.files))

    def close(self):
        """Leave nothing that runs."""
        self.watchdog.cancel()
        self.process.kill()
        self.process.wait()
