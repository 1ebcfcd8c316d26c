"""Identification in another process, followed through its journal."""

from __future__ import annotations

import json
import math
import time
from datetime import datetime
from pathlib import Path
from typing import Any

from mechid.identification.computation.progress import Progress
from mechid.web.fit_run import RunState

SILENT_S = 120.0
"""Silence in s after which a run is considered dead."""
KEPT = ("number", "total", "stage", "line", "cost", "elapsed_s", "values")


class FollowedRun:
    """Last run of a journal: its reports, and whether it was running at any poll.

    Parameters
    ----------
    path : Path
        journal.jsonl of a result folder; it may not exist yet.
    """

    is_elsewhere = True

    def __init__(self, path: Path) -> None:
        self.path = path
        self.reports: list[Progress] = []
        self.state = RunState.CANCELLED
        self.fault = ""
        self.is_alive = False
        self.began_at = 0.0
        self._read = 0

    @property
    def elapsed_s(self) -> float:
        """Elapsed seconds at the last report of the run."""
        return self.reports[-1].elapsed_s if self.reports else 0.0

    def poll(self) -> None:
        """Read new entries of the journal."""
        try:
            written = self.path.stat()
            # A shorter journal was started again.
            if written.st_size < self._read:
                self._read = 0
            with self.path.open("rb") as file:
                file.seek(self._read)
                new = file.read()
        except OSError:
            return
        # The writer may be in the middle of a line, which is then read at the next poll.
        whole = new[: new.rfind(b"\n") + 1]
        self._read += len(whole)
        for line in whole.splitlines():
            self._take(line)
        # A killed process writes no last entry; only its silence shows.
        if self.state is RunState.RUNNING and time.time() - written.st_mtime > SILENT_S:
            self.state = RunState.CANCELLED
        self.is_alive |= self.state is RunState.RUNNING

    def has_written(self, name: str) -> bool:
        """Return whether the followed run has ended and written a file next to its journal."""
        path = self.path.with_name(name)
        ended = self.is_alive and self.state is RunState.FINISHED
        return ended and path.is_file() and path.stat().st_mtime >= self.began_at

    def _take(self, line: bytes) -> None:
        try:
            entry: dict[str, Any] = json.loads(line)
            event = entry["event"]
        except (ValueError, KeyError, TypeError):
            # The file may contain a damaged line, which is skipped.
            return
        if event in ("started", "resumed"):
            self.reports, self.state = [], RunState.RUNNING
            self.began_at = datetime.fromisoformat(entry["time"]).timestamp()
        elif event == "progress":
            ratios = {name: math.inf if r is None else r for name, r in entry.get("over_noise", {}).items()}
            self.reports.append(Progress(**{key: entry[key] for key in KEPT}, over_noise=ratios))
        elif event == "finished":
            self.state = RunState.FINISHED
