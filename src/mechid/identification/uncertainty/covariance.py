"""Covariance of the estimate, for white residuals and robust to coloured ones.

White: sigma^2 (J^T J)^-1. Robust: (J^T W J)^-1 S (J^T W J)^-1, where S is the variance of the score under
the residual's own autocovariance (Maine and Iliff 1981; Grauer and Morelli 2016). An autoregressive model of each
record's residual gives the autocovariance. A second streamed pass filters the Jacobian through that model and sums S,
so memory does not grow with the record. Where a prefilter whitens a record, both covariances refer to the filtered
residual. The same pass sums the scores of each record's parts, which `model_error` compares.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.identification.output_error.misfit import Misfit, misfit_series
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import Triangle, WeightedRows
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.identification.search.solve import covariance
from mechid.identification.uncertainty.parts import PartsAccumulator, RecordParts
from mechid.identification.uncertainty.settings import ERRORS, NOISE
from mechid.signal.autoregression import Autoregression, fit_autoregression
from mechid.signal.series import Series, blocks, stretch_of
from mechid.signal.stored_series import WritableSeries, pieces_of, write_at
from mechid.simulation.simulator import Run
from mechid.simulation.trajectory import Switching


@dataclass(frozen=True)
class Scores:
    """Score of the records at a point: its variance under noise, and its split into parts.

    Attributes
    ----------
    variance : (n, n)
        Variance under each residual's own colour, priors included.
    parts : tuple of RecordParts
        One entry for each record.
    switching : mapping of str to Switching
        Switches of each record whose run has logged them: of none if outputs of the plant jump at switches.
    """

    variance: FloatArray
    parts: tuple[RecordParts, ...]
    switching: Mapping[str, Switching]


@dataclass(frozen=True)
class Uncertainty:
    """Covariances in search coordinates, (n, n): for white residuals, and robust to coloured ones."""

    white: FloatArray
    robust: FloatArray


def uncertainty(problem: Problem, q: FloatArray, windows: Windows, triangle: Triangle, seen: BoolArray) -> Uncertainty:
    """Return both covariances at `q`; coordinates that are not `seen` get zeros.

    The sigmas of the targets are not re-estimated: the caller has set them from the residuals. The channels of a
    record are assumed independent of one another.
    """
    return covariances(triangle, scores(problem, q, windows).variance, seen)


def scores(problem: Problem, q: FloatArray, windows: Windows) -> Scores:
    """Compute the scores at `q` of all records that have a window, with one streamed pass over each record."""
    _, known = problem.coordinates.prior_rows(q)
    variance, parts, switching = known.T @ known, [], dict[str, Switching]()
    # A run logs either its switches or its jumps, and the weights of samples at jumps need these.
    events = None if problem.space.mechanism.plant.jump_switches else ERRORS.most_switches
    for t in (t for t in problem.targets if t.name in windows):
        colour = _fit_colours(problem, t, q, windows[t.name])
        run = problem.model.run(t, q, windows[t.name][1], jacobian=True, events=events)
        own, of_record = _record_score(problem, t, q, windows[t.name], colour, run)
        variance += own
        parts.append(of_record)
        if events is not None:
            switching[t.name] = run.switching
    return Scores(variance, tuple(parts), switching)


def covariances(triangle: Triangle, variance: FloatArray, seen: BoolArray) -> Uncertainty:
    """Return both covariances of the `seen` coordinates; the others are held and get zeros."""
    inverse = np.zeros_like(variance)
    inverse[np.ix_(seen, seen)] = covariance(Triangle(triangle.norm, triangle.jacobian[:, seen], triangle.samples))
    # Sandwich form; for white residuals the variance of the score is J^T J and both covariances agree.
    return Uncertainty(inverse, inverse @ variance @ inverse)


def residual(problem: Problem, target: Target, q: FloatArray, window: tuple[int, int]) -> tuple[WritableSeries, ...]:
    """Return the misfit of each channel over a window, offset and drift removed, n samples; 0 at rejected samples."""
    series = misfit_series(problem.model, target, q, window)
    for channel, r in zip(target.channels, series, strict=True):
        rejected = channel.rejected_within(window)
        channel.line(r, rejected).subtract_from(r)
        write_at(r, rejected, 0.0)
    return series


def residuals_by_quantity(
    problem: Problem, target: Target, q: FloatArray, window: tuple[int, int] | None = None
) -> dict[str, WritableSeries]:
    """Return `residual` keyed by each channel's quantity; the window defaults to the whole record."""
    series = residual(problem, target, q, window or (0, target.samples))
    return dict(zip(target.quantities, series, strict=True))


def _fit_colours(
    problem: Problem, target: Target, q: FloatArray, window: tuple[int, int]
) -> tuple[Autoregression, ...]:
    """Fit an autoregressive model to each channel's residual after its prefilter."""
    series = _prefiltered_residuals(problem, target, q, window)
    return tuple(
        fit_autoregression(r, rejected=channel.rejected_within(window))
        for channel, r in zip(target.channels, series, strict=True)
    )


def _prefiltered_residuals(
    problem: Problem, target: Target, q: FloatArray, window: tuple[int, int]
) -> list[WritableSeries]:
    """Return the prefiltered residual of each channel, n samples; 0 where the filter's memory holds invalid samples."""
    series = residual(problem, target, q, window)
    return [_prefilter_in_place(channel, r, window) for channel, r in zip(target.channels, series, strict=True)]


def _prefilter_in_place(channel: TargetChannel, r: WritableSeries, window: tuple[int, int]) -> WritableSeries:
    """Prefilter a residual in place and return it."""
    if channel.prefilter is None:
        return r
    order = channel.order
    memory = np.zeros(order)
    for part in blocks(r.size):
        r[part], memory = channel.prefilter.whiten_rows(r[part], memory)
    # The first `order` samples, and the `order` samples after each rejected one, depend on values that do not exist.
    r[:order] = 0.0
    spoilt = channel.rejected_within((window[0] - order, window[1])) - order
    spoilt = np.unique(spoilt[:, np.newaxis] + np.arange(order + 1))
    write_at(r, spoilt[(spoilt >= 0) & (spoilt < r.size)], 0.0)
    return r


def _record_score(
    problem: Problem,
    target: Target,
    q: FloatArray,
    window: tuple[int, int],
    colour: tuple[Autoregression, ...],
    run: Run | None = None,
) -> tuple[FloatArray, RecordParts]:
    """Return J^T C J / sigma^4, summed over channels, with C the residual's covariance; and the score by parts.

    Coloured noise: J is filtered through 1/A. Rounding: its error is constant while the channel is, so all samples of
    a visit to one instrument step share one error of variance q^2/12; visits are independent. The pass sums products
    of all columns of [Phi r J]; offset and drift are projected out of the sums afterwards, so one pass suffices.
    """
    rows = WeightedRows(Misfit(problem.model, target, q, window, jacobian=True, run=run))
    coloured = [_ColouredScore(*each, window) for each in zip(target.channels, colour, rows.widths, strict=True)]
    whitened = all(
        own.order == 0 and c.rounding_share <= NOISE.mostly_rounding
        for c, own in zip(target.channels, colour, strict=True)
    )
    parts = PartsAccumulator(target, problem.coordinates.timing(target, q), window, rows.widths, whitened=whitened)
    for k, block, n in rows:
        coloured[k].add(block[:, :n])
        parts.add(k, block[:, :n])
    projected = parts.projections
    score = sum((c.score(of[:, 1:]) for c, of in zip(coloured, projected, strict=True)), np.zeros((problem.size,) * 2))
    return score, parts.sum_parts(projected)


class Visits:
    """Sums of rows over the visits to each instrument step; the rows arrive block by block.

    Parameters
    ----------
    measured : Series of N samples
        A visit lasts as long as its value does not change.
    size : int
        Columns of the rows.
    """

    def __init__(self, measured: Series, size: int) -> None:
        self._begins = np.ones(measured.size, dtype=bool)
        for part in pieces_of(measured):
            first = max(part.start, 1)
            self._begins[first : part.stop] = np.diff(measured[first - 1 : part.stop]) != 0.0
        self._done = 0
        self._open = np.zeros(size)
        self._closed = np.zeros((size, size))

    def add(self, rows: FloatArray) -> None:
        """Add the next rows, (m, n), with m >= 1."""
        begins = np.flatnonzero(self._begins[self._done : self._done + len(rows)])
        self._done += len(rows)
        starts = begins if begins.size and begins[0] == 0 else np.concatenate([[0], begins])
        sums = np.add.reduceat(rows, starts, axis=0)
        # A visit may span blocks: its sum stays open until a later block begins another visit.
        if starts.size > begins.size:
            sums[0] += self._open
        else:
            sums = np.vstack([self._open, sums])
        self._open = sums[-1]
        self._closed += sums[:-1].T @ sums[:-1]

    @property
    def total(self) -> FloatArray:
        """Sum over visits of s s^T, (n, n), where s is the sum of the rows of a visit."""
        return self._closed + np.outer(self._open, self._open)


class _ColouredScore:
    """Variance of a channel's score under its residual's own colour, from rows that arrive block by block."""

    def __init__(self, channel: TargetChannel, own: Autoregression, width: int, window: tuple[int, int]) -> None:
        self._channel, self._own = channel, own
        self._memory = np.zeros((width, own.order))
        self._total = np.zeros((width, width))
        self._visits = Visits(stretch_of(channel.measured, *window), width) if channel.rounding_share else None

    def add(self, rows: FloatArray) -> None:
        """Add the next samples, (width, m)."""
        if self._visits is not None:
            self._visits.add(rows.T)
        if self._own.order:
            rows, self._memory = self._own.colour_rows(rows, self._memory)
        self._total += rows @ rows.T

    def score(self, columns: FloatArray) -> FloatArray:
        """Return the variance of all rows so far, for linear functions `columns` of their columns, (width, n)."""
        total = columns.T @ self._total @ columns
        score = total * (1.0 - self._channel.rounding_share) * (self._own.sigma / self._channel.scale) ** 2
        if self._visits is not None:
            score += columns.T @ self._visits.total @ columns * self._channel.rounding_share
        return np.asarray(score, dtype=np.float64)
