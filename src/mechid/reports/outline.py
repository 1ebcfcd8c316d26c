"""Long record for a page: its outline, and all samples of named stretches.

All samples of an hour at 10 kHz would make a page of about 50 MB. The outline holds the minimum and maximum of each of
`COLUMNS` columns as integer steps with their sample numbers, both as differences; a page draws it like samples.
Stretches are `Trace` objects.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mechid.analysis.prediction import Prediction
from mechid.arrays import FloatArray
from mechid.reports.packing import Packed, pack_integers, unpack
from mechid.reports.trace import Trace, reached_by, step_of, trace_of
from mechid.signal.envelope import envelope
from mechid.signal.remainder import Remainder
from mechid.signal.series import Series, stretch_of
from mechid.signal.stored_series import samples_at

COLUMNS = 8192
"""Columns of the whole record: five times those of a wide screen."""
DETAIL_S = 2.0
"""Length of a stretch that is kept with all samples, s."""


@dataclass(frozen=True, kw_only=True)
class Extremes:
    """Minimum and maximum of each column of a curve: sample numbers and integer steps."""

    numbers: Packed
    steps: Packed


@dataclass(frozen=True, kw_only=True)
class Outline:
    """A long record beside its prediction.

    Attributes
    ----------
    samples : int
    start_s, sample_rate_hz : float
    step : float
        Unit of the integers, N m.
    curves : mapping of str to Extremes
        ``"measured"``, less offset and drift, ``"modelled"`` and ``"residual"``; the last two up to the end of the
        simulation.
    stretches : mapping of str to Trace
        All samples of the named stretches.
    """

    samples: int
    start_s: float
    sample_rate_hz: float
    step: float
    curves: Mapping[str, Extremes]
    stretches: Mapping[str, Trace]

    @property
    def column_s(self) -> float:
        """Duration of a column, s."""
        return self.samples / self.sample_rate_hz / COLUMNS


def outline_of(prediction: Prediction, noise: float, around: Mapping[str, float]) -> Outline:
    """Return a long record and its prediction for a page.

    Parameters
    ----------
    prediction : Prediction
    noise : float
        Standard deviation of the record's noise, N m.
    around : mapping of str to float
        Record time in s of the middle of each stretch, by its name.
    """
    p = prediction
    # Beyond the end of a failed simulation there is nothing finite to round to steps.
    reached = reached_by(p.modelled)
    left = Remainder(p.measured, p.level.line, p.modelled)
    modelled, residual = (stretch_of(one, 0, reached) for one in (p.modelled, left))
    series = {"measured": p.level, "modelled": modelled, "residual": residual}
    step = step_of(p, noise)
    return Outline(
        samples=p.base.samples,
        start_s=p.base.start_s,
        sample_rate_hz=p.base.sample_rate_hz,
        step=step,
        curves={name: _extremes(one, step) for name, one in series.items()},
        stretches={words: trace_of(p, noise, _part(p, middle_s)) for words, middle_s in around.items()},
    )


def _part(p: Prediction, middle_s: float) -> slice:
    """Return the slice of a stretch around a time, shifted to lie within the record."""
    samples = round(DETAIL_S * p.base.sample_rate_hz)
    middle = round((middle_s - p.base.start_s) * p.base.sample_rate_hz)
    # At an end of the record the stretch is shifted inwards, so that it keeps its length.
    first = min(max(middle - samples // 2, 0), max(p.base.samples - samples, 0))
    return slice(first, min(first + samples, p.base.samples))


def _extremes(series: Series, step: float) -> Extremes:
    kept = envelope(series, COLUMNS)
    steps = np.rint(samples_at(series, kept) / step).astype(np.int64)
    # Differences of ascending numbers are small, and small numbers deflate well.
    return Extremes(numbers=pack_integers(np.diff(kept, prepend=0)), steps=pack_integers(np.diff(steps, prepend=0)))


def decode_outline(outline: Outline, curve: str) -> tuple[FloatArray, FloatArray]:
    """Return the record times in s and samples, (m,) each, of a curve of an outline: the twin of the page's script."""
    one = outline.curves[curve]
    times = outline.start_s + np.cumsum(unpack(one.numbers)) / outline.sample_rate_hz
    return times, np.cumsum(unpack(one.steps)) * outline.step
