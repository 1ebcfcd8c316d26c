"""Mains hum: lines at multiples of 50 or 60 Hz, at a frequency common to all records, projected out of each."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.computation.parallel import in_threads
from mechid.identification.effects.disturbance import MAINS_PREFIX, Disturbance, lines_of, with_disturbances
from mechid.identification.effects.settings import PRIORS
from mechid.identification.output_error.misfit import Window, misfit_series
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.signal.grid import HumSeries, drifting_lines, evident_grid
from mechid.signal.lines import prominence
from mechid.signal.mains import MainsLine, mains_lines
from mechid.signal.series import is_finite, stretch_of
from mechid.signal.settings import HUM
from mechid.signal.trend import fit_line

USUAL = (1, 2, 3)
"""Multiples of a declared grid that are always included."""
NO_RESTS: Mapping[str, Window] = MappingProxyType({})
WORDS = "mains hum is in the records"


def mains(
    problem: Problem,
    q: FloatArray | None = None,
    declared_hz: float | None = None,
    rests: Mapping[str, Window] = NO_RESTS,
) -> Disturbance | None:
    """Return mains hum of the longest record: in the residual of a model at a point, or before any model.

    A record of varying rate shows best whether there is hum. Steps at 50 a second have lines at 50 Hz too, so at a
    steady rate lines at quarters of it do not count. The frequency is determined by all records together, within 0.2 Hz
    of the nominal or declared one, or by a record alone if it shows another one. A record of T s determines a frequency
    to far better than 1/T. In the residual of a model, a line is followed where it drifts (`mechid.signal.grid`).

    Parameters
    ----------
    problem : Problem
    q : (n,) or None
        Point of the model to be subtracted from the record.
    declared_hz : float or None
        Frequency of hum that is known to be present, at least with its usual multiples; 50 or 60 are the nominal ones.
    rests : mapping of str to (int, int)
        Samples of records, by name, in which no motion hides hum; they help to determine its frequency.
    """
    longest = max(problem.targets, key=lambda t: (_has_varying_rate(t), t.base.duration_s))
    series = longest.leading.measured if q is None else misfit_series(problem.model, longest, q, _whole(longest))[0]
    if not is_finite(series) or series.size < PRIORS.hum_samples:
        return None
    found = prominence(series, longest.base.sample_rate_hz)
    seen = [
        one for one in mains_lines(found) if _has_varying_rate(longest) or not _is_of_steps(one, longest, found.bin_hz)
    ]
    grids = {one.mains_hz for one in seen} if declared_hz is None else {_nominal(declared_hz)}
    if not grids:
        return None
    grid = max(grids, key=lambda hz: sum(one.line.ratio for one in seen if one.mains_hz == hz))
    own = [one for one in seen if one.mains_hz == grid]
    multiples = sorted({one.multiple for one in own} | set(USUAL if declared_hz else ()))
    series_of_records = [_hum_series(problem, target, q) for target in problem.targets]
    rests_of_records = [_rest_series(target, rests[target.name]) for target in problem.targets if target.name in rests]
    common_grid = evident_grid([*series_of_records, *rests_of_records], declared_hz or grid)
    hz = _frequency(own) if own and declared_hz in (None, grid) else declared_hz or grid
    each = common_grid.own_hz[: len(series_of_records)] if common_grid else (hz,) * len(series_of_records)
    lines = {}
    for target, one, own_hz in zip(problem.targets, series_of_records, each, strict=True):
        inside = _within([own_hz * multiple for multiple in multiples], target)
        drift = drifting_lines if common_grid and q is not None else _steady
        lines[target.name] = tuple(hz for line in inside for hz in drift(one, line))
    return Disturbance(f"{MAINS_PREFIX}{grid:g}Hz", WORDS, lines_hz=lines)


def grid_at_rest(problem: Problem, rests: Mapping[str, Window]) -> float | None:
    """Return the nominal grid frequency, Hz, of hum that records show before they move; None if there is none.

    Parameters
    ----------
    problem : Problem
    rests : mapping of str to (int, int)
        Samples of records, by name, before their motion.
    """
    falls = {hz: sum(_fall_by_hum(t, rests.get(t.name, (0, 0)), hz) for t in problem.targets) for hz in HUM.mains_hz}
    grid = max(falls, key=lambda hz: falls[hz])
    return grid if falls[grid] > PRIORS.hum_at_rest else None


def _fall_by_hum(target: Target, rest: Window, grid_hz: float) -> float:
    """Return the reduction of a rest's sum of squares by hum, in variances of the noise.

    It is zero if more than noise is left besides the hum: then the mechanism is not at rest, as after switching on.
    """
    channel, size = target.leading, rest[1] - rest[0]
    if size < PRIORS.hum_samples or size * grid_hz < PRIORS.hum_periods * target.base.sample_rate_hz:
        return 0.0
    rests_of_records, rejected = stretch_of(channel.measured, *rest), channel.rejected_within(rest)
    turns = [hz / target.base.sample_rate_hz for hz in _within([grid_hz * k for k in USUAL], target)]
    lines = (fit_line(rests_of_records, 1, rejected), fit_line(rests_of_records, 1, rejected, turns))
    left = [float(np.sum((np.asarray(rests_of_records) - line.at(0, size)) ** 2)) for line in lines]
    is_rest = left[1] < PRIORS.rest_noise * size * channel.sigma**2
    return (left[0] - left[1]) / channel.sigma**2 if is_rest else 0.0


def redetermine_hum(problem: Problem, q: FloatArray, declared_hz: float) -> Problem:
    """Return a problem with its declared hum determined again from the residual at a point.

    The residual contains no motion that could hide hum.
    """
    bare = replace(problem, targets=tuple(_without_lines(t) for t in problem.targets))
    hum = mains(bare, q, declared_hz)
    return with_disturbances(bare, [hum]) if hum else problem


def find_grid_hz(problem: Problem, q: FloatArray) -> float | None:
    """Return the grid frequency in Hz of hum that was removed from the records, or that their residuals show.

    None if there is none. Lines in residuals count as hum if a record of varying rate shows them, or two others: at one
    rate alone they may belong to the mechanism.
    """
    removed = sorted(lines_of(problem))
    if removed:
        nominal = min(HUM.mains_hz, key=lambda grid: sum(abs(math.remainder(hz, grid)) for hz in removed))
        return statistics.median(hz / round(hz / nominal) for hz in removed)
    series_of_records = [_hum_series(problem, target, q) for target in problem.targets]
    grids = in_threads(lambda nominal: evident_grid(series_of_records, nominal), HUM.mains_hz, problem.workers)
    for common_grid in grids:
        shown = [t for t, shows in zip(problem.targets, common_grid.shown, strict=True) if shows] if common_grid else []
        if common_grid and (len(shown) > 1 or any(map(_has_varying_rate, shown))):
            return common_grid.hz
    return None


def _without_lines(target: Target) -> Target:
    return replace(target, channels=(replace(target.leading, turns=()), *target.channels[1:]))


def _hum_series(problem: Problem, target: Target, q: FloatArray | None) -> HumSeries:
    """Return the series of a target that is searched for hum: as measured, or the residual at a point."""
    series = target.leading.measured if q is None else misfit_series(problem.model, target, q, _whole(target))[0]
    rate, varies = abs(float(target.command.rate.rates[0])), _has_varying_rate(target)

    def is_clear(hz: float, reach: float) -> bool:
        return varies or rate == 0.0 or abs(math.remainder(hz, 0.25 * rate)) > reach

    return HumSeries(series if is_finite(series) else np.zeros(0), target.base.sample_rate_hz, is_clear)


def _rest_series(target: Target, rest: Window) -> HumSeries:
    """Return a stretch of rest of a target, which is searched for hum."""
    return HumSeries(stretch_of(target.leading.measured, *rest), target.base.sample_rate_hz)


def _nominal(hz: float) -> float:
    return min(HUM.mains_hz, key=lambda grid: abs(grid - hz))


def _has_varying_rate(target: Target) -> bool:
    """Tell whether the commanded rate of a record varies."""
    return len(set(target.command.rate.rates)) > 1


def _is_of_steps(one: MainsLine, target: Target, bin_hz: float) -> bool:
    """Tell whether a line may belong to the steps of a steady rate.

    The steps have lines at multiples of a quarter of the rate, one electrical turn.
    """
    quarter_hz = 0.25 * abs(target.command.rate.rates[0])
    return quarter_hz > 0.0 and abs(math.remainder(one.line.frequency_hz, quarter_hz)) < HUM.bins * bin_hz


def _whole(target: Target) -> tuple[int, int]:
    return 0, target.samples


def _frequency(own: Sequence[MainsLine]) -> float:
    """Return the grid's frequency, Hz, from its lines by least squares."""
    # Inverse variances of each line's estimate of the grid: a strong line and a high multiple determine it best.
    weights = np.array([(one.multiple * one.line.amplitude / one.line.sigma) ** 2 for one in own])
    return float(np.average([one.line.frequency_hz / one.multiple for one in own], weights=weights))


def _steady(_: HumSeries, hz: float) -> tuple[float, ...]:
    return (hz,)


def _within(lines: Sequence[float], target: Target) -> tuple[float, ...]:
    """Return the lines below half the sample rate; none if the record has projected lines already."""
    rate, there = target.base.sample_rate_hz, target.leading.turns
    return () if there else tuple(hz for hz in lines if hz < min(HUM.highest_hz + 1.0, 0.5 * rate))
