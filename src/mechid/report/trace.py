"""Every sample of a record and of its prediction, small enough for a page.

Both are rounded to whole steps of a tenth of the record's noise, so that a sample is off by at most a twentieth
of it. The prediction goes as its second differences, the record as its difference to the prediction: small
numbers both, which deflate well.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechid.analysis.prediction import Prediction
from mechid.report.packing import Packed, pack_integers, unpack

FloatArray = NDArray[np.float64]
SHARE_OF_NOISE = 0.1
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
        What one whole number stands for, N m.
    offset, drift : float
        What was removed from the record, N m at its first sample and N m a sample.
    model : Packed
        Second differences of the prediction; as many as the simulation reached.
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


def trace_of(prediction: Prediction, noise: float) -> Trace:
    """Return a record and its prediction for a page.

    Parameters
    ----------
    prediction : Prediction
    noise : float
        Standard deviation of the record's noise, N m.
    """
    removed = np.nan_to_num(prediction.removed)
    measured, n = prediction.measured - removed, prediction.measured.size
    finite = np.isfinite(prediction.modelled)
    reached = n if bool(finite.all()) else int(np.argmin(finite))
    modelled = prediction.modelled[:reached]
    largest = max(float(np.abs(measured).max()), float(np.abs(modelled).max(initial=0.0)))
    step = max(SHARE_OF_NOISE * noise if np.isfinite(noise) else 0.0, largest / LARGEST) or 1.0
    whole = np.rint(modelled / step).astype(np.int64)
    difference = np.rint(measured / step).astype(np.int64)
    difference[:reached] -= whole
    return Trace(
        samples=n,
        start_s=prediction.base.start_s,
        sample_rate_hz=prediction.base.sample_rate_hz,
        step=step,
        offset=float(removed[0]),
        drift=float(removed[-1] - removed[0]) / max(n - 1, 1),
        model=pack_integers(np.diff(whole, n=2, prepend=[0, 0])),
        difference=pack_integers(difference),
    )


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
