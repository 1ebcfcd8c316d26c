"""A long record for a page: the outline of all of it, and every sample of the stretches that have a name.

Every sample of an hour at 10 kHz would be a page of some 50 MB. The outline holds the least and the largest sample of
each of `COLUMNS` columns, as whole steps with their numbers, both as differences; a page draws it as it does
samples. Stretches are `Trace`s.
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
from mechid.signal.stored import samples_at

COLUMNS = 8192
"""Of the whole record: five times what a wide screen has."""
DETAIL_S = 2.0
"""Of a stretch whose every sample is there."""


@dataclass(frozen=True, kw_only=True)
class Extremes:
    """The least and the largest sample of each column of a curve: their numbers, and their whole steps."""

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
        What one whole number stands for, N m.
    curves : mapping of str to Extremes
        Of ``"measured"``, less offset and drift, ``"modelled"`` and ``"residual"``; the last two as far as the
        simulation came.
    stretches : mapping of str to Trace
        Every sample of the stretches that are worth a look, by their words.
    """

    samples: int
    start_s: float
    sample_rate_hz: float
    step: float
    curves: Mapping[str, Extremes]
    stretches: Mapping[str, Trace]

    @property
    def column_s(self) -> float:
        """How long a column lasts, s."""
        return self.samples / self.sample_rate_hz / COLUMNS


def outline_of(prediction: Prediction, noise: float, around: Mapping[str, float]) -> Outline:
    """Return a long record and its prediction for a page.

    Parameters
    ----------
    prediction : Prediction
    noise : float
        Standard deviation of the record's noise, N m.
    around : mapping of str to float
        Record time in s in the middle of each stretch that is shown in every sample, by its words.
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
    """Return the samples around a time, as many within the record as a stretch has."""
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


def decoded(outline: Outline, curve: str) -> tuple[FloatArray, FloatArray]:
    """Return the record times in s and samples, (m,) each, of a curve of an outline: the twin of the page's script."""
    one = outline.curves[curve]
    times = outline.start_s + np.cumsum(unpack(one.numbers)) / outline.sample_rate_hz
    return times, np.cumsum(unpack(one.steps)) * outline.step
