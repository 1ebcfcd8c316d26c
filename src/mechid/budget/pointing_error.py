"""An error of the line of sight: a bias, periodic parts by source, and a random part; and what an index makes of it."""

from __future__ import annotations

from dataclasses import dataclass

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


@dataclass(frozen=True, eq=False)
class PointingError:
    """The error along m lines of sight; sources are not synchronous with one another.

    Parameters
    ----------
    bias : (m,)
        rad.
    sources : tuple of Source
    frequency_hz : (k,)
        In equal steps; empty where there is no random part.
    density : (k, m)
        One-sided power spectral density of the random part, Gaussian, rad^2/Hz.
    """

    bias: FloatArray
    sources: tuple[Source, ...] = ()
    frequency_hz: FloatArray | None = None
    density: FloatArray | None = None

    def sigma(self, index: Index) -> FloatArray:
        """Return the standard deviation of the random part under an index, (m,) rad."""
        if self.frequency_hz is None or self.density is None:
            return np.zeros_like(self.bias)
        return np.sqrt([index.variance(self.frequency_hz, column) for column in self.density.T])

    def kept_bias(self, index: Index) -> FloatArray:
        """Return the bias under an index, (m,) rad."""
        return self.bias if index.keeps_bias else np.zeros_like(self.bias)

    def rms(self, index: Index) -> FloatArray:
        """Return the root mean square under an index, bias included, (m,) rad, by the index's weights."""
        square = self.kept_bias(index) ** 2 + self.sigma(index) ** 2
        for source in self.sources:
            square = square + index.weight(source.frequency_hz) @ (0.5 * np.abs(source.phasors) ** 2)
        return np.asarray(np.sqrt(square), dtype=np.float64)

    def waveforms(self, index: Index, points: int = POINTS) -> FloatArray:
        """Return what the periodic parts are under an index, (points, m) rad, without bias and random part.

        The instants are equidistributed over all sources' phases and over the index's window.
        """
        *phases, position = _phases(len(self.sources) + 1, points)
        total = np.zeros((points, self.bias.size))
        for source, phase in zip(self.sources, phases, strict=True):
            turning = np.exp(2j * np.pi * np.outer(phase, source.orders))
            total += ((turning * index.gains(source.frequency_hz, position - 0.5)) @ source.phasors).real
        return total


def _phases(count: int, points: int) -> list[FloatArray]:
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
