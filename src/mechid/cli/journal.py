"""What the journal of an identification says of its stages: a line as each ends, and one for the end."""

from __future__ import annotations

import math

from mechid.identification.fit import Fit
from mechid.identification.journal import Journal
from mechid.identification.progress import Progress

FILE_NAME = "journal.jsonl"


class StageLines:
    """Listens to an identification and notes each stage as it ends."""

    def __init__(self, journal: Journal) -> None:
        self.journal = journal
        self.latest: Progress | None = None

    def tell(self, progress: Progress) -> None:
        """Listen to a report; when its stage is another one, the last has ended."""
        if self.latest is not None and progress.stage != self.latest.stage:
            self._note_stage(self.latest)
        self.latest = progress

    def finish(self, fit: Fit) -> None:
        """Note the stage at work and the outcome."""
        if self.latest is not None:
            self._note_stage(self.latest)
        self.journal.note("finished", outcome=fit.outcome.code, message=fit.outcome.value)

    def _note_stage(self, progress: Progress) -> None:
        cost = progress.cost
        self.journal.note(
            "stage",
            number=progress.number,
            total=progress.total,
            stage=progress.stage,
            line=progress.line,
            cost=float(cost) if cost is not None and math.isfinite(cost) else None,
            elapsed_s=round(progress.elapsed_s, 3),
        )
