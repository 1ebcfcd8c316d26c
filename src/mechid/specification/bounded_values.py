"""Values of one quantity over frequency with their bounds: what a verdict compares with a mask."""

from __future__ import annotations

from dataclasses import dataclass

from mechid.arrays import FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class BoundedValues:
    """Values of one quantity over frequency with bounds, (n,) each, in the SI unit of the requirement.

    Attributes
    ----------
    frequency_hz : ndarray
        Of a line or a bin, or the centre of a band.
    value : ndarray
        Without background and Rice bias.
    sigma : ndarray
        Standard error.
    lower, upper : ndarray
        Bounds: the lower ones hold for all frequencies together, an upper one for its own.
    background : ndarray
        Part of the background, or the least that can be shown where there is none.
    limit : ndarray
        Of the mask, the margin subtracted.
    """

    frequency_hz: FloatArray
    value: FloatArray
    sigma: FloatArray
    lower: FloatArray
    upper: FloatArray
    background: FloatArray
    limit: FloatArray
