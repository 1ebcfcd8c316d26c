"""Where a search ended: what its conclusion is drawn from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mechid.identification.output_error.declaration import Taken
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.result.fit import FitOutcome, StageReport

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Frozen:
    """A parameter held for a dependence: at which value, how well that is known, and why."""

    name: str
    value: float
    sigma: float | None
    reason: str


@dataclass(frozen=True)
class Ending:
    """Where a search ended: all that `conclude` needs of it."""

    problem: Problem
    q: FloatArray
    windows: Windows
    outcome: FitOutcome
    stages: tuple[StageReport, ...]
    warnings: tuple[str, ...]
    seed: int
    seconds: float
    frozen: tuple[Frozen, ...] = ()
    taken: Mapping[str, Taken] = field(default_factory=dict)
