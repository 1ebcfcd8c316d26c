"""Control of the false discovery rate over families of tests, by Benjamini and Hochberg.

At a rate of 0.05, at most one in twenty findings is expected to be false, however many tests there are. The tests of
one family answer one question: which parameters differ, which trends exist, and so on. Tests of parameters of the same
unit are correlated. The procedure is valid for positive correlations (Benjamini, Yekutieli, Ann. Stat. 29 (2001) 1165),
and its rate was measured for those of estimates (docs/fleet.md).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from scipy.stats import false_discovery_control

Result = TypeVar("Result")
RATE = 0.05
"""Default of the expected share of false findings."""


def q_values(p_values: Sequence[float]) -> list[float]:
    """Return the least rate at which each test of a family is a finding; NaN for NaN, a test that was not made.

    Examples
    --------
    >>> q_values([0.01, 0.04, float("nan"), 0.03])
    [0.03, 0.04, nan, 0.04]
    """
    p = np.array(p_values, dtype=np.float64)
    # A test that was not made must not count in the size of the family.
    made, q = np.isfinite(p), np.full(p.size, np.nan)
    if made.any():
        q[made] = false_discovery_control(p[made])
    return q.tolist()


@dataclass(frozen=True)
class FdrResult(Generic[Result]):
    """Result with the least false discovery rate at which it is a finding, and whether it is one."""

    result: Result
    q: float
    found: bool


def apply_fdr(
    results: Sequence[Result], rate: float, p_value: Callable[[Result], float]
) -> tuple[FdrResult[Result], ...]:
    """Return the results of one family of tests with the findings at a rate."""
    q = q_values([p_value(one) for one in results])
    return tuple(FdrResult(one, at, at <= rate) for one, at in zip(results, q, strict=True))
