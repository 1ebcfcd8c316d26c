"""Pointing error of the line of sight, a sum of bias, periodic and random parts, and its value under an index."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.budgets.indices import Index
from mechid.budgets.settings import LEVEL


@dataclass(frozen=True)
class Instants:
    """Instants at which one of several parts is evaluated, (p,), equidistributed over all phases and the window.

    Parameters
    ----------
    points : int
        p.
    parts : int
    part : int
        Its position among them.
    """

    points: int
    parts: int
    part: int

    @property
    def phase(self) -> FloatArray:
        """Phase of the part, in turns, (p,)."""
        return phases(self.parts + 1, self.points)[self.part]

    @property
    def position(self) -> FloatArray:
        """Position in the index's window, 0 to 1, (p,); the same for all parts."""
        return phases(self.parts + 1, self.points)[-1]


@dataclass(frozen=True, eq=False)
class Source:
    """Lines at multiples of one frequency, added coherently: a periodic error if all multiples are whole numbers.

    Parameters
    ----------
    name : str
    fundamental_hz : float
    orders : (n,)
        Order of each line.
    phasors : (n, m) complex
        Peak amplitude and phase along each of m lines of sight, rad: the error is Re(phasor e^(2 pi i f t)).
    """

    name: str
    fundamental_hz: float
    orders: FloatArray
    phasors: ComplexArray

    @property
    def frequency_hz(self) -> FloatArray:
        """Frequency of each line, (n,)."""
        return np.asarray(self.orders * self.fundamental_hz, dtype=np.float64)

    def waveform(self, index: Index, at: Instants) -> FloatArray:
        """Return the values under an index, (p, m) rad."""
        turned = _line_values if at.points > LEVEL.quick_points else _cached_line_values
        lines = turned(tuple(self.orders.tolist()), self.fundamental_hz, index, at)
        return np.asarray((lines @ self.phasors).real, dtype=np.float64)

    def square(self, index: Index) -> FloatArray:
        """Return the mean square under an index, (m,) rad^2, by the index's weights."""
        return np.asarray(index.weight(self.frequency_hz) @ (0.5 * np.abs(self.phasors) ** 2), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Sampled:
    """Part known at instants, by its values under one index; every call must use that index.

    Parameters
    ----------
    values : (n, m)
        rad; equidistributed over time, in any order.
    """

    values: FloatArray

    def waveform(self, index: Index, at: Instants) -> FloatArray:
        """Return the values, (p, m) rad, at the positions in the list given by the instants' phases."""
        del index
        return np.asarray(self.values[(at.phase * len(self.values)).astype(np.int64)], dtype=np.float64)

    def square(self, index: Index) -> FloatArray:
        """Return the mean square, (m,) rad^2."""
        del index
        return np.asarray(np.mean(self.values**2, axis=0), dtype=np.float64)


class Part(Protocol):
    """Part of an error besides bias and noise: its value is known up to one phase."""

    def waveform(self, index: Index, at: Instants) -> FloatArray:
        """Return the values under an index, (p, m) rad."""

    def square(self, index: Index) -> FloatArray:
        """Return the mean square under an index, (m,) rad^2."""


@dataclass(frozen=True, eq=False)
class Random:
    """Gaussian part with a one-sided power spectral density.

    Parameters
    ----------
    frequency_hz : (k,)
        In equal steps.
    density : (k, m)
        rad^2/Hz.
    """

    frequency_hz: FloatArray
    density: FloatArray

    def variance(self, index: Index) -> FloatArray:
        """Return the variance under an index, (m,) rad^2."""
        return _variance(self, index)


@lru_cache(maxsize=16)
def _variance(random: Random, index: Index) -> FloatArray:
    """Return a variance shared by all members of an ensemble."""
    step = float(random.frequency_hz[1] - random.frequency_hz[0])
    return np.asarray(index.weight(random.frequency_hz) @ random.density * step, dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Incoherent:
    """Lines of unknown phases, numerous enough to be treated together as Gaussian.

    Parameters
    ----------
    frequency_hz : (k,)
    power : (k, m)
        Mean square of each line along each line of sight, rad^2.
    """

    frequency_hz: FloatArray
    power: FloatArray

    def variance(self, index: Index) -> FloatArray:
        """Return the variance under an index, (m,) rad^2."""
        return np.asarray(index.weight(self.frequency_hz) @ self.power, dtype=np.float64)


@dataclass(frozen=True, eq=False)
class FlatRandom:
    """Gaussian part with a density that is flat up to a frequency.

    Parameters
    ----------
    bandwidth_hz : float
    sigma : (m,)
        Standard deviation over time, rad.
    """

    bandwidth_hz: float
    sigma: FloatArray

    def variance(self, index: Index) -> FloatArray:
        """Return the variance under an index, (m,) rad^2."""
        return flat_share(index, self.bandwidth_hz) * self.sigma**2


@lru_cache(maxsize=64)
def flat_share(index: Index, bandwidth_hz: float) -> float:
    """Return the share of the variance that an index keeps of noise that is flat up to a frequency."""
    points = max(LEVEL.least_points, int(LEVEL.points_a_lobe * bandwidth_hz * index.longest_s))
    return float(np.mean(index.weight(np.linspace(0.0, bandwidth_hz, points))))


@dataclass(frozen=True, eq=False)
class PointingError:
    """Error along m lines of sight; its parts are not synchronous with one another.

    Parameters
    ----------
    bias : (m,)
        rad.
    parts : tuple of Part
        `Source` for lines, `Sampled` for a time series.
    randoms : tuple of Random, FlatRandom or Incoherent
    """

    bias: FloatArray
    parts: tuple[Part, ...] = ()
    randoms: tuple[Random | FlatRandom | Incoherent, ...] = ()

    def sigma(self, index: Index) -> FloatArray:
        """Return the standard deviation of the random parts under an index, (m,) rad."""
        total = np.zeros_like(self.bias)
        for random in self.randoms:
            total = total + random.variance(index)
        return np.asarray(np.sqrt(total), dtype=np.float64)

    def kept_bias(self, index: Index) -> FloatArray:
        """Return the bias under an index, (m,) rad."""
        return index.bias_gain * self.bias

    def rms(self, index: Index) -> FloatArray:
        """Return the root mean square under an index, bias included, (m,) rad."""
        square = self.kept_bias(index) ** 2 + self.sigma(index) ** 2
        for part in self.parts:
            square = square + part.square(index)
        return np.asarray(np.sqrt(square), dtype=np.float64)

    def waveforms(self, index: Index, points: int = LEVEL.points) -> FloatArray:
        """Return the sum of the parts under an index, (points, m) rad, without bias and random part.

        The instants are equidistributed over the phases of all parts and over the index's window.
        """
        total = np.zeros((points, self.bias.size))
        for k, part in enumerate(self.parts):
            total += part.waveform(index, Instants(points, len(self.parts), k))
        return total


def _line_values(orders: tuple[float, ...], fundamental_hz: float, index: Index, at: Instants) -> ComplexArray:
    """Return lines of unit phasor under an index, (p, n)."""
    own = np.array(orders, dtype=np.float64)
    # Many periods of the fundamental pass through all phases of lines between its multiples; one is enough without.
    periods = 1 if np.all(own % 1.0 == 0.0) else LEVEL.periods
    turning = np.exp(2j * np.pi * np.outer(periods * at.phase, own))
    return np.asarray(turning * index.gains(fundamental_hz * own, at.position - 0.5))


_cached_line_values = lru_cache(maxsize=32)(_line_values)
"""Cached for the members of an ensemble, which differ only in phasors; for few instants: an entry takes some MB."""


@lru_cache(maxsize=16)
def phases(count: int, points: int) -> tuple[FloatArray, ...]:
    """Return positions in turns, `count` times (points,): a Kronecker sequence, equidistributed on the torus.

    The first coordinate covers its period evenly. The others advance by the powers of one irrational number, the root
    of x^d = x + 1 with d the number of the others (Roberts' R_d sequence).
    """
    k, others = np.arange(points, dtype=np.float64), max(count - 1, 1)
    root = 2.0
    for _ in range(60):
        # Fixed-point iteration; it contracts by more than half, so that 60 steps reach machine precision.
        root = (1.0 + root) ** (1.0 / (others + 1))
    steps = [1.0 / points, *(root**-d for d in range(1, count))]
    return tuple((0.5 / points + k * step) % 1.0 for step in steps)
