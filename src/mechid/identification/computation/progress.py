"""Progress reports of a running identification."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Progress:
    """Progress report: stage `number` of `total`, its name, a line of status, cost, elapsed seconds.

    `values` are the stage's free parameters by dotted name, at the best point so far. `over_noise` is the
    residual-to-noise ratio of each whole record at that point. It is empty in most reports, because it takes a
    simulation of all records, and infinite for a record whose simulation fails.
    """

    number: int
    total: int
    stage: str
    line: str
    cost: float | None
    elapsed_s: float
    values: Mapping[str, float] = field(default_factory=dict)
    over_noise: Mapping[str, float] = field(default_factory=dict)


Listener = Callable[[Progress], None]
Tell = Callable[[str], None]
"""Function that is called with single lines."""


def silent(progress: Progress) -> None:
    """Ignore a report."""
    del progress
