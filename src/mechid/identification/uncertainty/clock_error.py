"""Error by not knowing which clock is right: how far the estimate moves where the driver's time is taken for the true.

No record tells whether the driver's clock or the recorder's is off, only how much they differ. Where the campaign does
not say which one is right, the recorder's time is taken, and the step to the optimum of the other choice is a standard
error of its own: of all parameters together, since one clock moves them all.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import Triangle
from mechid.identification.result.parameter_estimate import ParameterEstimate
from mechid.identification.uncertainty.bounds import newton_step


def clocks_differ(problem: Problem, q: FloatArray) -> bool:
    """Tell whether the recorder's time is taken for the true one at a point where the driver's differs from it."""
    return any(problem.coordinates.timing(target, q).stretch != 1.0 for target in problem.targets)


def clock_step(problem: Problem, q: FloatArray, windows: Windows, triangle: Triangle, counted: BoolArray) -> FloatArray:
    """Return the step of the coordinates to the optimum in the driver's time, (n,); zero where the clocks agree.

    Parameters
    ----------
    problem : Problem
    q : (n,)
        Its optimum in the recorder's time.
    windows : mapping of record to (first, stop)
    triangle : Triangle
        The problem at `q`.
    counted : (n,) of bool
        The coordinates that are estimated.
    """
    none = np.zeros(q.size)
    if not clocks_differ(problem, q):
        return none
    other = replace(problem, targets=tuple(replace(t, clock_reference="driver") for t in problem.targets))
    moved = other.joint(q, windows)
    if not np.isfinite(moved.norm):
        return none
    # what is left of the gradient at `q` is in both
    return newton_step(moved, counted) - newton_step(triangle, counted)


def clock_warnings(parameters: Mapping[str, ParameterEstimate]) -> tuple[str, ...]:
    """Say how far the values rest on the recorder's clock, where that is more than their noise."""
    moved = [p for p in parameters.values() if p.std_error_clock and p.std_error_noise and p.value]
    worst = max(moved, key=lambda p: (p.std_error_clock or 0.0) / (p.std_error_noise or 1.0), default=None)
    if worst is None or worst.std_error_clock is None or worst.std_error_clock < (worst.std_error_noise or 0.0):
        return ()
    share = abs(worst.std_error_clock / worst.value)
    return (
        "the driver's clock and the recorder's differ; no record tells which is right, and the recorder's is taken. "
        f"With the driver's, {worst.name} would differ by {worst.std_error_clock:.3g} {worst.unit}, {share:.2g} of it; "
        "the standard errors include this as std_error_clock; write clock_reference = "
        '"recorder" or "driver" in campaign.toml where you know which',
    )
