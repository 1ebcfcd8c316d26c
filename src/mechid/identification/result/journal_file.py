"""Journal lines of an identification: one as each stage ends, and one for the end."""

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
"""The event with which the search ends."""


def identified_campaign(folder: Path) -> Path:
    """Return the campaign file that the last identification into a folder was of.

    Raises
    ------
    InputFileError
        There is no journal that tells, or the file is no longer there.
    """
    path, remedy = folder / FILE_NAME, "give it as --campaign CAMPAIGN"
    try:
        notes = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines() if '"started"' in line]
        named = Path([note["campaign"] for note in notes][-1])
    except (OSError, ValueError, KeyError, IndexError, TypeError) as error:
        raise InputFileError(f"{path}: does not say which campaign was identified; {remedy}") from error
    found = next((place for place in (named, folder / named.name) if place.is_file()), None)
    if found is None:
        raise InputFileError(f"{path}: the campaign was {named}, which is not there; {remedy}")
    return found


class StageLines:
    """Listens to an identification and notes each stage as it ends, and now and then where it stands."""

    def __init__(self, journal: Journal) -> None:
        self.journal = journal
        self.latest: Progress | None = None
        self.noted = -math.inf
        self.over_noise: Mapping[str, float] = {}

    def tell(self, progress: Progress) -> None:
        """Listen to a report; when its stage is another one, the last has ended."""
        if self.latest is not None and progress.stage != self.latest.stage:
            self._note_stage(self.latest)
        self.latest = progress
        self.over_noise = progress.over_noise or self.over_noise
        if time.perf_counter() - self.noted >= GRADE.noted_every_s:
            self.noted = time.perf_counter()
            self.journal.note("progress", **_entries(progress), **self._reached(progress))

    def _reached(self, progress: Progress) -> dict[str, Any]:
        """Return the values, and how far off the records are where that was looked at since the last note."""
        ratios = {name: ratio if math.isfinite(ratio) else None for name, ratio in self.over_noise.items()}
        self.over_noise = {}
        return {"values": dict(progress.values), "over_noise": ratios}

    def finish(self, fit: Fit) -> None:
        """Note the stage at work and the outcome."""
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
