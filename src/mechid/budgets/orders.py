"""Orders of a periodic torque: amplitudes over the rate, crossings with modes, and rates to avoid.

At r full steps/s the electrical angle completes one turn in 4/r s. The mechanism repeats after half of that with its
torques mirrored in sign, so that its lines lie at k r/2, k = 1, 2, ... (k = 2 is one line per step).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import ComplexArray, FloatArray


def phasors(y: FloatArray, sample_rate: float, frequency_hz: FloatArray) -> ComplexArray:
    """Return the phasors of lines at given frequencies, fitted together with a constant by least squares.

    Parameters
    ----------
    y : (N,) or (N, m)
        Samples from time 0 on, in any unit.
    sample_rate : float
        Hz.
    frequency_hz : (n,)
        Frequencies of the lines, below half the sample rate, separated by at least the reciprocal of the duration.

    Returns
    -------
    (n,) or (n, m) complex
        Peak amplitude and phase: y = Re(phasor e^(2 pi i f t)).
    """
    angle = 2.0 * np.pi / sample_rate * np.outer(np.arange(len(y)), frequency_hz)
    # The constant is fitted too: over a duration that is not a whole number of periods it is not orthogonal to the
    # lines.
    columns = np.hstack([np.cos(angle), np.sin(angle), np.ones((len(y), 1))])
    fitted = np.linalg.solve(columns.T @ columns, columns.T @ y)
    n = frequency_hz.size
    return np.asarray(fitted[:n] - 1j * fitted[n : 2 * n], dtype=np.complex128)


@dataclass(frozen=True, eq=False)
class OrderMap:
    """Lines over the step rate.

    Attributes
    ----------
    rates : (r,)
        Full steps/s, ascending.
    orders : (k,)
        The frequency of a line is its order times the rate.
    lines : (r, k) complex
        Peak amplitudes and phases, NaN if unknown.
    """

    rates: FloatArray
    orders: FloatArray
    lines: ComplexArray

    @property
    def frequency_hz(self) -> FloatArray:
        """Frequency of each line, (r, k)."""
        return np.outer(self.rates, self.orders)

    def envelope(self, edges_hz: FloatArray) -> FloatArray:
        """Return the largest amplitude at any rate in each band of frequency, (b,); `edges_hz` is (b + 1,)."""
        band = np.digitize(self.frequency_hz, edges_hz) - 1
        size = np.nan_to_num(np.abs(self.lines))
        return np.array([size[band == b].max(initial=0.0) for b in range(edges_hz.size - 1)])


@dataclass(frozen=True)
class Crossing:
    """Crossing of an order with a mode: at `rate` full steps/s, order times rate is `frequency_hz`."""

    order: float
    mode: str
    frequency_hz: float
    rate: float


def crossings(
    orders: Sequence[float], modes: Sequence[tuple[str, float]], rates: tuple[float, float]
) -> list[Crossing]:
    """Return the crossings of a Campbell diagram within a range of rates, by rate.

    Parameters
    ----------
    orders : sequence of float
        Lines per full step.
    modes : sequence of (name, Hz)
    rates : (lowest, highest) full steps/s
    """
    found = [Crossing(q, name, f, f / q) for q in orders for name, f in modes if q > 0.0]
    return sorted((c for c in found if rates[0] <= c.rate <= rates[1]), key=lambda c: c.rate)


def rates_to_avoid(rates: FloatArray, values: FloatArray, limit: float) -> Iterator[tuple[float, float]]:
    """Yield the ranges of rate, from and to, in which values at ascending rates, (r,), exceed a limit.

    The ends are interpolated linearly; a range ends at the first and last rate.
    """
    over = values > limit
    start: float | None = None
    for k, rate in enumerate(rates):
        if over[k] and start is None:
            start = float(rate) if k == 0 else _crossing_rate(rates, values, limit, k)
        if not over[k] and start is not None:
            yield start, _crossing_rate(rates, values, limit, k)
            start = None
    if start is not None:
        yield start, float(rates[-1])


def _crossing_rate(rates: FloatArray, values: FloatArray, limit: float, k: int) -> float:
    """Return the rate at which the segment from k - 1 to k crosses the limit."""
    share = (limit - values[k - 1]) / (values[k] - values[k - 1])
    return float(rates[k - 1] + share * (rates[k] - rates[k - 1]))
