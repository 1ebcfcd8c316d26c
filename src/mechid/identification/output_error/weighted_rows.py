"""The columns of a record's least-squares problem, block by block, weighted as they count."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.output_error.misfit import Misfit, Piece
from mechid.identification.output_error.target import TargetChannel
from mechid.kernel.compiled import aligned
from mechid.signal.trend import waves_at

BETWEEN = 40
"""Unused numbers behind each row, whole cache lines: of rows that are pages apart the processor confuses the places."""


class WeightedRows:
    """Blocks of the columns of [Phi r J] of a misfit's channels as rows, prefiltered, without what does not count.

    Iteration gives (k, rows, n): n samples of channel k in rows[:, :n], which the next block overwrites. Offset and
    drift are filtered too. The first samples of a window, as many as the prefilter remembers, rejected ones and as
    many that follow these are zero: behind each gap the whitening starts anew. Nothing is divided by sigma.
    """

    def __init__(self, misfit: Misfit) -> None:
        self.misfit, self.window = misfit, misfit.window
        self.widths = [c.removed + 1 + misfit.width for c in misfit.target.channels]

    def __iter__(self) -> Iterator[tuple[int, FloatArray, int]]:
        channels = self.misfit.target.channels
        memories = [np.zeros((width, c.order)) for width, c in zip(self.widths, channels, strict=True)]
        apart = self.misfit.run.block + BETWEEN
        buffers = [aligned(width * apart).reshape(width, apart) for width in self.widths]
        for piece in self.misfit:
            n = piece.samples
            for k, (channel, rows) in enumerate(zip(channels, buffers, strict=True)):
                self._write(rows, k, piece)
                if channel.prefilter is not None:
                    rows[:, :n], memories[k] = channel.prefilter.whitened(rows[:, :n], memories[k])
                self._drop(rows, channel, piece.first, n)
                yield k, rows, n

    def _write(self, rows: FloatArray, k: int, piece: Piece) -> None:
        """Write the samples of a piece as rows."""
        n, channel = piece.samples, self.misfit.target.channels[k]
        write_removed(rows, channel, self.window, piece.first, n)
        piece.residual(k, rows[channel.removed, :n])
        if self.misfit.width:
            piece.write_slopes(k, rows[channel.removed + 1 :])

    def _drop(self, rows: FloatArray, channel: TargetChannel, first: int, n: int) -> None:
        """Set to zero what does not count of the samples from `first` on."""
        order = channel.order
        rows[:, : min(max(self.window[0] + order - first, 0), n)] = 0.0
        if channel.rejected.size:
            near = channel.rejected_within((first - order, first + n)) - order
            spoilt = (near[:, np.newaxis] + np.arange(order + 1)).ravel()
            rows[:, spoilt[(spoilt >= 0) & (spoilt < n)]] = 0.0


def write_removed(rows: FloatArray, channel: TargetChannel, window: tuple[int, int], first: int, n: int) -> None:
    """Write what is projected out as rows: offset, drift over the window from -1 to 1, cosine and sine of lines."""
    if channel.linear > 0:
        rows[0, :n] = 1.0
    if channel.linear > 1:
        middle, half = 0.5 * sum(window), max(0.5 * (window[1] - window[0]), 1.0)
        rows[1, :n] = (np.arange(first, first + n) - middle) / half
    for j, pair in enumerate(waves_at(channel.turns, np.arange(first, first + n))):
        row = channel.linear + 2 * j
        rows[row, :n], rows[row + 1, :n] = pair
