"""The journal of an identification: one JSON line for its start, each stage as it ends, and its end."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import IO

from mechid.errors import InputFileError, UsageError
from mechid.identification.fit import Fit
from mechid.identification.progress import Progress

FILE_NAME = "journal.jsonl"


def identified_campaign(folder: Path) -> Path:
    """Return the campaign file that the last identification into a folder was of.

    Raises
    ------
    InputFileError
        There is no journal that tells, or the file is no longer there.
    """
    path, remedy = folder / FILE_NAME, "give it as --campaign CAMPAIGN"
    try:
        notes = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
        named = Path([note["campaign"] for note in notes if note["event"] == "started"][-1])
    except (OSError, ValueError, KeyError, IndexError) as error:
        raise InputFileError(f"{path}: does not tell which campaign was identified; {remedy}") from error
    found = next((place for place in (named, folder / named.name) if place.is_file()), None)
    if found is None:
        raise InputFileError(f"{path}: the campaign was {named}, which is not there; {remedy}")
    return found


class Journal:
    """Appends to a file while an identification runs; earlier runs stay in it."""

    def __init__(self, path: Path, file: IO[str]) -> None:
        self.path, self.file = path, file
        self.latest: Progress | None = None

    @classmethod
    @contextmanager
    def opened(cls, folder: Path, campaign: Path, seed: int) -> Iterator[Journal]:
        """Open the journal of a folder, made where it is missing, and note the start."""
        path = folder / FILE_NAME
        try:
            folder.mkdir(parents=True, exist_ok=True)
            file = path.open("a", encoding="utf-8", newline="\n")
        except OSError as error:
            raise UsageError(f"{folder}: cannot be written to ({error.strerror}); give another folder") from error
        with file:
            journal = cls(path, file)
            journal._note("started", campaign=str(campaign), seed=seed, mechid=version("mechid"))
            yield journal

    def tell(self, progress: Progress) -> None:
        """Listen to a report; when its stage is another one, the last has ended."""
        if self.latest is not None and progress.stage != self.latest.stage:
            self._note_stage(self.latest)
        self.latest = progress

    def finish(self, fit: Fit) -> None:
        """Note the stage at work and the outcome."""
        if self.latest is not None:
            self._note_stage(self.latest)
        self._note("finished", outcome=fit.outcome.code, message=fit.outcome.value)

    def _note_stage(self, progress: Progress) -> None:
        cost = progress.cost
        self._note(
            "stage",
            number=progress.number,
            total=progress.total,
            stage=progress.stage,
            line=progress.line,
            cost=float(cost) if cost is not None and math.isfinite(cost) else None,
            elapsed_s=round(progress.elapsed_s, 3),
        )

    def _note(self, event: str, **entries: object) -> None:
        now = datetime.now(UTC).isoformat(timespec="seconds")
        self.file.write(json.dumps({"time": now, "event": event, **entries}) + "\n")
        self.file.flush()
