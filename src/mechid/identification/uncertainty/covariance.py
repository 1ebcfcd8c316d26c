"""Covariance of the estimate: for white residuals, and robust to their colour.

White: sigma^2 (J^T J)^-1. Robust: (J^T W J)^-1 S (J^T W J)^-1 with S the variance that the score has under
the residual's own autocovariance (Maine and Iliff 1981; Grauer and Morelli 2016). The autocovariance
comes from an autoregressive model of each record's residual, S from a second streamed pass in which the
Jacobian runs through that model: memory does not grow with the record. Where a prefilter whitens a record, all of
this is of what stands behind it. The same pass sums the scores of each record's parts, which `model_error` compares.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.identification.output_error.misfit import Misfit, misfit_series
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import Triangle, WeightedRows
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.identification.search.solve import covariance
from mechid.identification.uncertainty.parts import PartsOfRecord, RecordParts
from mechid.identification.uncertainty.settings import NOISE
from mechid.signal.autoregression import Autoregression, fit_autoregression
from mechid.signal.series import Series, blocks, stretch_of
from mechid.signal.stored import WritableSeries, pieces_of, write_at


@dataclass(frozen=True)
class Scores:
    """What the records say of the score at a point: its variance by noise, and the parts that it is made of.

    Attributes
    ----------
    variance : (n, n)
        Under each residual's own colour, priors included.
    parts : tuple of RecordParts
        Of each record.
    """

    variance: FloatArray
    parts: tuple[RecordParts, ...]


@dataclass(frozen=True)
class Uncertainty:
    """Covariances in search coordinates, (n, n): of white residuals, and robust to their colour."""

    white: FloatArray
    robust: FloatArray


def uncertainty(problem: Problem, q: FloatArray, windows: Windows, triangle: Triangle, seen: BoolArray) -> Uncertainty:
    """Return both covariances at `q`; coordinates that are not `seen` get zeros.

    Sigmas of the targets are taken as they are: the caller has released them to the residuals. The channels of a
    record are taken as independent of one another.
    """
    return covariances(triangle, scores(problem, q, windows).variance, seen)


def scores(problem: Problem, q: FloatArray, windows: Windows) -> Scores:
    """Return what the records that have a window say of the score at `q`: a streamed pass over each."""
    _, known = problem.coordinates.prior_rows(q)
    variance, parts = known.T @ known, []
    for t in (t for t in problem.targets if t.name in windows):
        colour = _colours(problem, t, q, windows[t.name])
        own, of_record = _score(problem, t, q, windows[t.name], colour)
        variance += own
        parts.append(of_record)
    return Scores(variance, tuple(parts))


def covariances(triangle: Triangle, variance: FloatArray, seen: BoolArray) -> Uncertainty:
    """Return both covariances where some coordinates are estimated and the others held; those get zeros."""
    inverse = np.zeros_like(variance)
    inverse[np.ix_(seen, seen)] = covariance(Triangle(triangle.norm, triangle.jacobian[:, seen], triangle.samples))
    return Uncertainty(inverse, inverse @ variance @ inverse)


def residual(problem: Problem, target: Target, q: FloatArray, window: tuple[int, int]) -> tuple[WritableSeries, ...]:
    """Return the misfit of each channel less offset and drift over a window, n samples; 0 at rejected samples."""
    series = misfit_series(problem.model, target, q, window)
    for channel, r in zip(target.channels, series, strict=True):
        rejected = channel.rejected_within(window)
        channel.line(r, rejected).subtract_from(r)
        write_at(r, rejected, 0.0)
    return series


def residuals_by_quantity(
    problem: Problem, target: Target, q: FloatArray, window: tuple[int, int] | None = None
) -> dict[str, WritableSeries]:
    """Return `residual` by the quantity of each channel; without a window over the whole record."""
    series = residual(problem, target, q, window or (0, target.samples))
    return dict(zip(target.quantities, series, strict=True))


def _colours(problem: Problem, target: Target, q: FloatArray, window: tuple[int, int]) -> tuple[Autoregression, ...]:
    """Return the model of what stands behind each channel's prefilter."""
    series = _whitened(problem, target, q, window)
    return tuple(
        fit_autoregression(r, rejected=channel.rejected_within(window))
        for channel, r in zip(target.channels, series, strict=True)
    )


def _whitened(problem: Problem, target: Target, q: FloatArray, window: tuple[int, int]) -> list[WritableSeries]:
    """Return the residuals behind the channels' prefilters, n samples; 0 where their memory is not of the residual."""
    series = residual(problem, target, q, window)
    return [_white(channel, r, window) for channel, r in zip(target.channels, series, strict=True)]


def _white(channel: TargetChannel, r: WritableSeries, window: tuple[int, int]) -> WritableSeries:
    """Return a residual behind its channel's prefilter, written over it."""
    if channel.prefilter is None:
        return r
    order = channel.order
    memory = np.zeros(order)
    for part in blocks(r.size):
        r[part], memory = channel.prefilter.whiten_rows(r[part], memory)
    r[:order] = 0.0
    spoilt = channel.rejected_within((window[0] - order, window[1])) - order
    spoilt = np.unique(spoilt[:, np.newaxis] + np.arange(order + 1))
    write_at(r, spoilt[(spoilt >= 0) & (spoilt < r.size)], 0.0)
    return r


def _score(
    problem: Problem, target: Target, q: FloatArray, window: tuple[int, int], colour: tuple[Autoregression, ...]
) -> tuple[FloatArray, RecordParts]:
    """Return J^T C J / sigma^4, summed over channels, with C the residual's covariance; and the score by parts.

    Coloured noise: by filtering J through 1/A. Rounding: its error stands still while the channel does, so it is one
    for all samples of a visit to a step of the instrument, of variance q^2/12, and independent between visits. Sums
    are of products of all columns of [Phi r J]; offset and drift are projected out of the sums, in one pass.
    """
    rows = WeightedRows(Misfit(problem.model, target, q, window, jacobian=True))
    coloured = [_Coloured(*each, window) for each in zip(target.channels, colour, rows.widths, strict=True)]
    whitened = all(
        own.order == 0 and c.rounded <= NOISE.mostly_rounding for c, own in zip(target.channels, colour, strict=True)
    )
    parts = PartsOfRecord(target, problem.coordinates.timing(target, q), window, rows.widths, whitened=whitened)
    for k, block, n in rows:
        coloured[k].add(block[:, :n])
        parts.add(k, block[:, :n])
    projected = parts.projections
    score = sum((c.score(of[:, 1:]) for c, of in zip(coloured, projected, strict=True)), np.zeros((problem.size,) * 2))
    return score, parts.summed(projected)


class Visits:
    """Sums over the visits to each step of an instrument, of rows that come block by block.

    Parameters
    ----------
    measured : Series of N samples
        A visit lasts while it does not change.
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
        """Add the next rows, (m, n), one at least."""
        begins = np.flatnonzero(self._begins[self._done : self._done + len(rows)])
        self._done += len(rows)
        starts = begins if begins.size and begins[0] == 0 else np.concatenate([[0], begins])
        sums = np.add.reduceat(rows, starts, axis=0)
        if starts.size > begins.size:
            sums[0] += self._open
        else:
            sums = np.vstack([self._open, sums])
        self._open = sums[-1]
        self._closed += sums[:-1].T @ sums[:-1]

    @property
    def total(self) -> FloatArray:
        """Sum over visits of s s^T, (n, n), with s the sum of the rows of a visit."""
        return self._closed + np.outer(self._open, self._open)


class _Coloured:
    """The variance of a channel's score under its residual's own colour, from rows that come block by block."""

    def __init__(self, channel: TargetChannel, own: Autoregression, width: int, window: tuple[int, int]) -> None:
        self._channel, self._own = channel, own
        self._memory = np.zeros((width, own.order))
        self._total = np.zeros((width, width))
        self._visits = Visits(stretch_of(channel.measured, *window), width) if channel.rounded else None

    def add(self, rows: FloatArray) -> None:
        """Add the next samples, (width, m)."""
        if self._visits is not None:
            self._visits.add(rows.T)
        if self._own.order:
            rows, self._memory = self._own.colour_rows(rows, self._memory)
        self._total += rows @ rows.T

    def score(self, columns: FloatArray) -> FloatArray:
        """Return that of all rows over linear functions of the columns, (width, n)."""
        total = columns.T @ self._total @ columns
        score = total * (1.0 - self._channel.rounded) * (self._own.sigma / self._channel.scale) ** 2
        if self._visits is not None:
            score += columns.T @ self._visits.total @ columns * self._channel.rounded
        return np.asarray(score, dtype=np.float64)
