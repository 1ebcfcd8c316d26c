"""Angles of several units as numbers on one branch, so that 179 and -179 deg are 2 deg apart."""

from __future__ import annotations

import numpy as np

from mechid.arrays import FloatArray
from mechid.units import angle_difference

UNKNOWN_DEG = 180.0 / np.sqrt(3.0)
"""Standard deviation of a uniformly distributed angle; an estimate with that error or more is undetermined."""


def unwrap_angles(angles_deg: FloatArray, errors_deg: FloatArray) -> FloatArray:
    """Return angles on the branch about their weighted mean direction, which lies in [-180, 180).

    Examples
    --------
    >>> unwrap_angles(np.array([179.0, -179.0]), np.ones(2)).round(6).tolist()
    [-181.0, -179.0]
    """
    # The added square degree keeps one very precise estimate from fixing the branch alone.
    weights = 1.0 / (np.square(errors_deg) + 1.0)
    centre = angle_difference(float(np.degrees(np.angle(np.sum(weights * np.exp(1j * np.radians(angles_deg)))))))
    return centre + angle_difference(angles_deg, centre)
