"""Progress reports of a running identification."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Progress:
    """One report: stage `number` of `total`, its name, a line on where it stands, cost, seconds so far.

    `values` are those of the parameters that the stage moves, by dotted name, at the best point so far. `over_noise` is
    the residual's RMS over the noise floor of each whole record there, empty in most reports because it takes a
    simulation of all records; infinite where one fails.
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
"""Is told single lines."""


def silent(progress: Progress) -> None:
    """Listen to nothing."""
    del progress
