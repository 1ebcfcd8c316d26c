"""The columns of a record's least-squares problem, block by block, weighted as they count."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.identification.output_error.jump_samples import Colour
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

    Attributes
    ----------
    energy_lost : list of float
        By how much the sum of squares of each channel's noise has fallen so far at jumps, in its variances.
    """

    def __init__(self, misfit: Misfit) -> None:
        self.misfit, self.window = misfit, misfit.window
        self.widths = [c.removed + 1 + misfit.width for c in misfit.target.channels]
        self.energy_lost = [0.0] * len(self.widths)

    def __iter__(self) -> Iterator[tuple[int, FloatArray, int]]:
        channels = self.misfit.target.channels
        colours = [Colour.of(c.prefilter) for c in channels]
        memories = [np.zeros((width, c.order)) for width, c in zip(self.widths, channels, strict=True)]
        apart = self.misfit.run.block + BETWEEN
        buffers = [aligned(width * apart).reshape(width, apart) for width in self.widths]
        for piece in self.misfit:
            n = piece.samples
            for k, (channel, rows) in enumerate(zip(channels, buffers, strict=True)):
                self._write(rows, k, piece)
                if channel.prefilter is not None:
                    rows[:, :n], memories[k] = channel.prefilter.whitened(rows[:, :n], memories[k])
                dropped = self._dropped(channel, piece.first, n)
                rows[:, dropped] = 0.0
                self.energy_lost[k] += piece.at_jumps(k).energy_lost(colours[k], dropped)
                yield k, rows, n

    def _write(self, rows: FloatArray, k: int, piece: Piece) -> None:
        """Write the samples of a piece as rows."""
        n, channel = piece.samples, self.misfit.target.channels[k]
        write_removed(rows, channel, self.window, piece.first, n)
        piece.residual(k, rows[channel.removed, :n])
        if self.misfit.width:
            piece.write_slopes(k, rows[channel.removed + 1 :])

    def _dropped(self, channel: TargetChannel, first: int, n: int) -> IntArray:
        """Return those that do not count of n samples from `first` on."""
        order = channel.order
        beginning = np.arange(min(max(self.window[0] + order - first, 0), n))
        if not channel.rejected.size:
            return beginning
        near = channel.rejected_within((first - order, first + n)) - order
        spoilt = (near[:, np.newaxis] + np.arange(order + 1)).ravel()
        return np.concatenate([beginning, spoilt[(spoilt >= 0) & (spoilt < n)]])


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
