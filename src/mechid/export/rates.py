"""Rates of a forcing as a user writes them: `5,10,46`, or `5:120:24` for 24 from 5 to 120."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mechid.errors import UsageError

FloatArray = NDArray[np.float64]

MOST = 2000
EXAMPLE = "write full steps/s as 5,10,46 or FROM:TO:COUNT as 5:120:24"


def rates_of(text: str) -> FloatArray:
    """Return rates, (r,) full steps/s ascending.

    Raises
    ------
    UsageError
        They are no rates above 0, or too many.

    Examples
    --------
    >>> rates_of("46, 5").tolist(), rates_of("10:20:3").tolist()
    ([5.0, 46.0], [10.0, 15.0, 20.0])
    """
    try:
        if ":" in text:
            first, last, count = text.split(":")
            rates = np.linspace(float(first), float(last), _count(count))
        else:
            rates = np.array([float(part) for part in text.split(",")])
    except ValueError as error:
        raise UsageError(f'--rates: found "{text}"; {EXAMPLE}') from error
    if wrong := [rate for rate in rates.tolist() if not (math.isfinite(rate) and rate > 0.0)]:
        raise UsageError(f"--rates: found {wrong[0]:g}; rates are above 0: {EXAMPLE}")
    return np.unique(rates)


def _count(text: str) -> int:
    count = int(text)
    if not 1 <= count <= MOST:
        raise UsageError(f"--rates: found {count} rates; write 1 to {MOST}")
    return count
