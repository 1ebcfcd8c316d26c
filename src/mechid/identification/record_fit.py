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
from mechid.identification.target import target_of
from mechid.identification.uncertainty import linear_part
from mechid.signal import fit_percent

FloatArray = NDArray[np.float64]


def record_fit(record: CampaignRecord, problem: Problem, q: FloatArray, windows: Windows) -> RecordFit:
    """Return how the model at `q` predicts a record over its window, or over all of it where it has none."""
    target = next((t for t in problem.targets if t.name == record.name), None) or target_of(record)
    floor = target_of(record).sigma
    first, stop = windows.get(record.name, (0, target.samples))
    measured = target.measured[first:stop]
    residual = measured - problem.predict(target, q, stop)[first:]
    fitted, offset, slope = _linear(residual, target)
    residual -= fitted
    follows = followed(problem, replace(target, sigma=floor), q)
    return RecordFit(
        name=record.name,
        use=record.use,
        samples=stop - first,
        fit_percent=fit_percent(measured - fitted, residual),
        residual_rms=float(np.sqrt(np.mean(residual**2))),
        noise_sigma=floor,
        offset=None if offset is None else offset - (slope or 0.0) * first,
        drift=None if slope is None else slope * target.base.sample_rate_hz,
        horizon_s=max(follows - 1, 0) / target.base.sample_rate_hz,
    )


def _linear(r: FloatArray, target: Target) -> tuple[FloatArray, float | None, float | None]:
    """Fit what is projected out; a failed prediction leaves everything undefined."""
    if not np.all(np.isfinite(r)):
        return np.full(r.size, math.nan), None, None
    return linear_part(r, target.linear)
