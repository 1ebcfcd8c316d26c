"""How well one record is predicted at the end of a fit."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mechid.campaign import CampaignRecord
from mechid.identification.fit import RecordFit
from mechid.identification.gates import followed
from mechid.identification.problem import Problem, Target, Windows
from mechid.identification.target import noise_sigma, target_of
from mechid.signal.trend import Line, fit_line

FloatArray = NDArray[np.float64]


def record_fit(record: CampaignRecord, problem: Problem, q: FloatArray, windows: Windows) -> RecordFit:
    """Return how the model at `q` predicts a record over its window, or over all of it where it has none."""
    target = next((t for t in problem.targets if t.name == record.name), None) or target_of(record)
    floor = noise_sigma(record)
    first, stop = windows.get(record.name, (0, target.samples))
    rms, line = _residual(problem, target, q, (first, stop))
    spread = _spread(target.measured[first:stop], line) / math.sqrt(stop - first)
    follows = followed(problem, replace(target, sigma=floor), q)
    return RecordFit(
        name=record.name,
        use=record.use,
        samples=stop - first,
        fit_percent=100.0 * (1.0 - rms / spread) if spread > 0.0 else math.nan,
        residual_rms=rms,
        noise_sigma=floor,
        offset=line.offset - line.slope * first if line and target.linear > 0 else None,
        drift=line.slope * target.base.sample_rate_hz if line and target.linear > 1 else None,
        prefilter_order=target.prefilter.order if target.prefilter else 0,
        rejected=_rejected(target, (first, stop)).size,
        horizon_s=max(follows - 1, 0) / target.base.sample_rate_hz,
    )


def _residual(problem: Problem, target: Target, q: FloatArray, window: tuple[int, int]) -> tuple[float, Line | None]:
    """Return the RMS of measured minus model, and the line that was taken from it; NaN, None for a failed run."""
    r = problem.misfit(target, q, window)
    if not np.all(np.isfinite(r)):
        return math.nan, None
    line = fit_line(r, target.linear)
    line.take_from(r)
    rejected = _rejected(target, window) - window[0]
    r[rejected] = 0.0
    return float(np.linalg.norm(r)) / math.sqrt(r.size - rejected.size), line


def _rejected(target: Target, window: tuple[int, int]) -> NDArray[np.int64]:
    """Return the samples of a window that do not count."""
    return target.rejected[(target.rejected >= window[0]) & (target.rejected < window[1])]


def _spread(measured: FloatArray, line: Line | None) -> float:
    """Return ||measured - line - mean||."""
    own = measured.copy()
    (line or Line()).take_from(own)
    own -= own.mean()
    return float(np.linalg.norm(own))
