"""The Fourier transform of a long series, bins in blocks, in little more memory than its bins take.

A library's transform of n samples takes copies, factors and work space, five times the memory of its result. Here it
is taken of every r-th sample, r times, and the bins are put together from these: the first step of Cooley and Tukey,
https://doi.org/10.1090/S0025-5718-1965-0178586-1.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mechid.arrays import ComplexArray, FloatArray, IntArray
from mechid.signal.series import Series, blocks
from mechid.signal.stored import AT_ONCE as TOGETHER
from mechid.signal.stored import is_long, room_for

AT_ONCE = 2**18
"""Samples of one transform, where the number of samples can be divided so."""
MOST_PARTS = 256
COLUMNS, MOST_ROWS = 4096, 32
"""Bins of each part that are put together at once, and up to how many parts they are so many."""


def transformed(series: Series, samples: int, mean: float = 0.0) -> Iterator[tuple[IntArray, ComplexArray]]:
    """Yield the bins of the discrete Fourier transform of the first samples less `mean`, without any scale.

    Parameters
    ----------
    series : Series
    samples : int
        Without large prime factors: with those it takes more time and memory.
    mean : float
        In the samples' unit.

    Yields
    ------
    numbers : (m,) of int
        Of the bins, from 0 to `samples` // 2, each once, in no order.
    bins : (m,)
    """
    parts = _divisor(samples)
    length = samples // parts
    first = _Rows(parts, length // 2 + 1)
    for r, every in enumerate(_every(series, samples, parts)):
        first.write(r, np.fft.rfft(every - mean))
    rows = np.arange(parts)[:, None]
    for columns in blocks(length // 2 + 1, max(COLUMNS * MOST_ROWS // max(parts, MOST_ROWS), 1)):
        k = np.arange(columns.start, columns.stop)
        bins = np.fft.fft(first.columns(columns) * np.exp((-2j * np.pi / samples) * (rows * k)), axis=0)
        number = k + length * rows
        above = 2 * number > samples  # a real series' bin n - k is the conjugate of bin k
        once = ~above | ((k > 0) & (2 * k < length))
        yield np.where(above, samples - number, number)[once], np.where(above, bins.conj(), bins)[once]


class _Rows:
    """Bins of the transforms of all parts: rows that are written one by one, of which columns are read."""

    def __init__(self, rows: int, bins: int) -> None:
        self.rows, self.width = rows, 2 * bins
        self.room = room_for(rows * self.width)

    def write(self, row: int, bins: ComplexArray) -> None:
        """Write a row."""
        self.room[row * self.width : (row + 1) * self.width] = bins.view(np.float64)

    def columns(self, part: slice) -> ComplexArray:
        """Return columns of all rows, (rows, n)."""
        starts = range(0, self.rows * self.width, self.width)
        found = [self.room[start + 2 * part.start : start + 2 * part.stop] for start in starts]
        return np.stack(found).view(np.complex128)


def _every(series: Series, samples: int, parts: int) -> Iterator[FloatArray]:
    """Yield every so manieth of the first samples, from the first on, from the second on, ...; a file is read once."""
    if not is_long(samples):
        yield from (series[r:samples:parts] for r in range(parts))
        return
    length, at_once = samples // parts, max(TOGETHER // parts, 1)
    turned = room_for(samples)
    for part in blocks(length, at_once):
        together = series[part.start * parts : part.stop * parts].reshape(-1, parts)
        for r in range(parts):
            turned[r * length + part.start : r * length + part.stop] = together[:, r]
    yield from (turned[r * length : (r + 1) * length] for r in range(parts))


def _divisor(samples: int) -> int:
    """Return into how many parts the samples are divided; 1 where no number of parts makes them short enough."""
    least = -(-samples // AT_ONCE)
    most = max(MOST_PARTS, 4 * least)
    return next((parts for parts in range(least, most + 1) if samples % parts == 0), 1) if samples else 1
