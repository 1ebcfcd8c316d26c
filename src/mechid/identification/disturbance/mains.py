"""Mains hum: lines at multiples of 50 or 60 Hz, seen in the longest record, and projected out of all."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mechid.identification.disturbance.disturbance import MAINS_PREFIX, Disturbance
from mechid.identification.output_error.misfit import misfit_series
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.signal.lines import prominence
from mechid.signal.mains import HIGHEST_HZ, MainsLine, mains_lines

FloatArray = NDArray[np.float64]
USUAL = (1, 2, 3)
"""Multiples of a grid that is declared and of which no line stands out."""
WORDS = "mains hum is in the records"


def mains(problem: Problem, q: FloatArray | None = None, declared_hz: float | None = None) -> Disturbance | None:
    """Return mains hum as the longest record shows it: in what the model leaves at a point, or before any model.

    Its frequency is that of all its lines together, each worth its amplitude times its multiple: what a record of T s
    tells of a frequency is far below 1/T.

    Parameters
    ----------
    problem : Problem
    q : (n,) or None
        Where the model is to be taken from the record.
    declared_hz : float or None
        50 or 60, where it is known to be there; its usual multiples where the record shows none.
    """
    longest = max(problem.targets, key=lambda t: t.base.duration_s)
    series = longest.leading.measured if q is None else misfit_series(problem.model, longest, q, _whole(longest))[0]
    if not np.all(np.isfinite(series)) or series.size < 16:
        return None
    seen = mains_lines(prominence(series, longest.base.sample_rate_hz))
    grids = {line.mains_hz for line in seen} if declared_hz is None else {declared_hz}
    if not grids:
        return None
    grid = max(grids, key=lambda hz: sum(one.line.ratio for one in seen if one.mains_hz == hz))
    own = [one for one in seen if one.mains_hz == grid]
    hz = _frequency(own) if own else grid
    lines = tuple(hz * multiple for multiple in sorted({one.multiple for one in own} or USUAL))
    return Disturbance(
        f"{MAINS_PREFIX}{grid:g}Hz", WORDS, lines_hz={t.name: _within(lines, t) for t in problem.targets}
    )


def _whole(target: Target) -> tuple[int, int]:
    return 0, target.samples


def _frequency(own: Sequence[MainsLine]) -> float:
    """Return the grid's frequency, Hz, from its lines by least squares."""
    weights = np.array([(one.multiple * one.line.amplitude / one.line.sigma) ** 2 for one in own])
    return float(np.average([one.line.frequency_hz / one.multiple for one in own], weights=weights))


def _within(lines: Sequence[float], target: Target) -> tuple[float, ...]:
    """Return the lines that a record can have, and does not have projected out already."""
    rate, there = target.base.sample_rate_hz, target.leading.turns
    return () if there else tuple(hz for hz in lines if hz < min(HIGHEST_HZ + 1.0, 0.5 * rate))
