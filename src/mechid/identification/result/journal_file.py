"""Journal lines of an identification: one at the end of each stage, and one at the end of the search."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mechid.errors import InputFileError
from mechid.identification.computation.journal import Journal
from mechid.identification.computation.progress import Progress
from mechid.identification.result.fit import Fit
from mechid.identification.result.settings import GRADE

FILE_NAME = "journal.jsonl"
FINISHED = "finished"
"""Journal event at the end of the search."""


def identified_campaign(folder: Path) -> Path:
    """Return the campaign file of the last identification into a folder.

    Raises
    ------
    InputFileError
        If no journal names it, or the file no longer exists.
    """
    path, remedy = folder / FILE_NAME, "give it as --campaign CAMPAIGN"
    try:
        # Only lines of a start are parsed: a journal may hold many large ones.
        notes = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines() if '"started"' in line]
        named = Path([note["campaign"] for note in notes][-1])
    except (OSError, ValueError, KeyError, IndexError, TypeError) as error:
        raise InputFileError(f"{path} does not name the identified campaign; {remedy}") from error
    # A result folder may have moved together with its campaign file.
    found = next((place for place in (named, folder / named.name) if place.is_file()), None)
    if found is None:
        raise InputFileError(f"{path}: the campaign {named} does not exist; {remedy}")
    return found


class StageLines:
    """Listener of an identification that journals the end of each stage and, at intervals, the progress."""

    def __init__(self, journal: Journal) -> None:
        self.journal = journal
        self.latest: Progress | None = None
        self.last_note_s = -math.inf
        self.over_noise: Mapping[str, float] = {}

    def tell(self, progress: Progress) -> None:
        """Receive a report; a change of its stage means that the previous stage has ended."""
        if self.latest is not None and progress.stage != self.latest.stage:
            self._note_stage(self.latest)
        self.latest = progress
        # Ratios arrive with few reports: they are kept until the next note is due.
        self.over_noise = progress.over_noise or self.over_noise
        if time.perf_counter() - self.last_note_s >= GRADE.progress_interval_s:
            self.last_note_s = time.perf_counter()
            self.journal.note("progress", **_entries(progress), **self._values_and_ratios(progress))

    def _values_and_ratios(self, progress: Progress) -> dict[str, Any]:
        """Return the values, and the residual-to-noise ratios that were computed since the last note."""
        ratios = {name: ratio if math.isfinite(ratio) else None for name, ratio in self.over_noise.items()}
        self.over_noise = {}
        return {"values": dict(progress.values), "over_noise": ratios}

    def finish(self, fit: Fit) -> None:
        """Journal the current stage and the outcome."""
        if self.latest is not None:
            self._note_stage(self.latest)
        self.journal.note(FINISHED, grade=str(fit.grade), outcome=fit.outcome.code, message=fit.outcome.value)

    def _note_stage(self, progress: Progress) -> None:
        self.journal.note("stage", **_entries(progress))


def _entries(progress: Progress) -> dict[str, Any]:
    cost = progress.cost
    return {
        "number": progress.number,
        "total": progress.total,
        "stage": progress.stage,
        "line": progress.line,
        "cost": float(cost) if cost is not None and math.isfinite(cost) else None,
        "elapsed_s": round(progress.elapsed_s, 3),
    }
