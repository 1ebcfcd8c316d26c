"""Compact encoding of all samples of a record and its prediction for a page.

Both are rounded to integer steps of a tenth of the record's noise, so that a sample is off by at most a twentieth of
it. The prediction is stored as second differences, the record as its difference from the prediction. Both are small
numbers, which deflate well.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mechid.analysis.prediction import Prediction
from mechid.arrays import FloatArray, IntArray
from mechid.reports.packing import Packed, pack_integer_blocks, unpack
from mechid.signal.series import Series, blocks, stretch_of

SHARE_OF_NOISE = 0.1
ALL = slice(None)
LARGEST = 2.0**27
"""Steps from zero to the largest sample at most; of its second differences zigzag needs three bits more."""


@dataclass(frozen=True, kw_only=True)
class Trace:
    """A record beside its prediction, rounded and packed.

    Attributes
    ----------
    samples : int
    start_s, sample_rate_hz : float
    step : float
        Unit of the integers, N m.
    offset, drift : float
        Line removed from the record: N m at its first sample, and N m per sample.
    model : Packed
        Second differences of the prediction, up to the end of the simulation.
    difference : Packed
        Record less offset, drift and prediction; beyond the prediction, less the first two alone.
    """

    samples: int
    start_s: float
    sample_rate_hz: float
    step: float
    offset: float
    drift: float
    model: Packed
    difference: Packed


def trace_of(prediction: Prediction, noise: float, part: slice = ALL) -> Trace:
    """Return a record and its prediction for a page.

    Parameters
    ----------
    prediction : Prediction
    noise : float
        Standard deviation of the record's noise, N m.
    part : slice
        Samples to take; all by default.
    """
    base, line, step = prediction.base, prediction.level.line, step_of(prediction, noise, part)
    first, stop, _ = part.indices(base.samples)
    measured, modelled = (stretch_of(one, first, stop) for one in (prediction.level, prediction.modelled))
    modelled = stretch_of(modelled, 0, reached_by(modelled))
    return Trace(
        samples=stop - first,
        start_s=base.start_s + first / base.sample_rate_hz,
        sample_rate_hz=base.sample_rate_hz,
        step=step,
        offset=line.offset + line.slope * first,
        drift=line.slope,
        model=pack_integer_blocks(modelled.size, _second_differences(modelled, step)),
        difference=pack_integer_blocks(stop - first, _differences(measured, modelled, step)),
    )


def step_of(prediction: Prediction, noise: float, part: slice = ALL) -> float:
    """Return the unit of the integers in N m: a tenth of the noise, or more for very large samples."""
    series = (stretch_of(one, *part.indices(one.size)[:2]) for one in (prediction.level, prediction.modelled))
    measured, modelled = series
    largest = max(_largest(measured), _largest(stretch_of(modelled, 0, reached_by(modelled))))
    # A record of zeros without noise has no scale; any step represents it.
    return max(SHARE_OF_NOISE * noise if np.isfinite(noise) else 0.0, largest / LARGEST) or 1.0


def reached_by(modelled: Series) -> int:
    """Return the number of samples before the first that is not finite."""
    for part in blocks(modelled.size):
        lost = np.flatnonzero(~np.isfinite(modelled[part]))
        if lost.size:
            return int(part.start + lost[0])
    return modelled.size


def _largest(series: Series) -> float:
    return max((float(np.abs(series[part]).max()) for part in blocks(series.size)), default=0.0)


def _steps(y: FloatArray, step: float) -> IntArray:
    return np.rint(y / step).astype(np.int64)


def _second_differences(y: Series, step: float) -> Iterator[IntArray]:
    """Yield second differences of the rounded samples block by block, with zeros before the first sample."""
    for part in blocks(y.size):
        # Two samples of the previous block make the differences continue across its end.
        two = _steps(y[max(part.start - 2, 0) : part.start], step)
        before = np.concatenate((np.zeros(2 - two.size, dtype=np.int64), two))
        yield np.diff(_steps(y[part], step), n=2, prepend=before)


def _differences(measured: Series, modelled: Series, step: float) -> Iterator[IntArray]:
    """Yield the rounded samples less the rounded prediction, up to its end, block by block."""
    for part in blocks(measured.size):
        steps, model = _steps(measured[part], step), _steps(modelled[part], step)
        # Both are rounded before the subtraction, so that the sum on the page is the rounded sample exactly.
        steps[: model.size] -= model
        yield steps


def decode(trace: Trace) -> tuple[FloatArray, FloatArray]:
    """Return the record less offset and drift, (N,), and the prediction, (N,), NaN where it has none; N m.

    The slow twin of the page's script.
    """
    whole = np.cumsum(np.cumsum(unpack(trace.model)))
    measured = unpack(trace.difference)
    measured[: whole.size] += whole
    modelled = np.full(trace.samples, np.nan)
    modelled[: whole.size] = whole * trace.step
    return measured * trace.step, modelled
