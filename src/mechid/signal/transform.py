"""Fourier transform of a long series, block by block, in little more memory than its result.

A library's transform needs copies, factors and work space of five times the memory of its result. Here the samples are
divided into interleaved parts, which are transformed one by one and combined: the first step of the algorithm of Cooley
and Tukey, https://doi.org/10.1090/S0025-5718-1965-0178586-1.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mechid.arrays import ComplexArray, FloatArray, IntArray
from mechid.signal.series import Series, blocks
from mechid.signal.stored_series import AT_ONCE, allocate_series, is_long

PART_SAMPLES = 2**18
"""Maximum number of samples of a part's transform, if the number of samples can be divided accordingly."""
MAX_PARTS = 256
COLUMNS, MOST_ROWS = 4096, 32
"""Number of bins of each part that are combined at once, for up to `MOST_ROWS` parts; fewer for more parts."""


def transform_blocks(series: Series, samples: int, mean: float = 0.0) -> Iterator[tuple[IntArray, ComplexArray]]:
    """Yield the unscaled bins of the discrete Fourier transform of the first samples minus `mean`.

    Parameters
    ----------
    series : Series
    samples : int
        Number of samples; large prime factors cost time and memory.
    mean : float
        In the samples' unit.

    Yields
    ------
    numbers : (m,) of int
        Indices of the bins, from 0 to `samples` // 2, each once, in no particular order.
    bins : (m,)
    """
    parts = _divisor(samples)
    length = samples // parts
    first = _PartSpectra(parts, length // 2 + 1)
    for r, every in enumerate(_polyphase_parts(series, samples, parts)):
        first.write(r, np.fft.rfft(every - mean))
    rows = np.arange(parts)[:, None]
    for columns in blocks(length // 2 + 1, max(COLUMNS * MOST_ROWS // max(parts, MOST_ROWS), 1)):
        k = np.arange(columns.start, columns.stop)
        bins = np.fft.fft(first.columns(columns) * np.exp((-2j * np.pi / samples) * (rows * k)), axis=0)
        number = k + length * rows
        # For a real series bin n - k is the conjugate of bin k: bins above the Nyquist frequency are mirrored, or
        # dropped in the columns that contain their own mirror images.
        above = 2 * number > samples
        once = ~above | ((k > 0) & (2 * k < length))
        yield np.where(above, samples - number, number)[once], np.where(above, bins.conj(), bins)[once]


class _PartSpectra:
    """Transforms of all parts, written row by row and read by blocks of columns."""

    def __init__(self, rows: int, bins: int) -> None:
        self.rows, self.width = rows, 2 * bins
        self.room = allocate_series(rows * self.width)

    def write(self, row: int, bins: ComplexArray) -> None:
        """Write a row."""
        self.room[row * self.width : (row + 1) * self.width] = bins.view(np.float64)

    def columns(self, part: slice) -> ComplexArray:
        """Return a block of columns of all rows, (rows, n)."""
        starts = range(0, self.rows * self.width, self.width)
        found = [self.room[start + 2 * part.start : start + 2 * part.stop] for start in starts]
        return np.stack(found).view(np.complex128)


def _polyphase_parts(series: Series, samples: int, parts: int) -> Iterator[FloatArray]:
    """Yield the interleaved parts of the first samples, each with every `parts`-th sample."""
    if not is_long(samples):
        yield from (series[r:samples:parts] for r in range(parts))
        return
    # A series in a file is transposed into another file in one pass: strided access would read it once per part.
    length, at_once = samples // parts, max(AT_ONCE // parts, 1)
    turned = allocate_series(samples)
    for part in blocks(length, at_once):
        together = series[part.start * parts : part.stop * parts].reshape(-1, parts)
        for r in range(parts):
            turned[r * length + part.start : r * length + part.stop] = together[:, r]
    yield from (turned[r * length : (r + 1) * length] for r in range(parts))


def _divisor(samples: int) -> int:
    """Return the number of parts into which the samples are divided; 1 if no divisor makes the parts short enough."""
    least = -(-samples // PART_SAMPLES)
    most = max(MAX_PARTS, 4 * least)
    return next((parts for parts in range(least, most + 1) if samples % parts == 0), 1) if samples else 1
