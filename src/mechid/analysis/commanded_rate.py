"""Commanded step rate over record time."""

from __future__ import annotations

import numpy as np

from mechid.analysis.settings import ORDER
from mechid.arrays import FloatArray
from mechid.command import RateProfile
from mechid.simulation.simulator import TimeBase


def commanded_rate(profile: RateProfile, time_offset_s: float, base: TimeBase) -> FloatArray:
    """Return a rate profile in record time: breakpoints, (R, 2) of s and full steps/s; (1, 2) for a constant rate.

    Parameters
    ----------
    profile : RateProfile
    time_offset_s : float
        Record time at which the profile starts.
    base : TimeBase
        Time base of the record.
    """
    until = base.start_s + (base.samples - 1) / base.sample_rate_hz
    points = np.array([(t + time_offset_s, r) for t, r in zip(profile.times_s, profile.rates, strict=True)])
    inside = points[(points[:, 0] > base.start_s) & (points[:, 0] < until)]
    # Points outside the record are replaced by interpolated values at its ends.
    ends = [(t, float(np.interp(t, points[:, 0], points[:, 1]))) for t in (base.start_s, until)]
    rate = np.array([ends[0], *map(tuple, inside), ends[1]])
    spread = float(np.ptp(rate[:, 1]))
    return rate if spread > ORDER.one_rate * float(np.abs(rate[:, 1]).max()) else rate[:1]
