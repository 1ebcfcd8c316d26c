"""Samples beside which the modelled output jumps: what a recorder shows of a jump depends on the recorder."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.identification.output_error.settings import PROBLEM
from mechid.signal.autoregression import Autoregression
from mechid.simulation.noted import Jumps
from mechid.simulation.simulator import BLOCK

NEIGHBOURS = np.array([-2, -1, 1, 2])
"""Samples whose mean, weighted, stands in for what a sample at a jump does not count; a choice, not measured."""


@dataclass(frozen=True)
class JumpSamples:
    """Samples of a piece just before and behind the jumps of one channel.

    Attributes
    ----------
    places : (m,) of int
        Of the piece's samples, ascending, each once.
    counts : (m,)
        What each counts of itself, 0 to 1.
    about : (m, 4) of int
        Those about it.
    shares : (m, 4)
        What each of these counts of the mean that stands in for the rest; they sum to 1.
    """

    places: IntArray
    counts: FloatArray
    about: IntArray
    shares: FloatArray

    def draw(self, rows: FloatArray) -> None:
        """Draw these samples in rows, (..., >= n), towards the mean of those about them."""
        if self.places.size:
            mean = np.sum(rows[..., self.about] * self.shares, axis=-1)
            rows[..., self.places] = self.counts * rows[..., self.places] + (1.0 - self.counts) * mean

    def energy_lost(self, colour: Colour, dropped: IntArray) -> float:
        """Return by how much the expected sum of squares of whitened noise falls, in its variances, by the drawing.

        With r + d instead of the noise r, and e = A r white, E|A (r + d)|^2 - E|e|^2 = 2 E[d' A'A r] + E|A d|^2. A'A is
        the inverse of the covariance of r, so the first expectation is that of d's own sample alone, whatever the
        colour. Of the second the pairs of samples side by side count, as a jump has two; other jumps are further off.
        """
        if not self.places.size:
            return 0.0
        kept = ~np.isin(self.places, dropped)
        drawn = (1.0 - self.counts) * kept
        moved = drawn[:, None] * np.column_stack([self.shares, np.full(drawn.size, -1.0)])
        alone = np.sum((moved @ colour.alone) * moved)
        paired = np.flatnonzero(np.diff(self.places) == 1)
        beside = np.sum((moved[paired] @ colour.beside) * moved[paired + 1])
        return float(2.0 * np.sum(drawn) - alone - 2.0 * beside)


NO_SAMPLES = JumpSamples(*(np.zeros(0, dtype=np.int64), np.zeros(0)) * 2)
"""Those of a piece without a jump."""


@dataclass(frozen=True)
class Colour:
    """What noise of a colour leaves behind its whitening of two drawn samples, as forms in [shares, -1].

    Attributes
    ----------
    alone, beside : (5, 5)
        Of a sample with itself, and with the next one.
    """

    alone: FloatArray
    beside: FloatArray

    @classmethod
    def of(cls, prefilter: Autoregression | None) -> Colour:
        """Return those of a model of noise, of white noise where there is none."""
        places = np.append(NEIGHBOURS, 0)
        apart = np.abs(places[:, None] - places)
        if prefilter is None:
            return cls(np.where(apart == 0, 1.0, 0.0), np.zeros(apart.shape))
        next_apart = np.abs(places[:, None] - places - 1)  # places of one sample seen from those of the next
        covariance = prefilter.covariance(int(next_apart.max()))
        a = np.append(prefilter.coefficients, 0.0)
        return cls((a @ a) * covariance[apart], (a[1:] @ a[:-1]) * covariance[next_apart])


def samples_at(jumps: Jumps, rises: FloatArray, first: int, n: int) -> JumpSamples:
    """Return the samples at jumps of n samples from `first` on; jumps count as samples do, `rises` are in noise levels.

    What a recorder shows of a jump depends on its filter and on shares of the sample interval: the model's mean over
    the interval is one reading of it. A sample u intervals away from a rise R has that uncertainty, (1 - |u|) R, beside
    the noise, and counts by that much less. So the cost is continuous in the jump's instant.

    Nothing reaches over the end of a block with sensitivities, also where a block is longer: runs with and without
    them, alone and side by side, are to leave the same, or a search takes the difference for a step that does not
    descend.
    """
    high = np.abs(rises) > PROBLEM.jump_sigmas
    at, since, rise = jumps.samples[high] - first, jumps.since[high], rises[high]
    both, cell = np.concatenate([at - 1, at]), np.tile((at + first) // BLOCK, 2)
    variance = np.concatenate([since * rise, (1.0 - since) * rise]) ** 2
    kept = (both >= 0) & (both < n) & ((both + first) // BLOCK == cell)
    places = np.unique(both[kept])
    counts = 1.0 / np.sqrt(1.0 + PROBLEM.jump_widening**2 * np.bincount(both[kept], variance[kept], n))
    begin = (places + first) // BLOCK * BLOCK - first
    ends = np.maximum(begin, 0)[:, None], np.minimum(begin + BLOCK, n)[:, None] - 1
    about = np.clip(places[:, None] + NEIGHBOURS, *ends)
    shares = counts[about] ** 2 * (about != places[:, None])
    total = np.sum(shares, axis=-1, keepdims=True)
    counts = np.where(total[:, 0] > 0.0, counts[places], 1.0)  # one that stands alone in its block counts as it is
    return JumpSamples(places, counts, about, shares / np.where(total > 0.0, total, 1.0))
