"""Differences of angles on the circle."""

from __future__ import annotations

from typing import TypeVar

from mechid.arrays import FloatArray

Angle = TypeVar("Angle", float, FloatArray)


def angle_difference(angle_deg: Angle, from_deg: float = 0.0) -> Angle:
    """Return the signed shortest difference of two angles, in [-180, 180) deg.

    Examples
    --------
    >>> angle_difference(179.0, -179.0), angle_difference(-179.0, 179.0), angle_difference(180.0)
    (-2.0, 2.0, -180.0)
    """
    return (angle_deg - from_deg + 180.0) % 360.0 - 180.0
