"""What drives the plant: inputs that change at instants and hold between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Excitation:
    """Piecewise constant inputs in command time.

    Parameters
    ----------
    initial : (I,) float
        Values from before t = 0 until the first edge.
    times : (E,) float
        Instants of the edges in s, 0 < t, strictly ascending.
    values : (E, I) float
        Values from each edge on.
    inputs : tuple of str, (I,)
        Names of the inputs; by default the normalised phase voltages, without unit.
    """

    initial: FloatArray
    times: FloatArray
    values: FloatArray
    inputs: tuple[str, ...] = ("e_A", "e_B")


def most_within(times: FloatArray, width_s: float) -> int:
    """Return the greatest number of `times`, (E,) ascending, in any half-open interval of a width in s.

    Times just a width apart, up to rounding, do not share an interval.
    """
    after = np.searchsorted(times, times + width_s * (1.0 - 1e-9), side="left")
    return int(np.max(after - np.arange(times.size), initial=0))
