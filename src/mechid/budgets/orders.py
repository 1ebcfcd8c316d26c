"""Lines of a torque that repeats with the steps: over the rate, against modes, and rates to avoid.

At r full steps/s the electrical angle turns once in 4/r s; the mechanism repeats with half of that, mirrored, in
its torques up to a sign, so that its lines stand at k r/2, k = 1, 2, ... (k = 2 is one line a step).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import ComplexArray, FloatArray


def phasors(y: FloatArray, sample_rate: float, frequency_hz: FloatArray) -> ComplexArray:
    """Return the lines that fit samples best together, beside a constant, by least squares.

    Parameters
    ----------
    y : (N,) or (N, m)
        Samples from time 0 on, in any unit.
    sample_rate : float
        Hz.
    frequency_hz : (n,)
        Of the lines, below half the sample rate, apart by a reciprocal of the samples' duration at least.

    Returns
    -------
    (n,) or (n, m) complex
        Peak amplitude and phase: y = Re(phasor e^(2 pi i f t)).
    """
    angle = 2.0 * np.pi / sample_rate * np.outer(np.arange(len(y)), frequency_hz)
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
        A line's frequency is its order times the rate.
    lines : (r, k) complex
        Peak amplitudes and phases, NaN where none is known.
    """

    rates: FloatArray
    orders: FloatArray
    lines: ComplexArray

    @property
    def frequency_hz(self) -> FloatArray:
        """Of each line, (r, k)."""
        return np.outer(self.rates, self.orders)

    def envelope(self, edges_hz: FloatArray) -> FloatArray:
        """Return the largest amplitude at any rate in each band of frequency, (b,); `edges_hz` is (b + 1,)."""
        band = np.digitize(self.frequency_hz, edges_hz) - 1
        size = np.nan_to_num(np.abs(self.lines))
        return np.array([size[band == b].max(initial=0.0) for b in range(edges_hz.size - 1)])


@dataclass(frozen=True)
class Crossing:
    """Where an order meets a mode: at `rate` full steps/s, order times rate is `frequency_hz`."""

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

    The ends are interpolated linearly; at the first and last rate a range ends there.
    """
    over = values > limit
    start: float | None = None
    for k, rate in enumerate(rates):
        if over[k] and start is None:
            start = float(rate) if k == 0 else _crossed(rates, values, limit, k)
        if not over[k] and start is not None:
            yield start, _crossed(rates, values, limit, k)
            start = None
    if start is not None:
        yield start, float(rates[-1])


def _crossed(rates: FloatArray, values: FloatArray, limit: float, k: int) -> float:
    """Return the rate at which the line from k - 1 to k meets the limit."""
    share = (limit - values[k - 1]) / (values[k] - values[k - 1])
    return float(rates[k - 1] + share * (rates[k] - rates[k - 1]))
