"""Piecewise constant inputs of the plant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Excitation:
    """Piecewise constant inputs over command time.

    Parameters
    ----------
    initial : (I,) float
        Values before the first edge, including times before t = 0.
    times : (E,) float
        Instants of the edges in s, 0 < t, strictly ascending.
    values : (E, I) float
        Values from each edge on.
    inputs : tuple of str, (I,)
        Names of the inputs; by default the normalised phase voltages, dimensionless.
    """

    initial: FloatArray
    times: FloatArray
    values: FloatArray
    inputs: tuple[str, ...] = ("e_A", "e_B")


def most_within(times: FloatArray, width_s: float) -> int:
    """Return the largest number of `times`, (E,) ascending, in any half-open interval of a width in s.

    Times exactly one width apart, up to rounding, do not share an interval.
    """
    after = np.searchsorted(times, times + width_s * (1.0 - 1e-9), side="left")
    return int(np.max(after - np.arange(times.size), initial=0))
