"""What of many tests is more than chance: the false discovery rate of Benjamini and Hochberg.

Of the findings named at a rate of 0.05, at most one in twenty is expected to be chance, however many were looked for.
The tests of one family are those of one question: which parameters differ, which trends there are, and so on. Those of
parameters of the same unit are correlated; Benjamini and Hochberg's rule holds for positive correlations (Benjamini,
Yekutieli, Ann. Stat. 29 (2001) 1165) and was measured for those of estimates (docs/fleet.md).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from scipy.stats import false_discovery_control

Result = TypeVar("Result")
RATE = 0.05
"""Expected share of findings that are chance, where the fleet file says nothing else."""


def q_values(p_values: Sequence[float]) -> list[float]:
    """Return for each test of a family the least rate at which it is a finding; NaN for NaN, a test that was none.

    Examples
    --------
    >>> q_values([0.01, 0.04, float("nan"), 0.03])
    [0.03, 0.04, nan, 0.04]
    """
    p = np.array(p_values, dtype=np.float64)
    made, q = np.isfinite(p), np.full(p.size, np.nan)
    if made.any():
        q[made] = false_discovery_control(p[made])
    return q.tolist()


@dataclass(frozen=True)
class Tested(Generic[Result]):
    """A result with the least rate of false discoveries at which it is a finding, and whether it is one here."""

    result: Result
    q: float
    found: bool


def tested(results: Sequence[Result], rate: float, p_value: Callable[[Result], float]) -> tuple[Tested[Result], ...]:
    """Return the results of one family of tests with what is found at a rate."""
    q = q_values([p_value(one) for one in results])
    return tuple(Tested(one, at, at <= rate) for one, at in zip(results, q, strict=True))
