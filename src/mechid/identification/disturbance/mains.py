"""Mains hum: lines at multiples of 50 or 60 Hz, seen in the longest record, and projected out of all."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.disturbance.disturbance import MAINS_PREFIX, Disturbance
from mechid.identification.output_error.misfit import misfit_series
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.signal.lines import prominence
from mechid.signal.mains import BINS, HIGHEST_HZ, MAINS_HZ, MainsLine, mains_lines
from mechid.signal.series import is_finite

FEWEST = 64
"""Samples in which lines are looked for; a choice, not measured."""
USUAL = (1, 2, 3)
"""Multiples of a grid that is declared, whether they stand out or not."""
WORDS = "mains hum is in the records"


def mains(problem: Problem, q: FloatArray | None = None, declared_hz: float | None = None) -> Disturbance | None:
    """Return mains hum as the longest record shows it: in what the model leaves at a point, or before any model.

    Its frequency is that of all its lines together, each worth its amplitude times its multiple: what a record of T s
    tells of a frequency is far below 1/T. A record whose rate varies shows it best: steps at 50 a second are lines of
    50 Hz too, so that at a steady rate lines at quarters of it do not count.

    Parameters
    ----------
    problem : Problem
    q : (n,) or None
        Where the model is to be taken from the record.
    declared_hz : float or None
        Its frequency where it is known to be there, with its usual multiples at least; 50 or 60 are the nominal ones.
    """
    longest = max(problem.targets, key=lambda t: (_varies(t), t.base.duration_s))
    series = longest.leading.measured if q is None else misfit_series(problem.model, longest, q, _whole(longest))[0]
    if not is_finite(series) or series.size < FEWEST:
        return None
    found = prominence(series, longest.base.sample_rate_hz)
    seen = [one for one in mains_lines(found) if _varies(longest) or not _is_of_steps(one, longest, found.bin_hz)]
    grids = {one.mains_hz for one in seen} if declared_hz is None else {_nominal(declared_hz)}
    if not grids:
        return None
    grid = max(grids, key=lambda hz: sum(one.line.ratio for one in seen if one.mains_hz == hz))
    own = [one for one in seen if one.mains_hz == grid]
    hz = _frequency(own) if own else grid
    if declared_hz is not None and declared_hz != grid:
        hz = declared_hz
    multiples = {one.multiple for one in own} | set(USUAL if declared_hz else ())
    lines = tuple(hz * multiple for multiple in sorted(multiples))
    return Disturbance(
        f"{MAINS_PREFIX}{grid:g}Hz", WORDS, lines_hz={t.name: _within(lines, t) for t in problem.targets}
    )


def _nominal(hz: float) -> float:
    return min(MAINS_HZ, key=lambda grid: abs(grid - hz))


def _varies(target: Target) -> bool:
    """Tell whether the commanded rate of a record does."""
    return len(set(target.command.rate.rates)) > 1


def _is_of_steps(one: MainsLine, target: Target, bin_hz: float) -> bool:
    """Tell whether a line is where a steady rate has its own: at quarters of it, one electrical turn."""
    quarter_hz = 0.25 * abs(target.command.rate.rates[0])
    return quarter_hz > 0.0 and abs(math.remainder(one.line.frequency_hz, quarter_hz)) < BINS * bin_hz


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
