"""What a running identification tells of itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Progress:
    """One report: stage `number` of `total`, its name, a line on where it stands, cost, seconds so far."""

    number: int
    total: int
    stage: str
    line: str
    cost: float | None
    elapsed_s: float


Listener = Callable[[Progress], None]


def silent(progress: Progress) -> None:
    """Listen to nothing."""
    del progress
