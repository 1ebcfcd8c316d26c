"""An error of the line of sight: a bias, periodic parts by source, and a random part; and what an index makes of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mechid.budget.indices import Index

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

POINTS = 8192
"""Instants at which the sum of the sources is looked at; a level is good to some 1e-4 with one source."""


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
    orders: NDArray[np.int64]
    phasors: ComplexArray

    @property
    def frequency_hz(self) -> FloatArray:
        """Of each line, (n,)."""
        return np.asarray(self.orders * self.fundamental_hz, dtype=np.float64)

    def waveform(self, index: Index, phase: FloatArray, position: FloatArray) -> FloatArray:
        """Return what it is under an index, (p, m) rad, at phases (p,) of its fundamental, in turns."""
        turning = np.exp(2j * np.pi * np.outer(phase, self.orders))
        gains = index.gains(self.frequency_hz, position - 0.5)
        return np.asarray(((turning * gains) @ self.phasors).real, dtype=np.float64)

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

    def waveform(self, index: Index, phase: FloatArray, position: FloatArray) -> FloatArray:
        """Return the values, (p, m) rad, at places (p,) from 0 to 1 in the list."""
        del index, position
        return np.asarray(self.values[(phase * len(self.values)).astype(np.int64)], dtype=np.float64)

    def square(self, index: Index) -> FloatArray:
        """Return the mean square, (m,) rad^2."""
        del index
        return np.asarray(np.mean(self.values**2, axis=0), dtype=np.float64)


class Part(Protocol):
    """What an error consists of beside bias and noise: something whose value is known up to one phase."""

    def waveform(self, index: Index, phase: FloatArray, position: FloatArray) -> FloatArray:
        """Return what it is under an index, (p, m) rad; phase and position in the window (p,), 0 to 1."""

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
        return np.array([index.variance(self.frequency_hz, column) for column in self.density.T])


@dataclass(frozen=True, eq=False)
class PointingError:
    """The error along m lines of sight; its parts are not synchronous with one another.

    Parameters
    ----------
    bias : (m,)
        rad.
    parts : tuple of Part
        `Source` for lines, `Sampled` for a course over time.
    randoms : tuple of Random
    """

    bias: FloatArray
    parts: tuple[Part, ...] = ()
    randoms: tuple[Random, ...] = ()

    def sigma(self, index: Index) -> FloatArray:
        """Return the standard deviation of the random parts under an index, (m,) rad."""
        total = np.zeros_like(self.bias)
        for random in self.randoms:
            total = total + random.variance(index)
        return np.asarray(np.sqrt(total), dtype=np.float64)

    def kept_bias(self, index: Index) -> FloatArray:
        """Return the bias under an index, (m,) rad."""
        return self.bias if index.keeps_bias else np.zeros_like(self.bias)

    def rms(self, index: Index) -> FloatArray:
        """Return the root mean square under an index, bias included, (m,) rad."""
        square = self.kept_bias(index) ** 2 + self.sigma(index) ** 2
        for part in self.parts:
            square = square + part.square(index)
        return np.asarray(np.sqrt(square), dtype=np.float64)

    def waveforms(self, index: Index, points: int = POINTS) -> FloatArray:
        """Return what the parts are together under an index, (points, m) rad, without bias and random part.

        The instants are equidistributed over all parts' phases and over the index's window.
        """
        *own, position = phases(len(self.parts) + 1, points)
        total = np.zeros((points, self.bias.size))
        for part, phase in zip(self.parts, own, strict=True):
            total += part.waveform(index, phase, position)
        return total


def phases(count: int, points: int) -> list[FloatArray]:
    """Return positions in turns, `count` times (points,): a Kronecker sequence, equidistributed on their torus.

    The first walks evenly through its period, the others in steps of the powers of one irrational number, the
    root of x^d = x + 1 with d the number of the others (Roberts' R_d sequence).
    """
    k, others = np.arange(points, dtype=np.float64), max(count - 1, 1)
    root = 2.0
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (others + 1))
    steps = [1.0 / points, *(root**-d for d in range(1, count))]
    return [(0.5 / points + k * step) % 1.0 for step in steps]
