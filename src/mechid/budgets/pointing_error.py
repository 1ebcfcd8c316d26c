"""An error of the line of sight: a bias, periodic parts by source, and a random part; and what an index makes of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np

from mechid.arrays import ComplexArray, FloatArray, IntArray
from mechid.budgets.indices import Index
from mechid.budgets.settings import LEVEL


@dataclass(frozen=True)
class Instants:
    """Where one of several parts is looked at, (p,): all are equidistributed over the parts' phases and the window.

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
        """Of the part, in turns, (p,)."""
        return phases(self.parts + 1, self.points)[self.part]

    @property
    def position(self) -> FloatArray:
        """In the index's window, 0 to 1, (p,); the same of all parts."""
        return phases(self.parts + 1, self.points)[-1]


@dataclass(frozen=True, eq=False)
class Source:
    """A periodic error: lines at whole multiples of one frequency, added coherently.

    Parameters
    ----------
    name : str
    fundamental_hz : float
    orders : (n,) int
        Of each line, from 1.
    phasors : (n, m) complex
        Peak amplitude and phase along each of m lines of sight, rad: the error is Re(phasor e^(2 pi i f t)).
    """

    name: str
    fundamental_hz: float
    orders: IntArray
    phasors: ComplexArray

    @property
    def frequency_hz(self) -> FloatArray:
        """Of each line, (n,)."""
        return np.asarray(self.orders * self.fundamental_hz, dtype=np.float64)

    def waveform(self, index: Index, at: Instants) -> FloatArray:
        """Return what it is under an index, (p, m) rad."""
        turned = _turned if at.points > LEVEL.quick_points else _kept_turned
        lines = turned(tuple(self.orders.tolist()), self.fundamental_hz, index, at)
        return np.asarray((lines @ self.phasors).real, dtype=np.float64)

    def square(self, index: Index) -> FloatArray:
        """Return its mean square under an index, (m,) rad^2, by the index's weights."""
        return np.asarray(index.weight(self.frequency_hz) @ (0.5 * np.abs(self.phasors) ** 2), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Sampled:
    """A part that is known at instants: its values under one index, which is that of every call.

    Parameters
    ----------
    values : (n, m)
        rad; equidistributed over the time, in no order.
    """

    values: FloatArray

    def waveform(self, index: Index, at: Instants) -> FloatArray:
        """Return the values, (p, m) rad, at places in the list that are the phases of the instants."""
        del index
        return np.asarray(self.values[(at.phase * len(self.values)).astype(np.int64)], dtype=np.float64)

    def square(self, index: Index) -> FloatArray:
        """Return the mean square, (m,) rad^2."""
        del index
        return np.asarray(np.mean(self.values**2, axis=0), dtype=np.float64)


class Part(Protocol):
    """What an error consists of beside bias and noise: something whose value is known up to one phase."""

    def waveform(self, index: Index, at: Instants) -> FloatArray:
        """Return what it is under an index, (p, m) rad."""

    def square(self, index: Index) -> FloatArray:
        """Return its mean square under an index, (m,) rad^2."""


@dataclass(frozen=True, eq=False)
class Random:
    """A Gaussian part: its one-sided power spectral density.

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
        """Return its variance under an index, (m,) rad^2."""
        return _variance(self, index)


@lru_cache(maxsize=16)
def _variance(random: Random, index: Index) -> FloatArray:
    """Return a variance that all members of an ensemble have in common."""
    step = float(random.frequency_hz[1] - random.frequency_hz[0])
    return np.asarray(index.weight(random.frequency_hz) @ random.density * step, dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Incoherent:
    """Lines whose phases are not known, many enough that together they are taken as Gaussian.

    Parameters
    ----------
    frequency_hz : (k,)
    power : (k, m)
        Mean square of each along each line of sight, rad^2.
    """

    frequency_hz: FloatArray
    power: FloatArray

    def variance(self, index: Index) -> FloatArray:
        """Return their variance under an index, (m,) rad^2."""
        return np.asarray(index.weight(self.frequency_hz) @ self.power, dtype=np.float64)


@dataclass(frozen=True, eq=False)
class FlatRandom:
    """A Gaussian part with a density that is flat up to a frequency.

    Parameters
    ----------
    bandwidth_hz : float
    sigma : (m,)
        Standard deviation over time, rad.
    """

    bandwidth_hz: float
    sigma: FloatArray

    def variance(self, index: Index) -> FloatArray:
        """Return its variance under an index, (m,) rad^2."""
        return flat_share(index, self.bandwidth_hz) * self.sigma**2


@lru_cache(maxsize=64)
def flat_share(index: Index, bandwidth_hz: float) -> float:
    """Return the share of the variance of noise, flat up to a frequency, that an index keeps."""
    points = max(LEVEL.least_points, int(LEVEL.points_a_lobe * bandwidth_hz * index.longest_s))
    return float(np.mean(index.weight(np.linspace(0.0, bandwidth_hz, points))))


@dataclass(frozen=True, eq=False)
class PointingError:
    """The error along m lines of sight; its parts are not synchronous with one another.

    Parameters
    ----------
    bias : (m,)
        rad.
    parts : tuple of Part
        `Source` for lines, `Sampled` for a course over time.
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
        """Return what the parts are together under an index, (points, m) rad, without bias and random part.

        The instants are equidistributed over all parts' phases and over the index's window.
        """
        total = np.zeros((points, self.bias.size))
        for k, part in enumerate(self.parts):
            total += part.waveform(index, Instants(points, len(self.parts), k))
        return total


def _turned(orders: tuple[int, ...], fundamental_hz: float, index: Index, at: Instants) -> ComplexArray:
    """Return lines of unit phasor under an index, (p, n)."""
    turning = np.exp(2j * np.pi * np.outer(at.phase, orders))
    return np.asarray(turning * index.gains(fundamental_hz * np.array(orders, dtype=np.float64), at.position - 0.5))


_kept_turned = lru_cache(maxsize=32)(_turned)
"""The members of an ensemble differ in their phasors alone. Some MB each, and only where the instants are few."""


@lru_cache(maxsize=16)
def phases(count: int, points: int) -> tuple[FloatArray, ...]:
    """Return positions in turns, `count` times (points,): a Kronecker sequence, equidistributed on their torus.

    The first walks evenly through its period, the others in steps of the powers of one irrational number, the
    root of x^d = x + 1 with d the number of the others (Roberts' R_d sequence).
    """
    k, others = np.arange(points, dtype=np.float64), max(count - 1, 1)
    root = 2.0
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (others + 1))
    steps = [1.0 / points, *(root**-d for d in range(1, count))]
    return tuple((0.5 / points + k * step) % 1.0 for step in steps)
