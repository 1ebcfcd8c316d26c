"""Samples of a channel of finite resolution, grouped by its visits to each step of the instrument."""

from __future__ import annotations

import numpy as np

from mechid.arrays import FloatArray
from mechid.signal.series import Series
from mechid.signal.stored import pieces_of


class Visits:
    """Sums over the visits to each step of an instrument, of rows that come block by block.

    Parameters
    ----------
    measured : Series of N samples
        A visit lasts while it does not change.
    size : int
        Columns of the rows.
    """

    def __init__(self, measured: Series, size: int) -> None:
        self._begins = np.ones(measured.size, dtype=bool)
        for part in pieces_of(measured):
            first = max(part.start, 1)
            self._begins[first : part.stop] = np.diff(measured[first - 1 : part.stop]) != 0.0
        self._done = 0
        self._open = np.zeros(size)
        self._closed = np.zeros((size, size))

    def add(self, rows: FloatArray) -> None:
        """Add the next rows, (m, n), one at least."""
        begins = np.flatnonzero(self._begins[self._done : self._done + len(rows)])
        self._done += len(rows)
        starts = begins if begins.size and begins[0] == 0 else np.concatenate([[0], begins])
        sums = np.add.reduceat(rows, starts, axis=0)
        if starts.size > begins.size:
            sums[0] += self._open
        else:
            sums = np.vstack([self._open, sums])
        self._open = sums[-1]
        self._closed += sums[:-1].T @ sums[:-1]

    @property
    def total(self) -> FloatArray:
        """Sum over visits of s s^T, (n, n), with s the sum of the rows of a visit."""
        return self._closed + np.outer(self._open, self._open)
