"""Samples next to jumps of the modelled output, where the recorder determines the measured value."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.identification.output_error.settings import PROBLEM
from mechid.signal.autoregression import Autoregression
from mechid.simulation.simulator import BLOCK
from mechid.simulation.switch_log import Jumps

NEIGHBOURS = np.array([-2, -1, 1, 2])
"""Offsets of the samples whose weighted mean replaces part of a sample at a jump; a choice, not measured."""


@dataclass(frozen=True)
class JumpSamples:
    """Samples of a piece just before and after the jumps of one channel.

    Attributes
    ----------
    places : (m,) of int
        Indices in the piece, ascending and unique.
    counts : (m,)
        Weight of each sample's own value, 0 to 1.
    about : (m, 4) of int
        Indices of its neighbours.
    shares : (m, 4)
        Weights of the neighbours in the mean that replaces the rest; they sum to 1.
    """

    places: IntArray
    counts: FloatArray
    about: IntArray
    shares: FloatArray

    def draw(self, rows: FloatArray) -> None:
        """Pull these samples in rows, (..., >= n), towards the mean of their neighbours."""
        if self.places.size:
            mean = np.sum(rows[..., self.about] * self.shares, axis=-1)
            rows[..., self.places] = self.counts * rows[..., self.places] + (1.0 - self.counts) * mean

    def energy_lost(self, colour: Colour, dropped: IntArray) -> float:
        """Return the fall of the expected sum of squares of whitened noise caused by `draw`, in its variances.

        With r + d instead of the noise r, and e = A r white, E|A (r + d)|^2 - E|e|^2 = 2 E[d' A'A r] + E|A d|^2. A'A is
        the inverse of the covariance of r, so the first expectation is that of d's own sample alone, for any colour. In
        the second, only pairs of adjacent samples count, as a jump has two; other jumps are further away.
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
"""Samples of a piece without a jump."""


@dataclass(frozen=True)
class Colour:
    """Quadratic forms in [shares, -1] of two drawn samples, for coloured noise after whitening.

    Attributes
    ----------
    alone, beside : (5, 5)
        Form of a sample with itself, and with the next one.
    """

    alone: FloatArray
    beside: FloatArray

    @classmethod
    def of(cls, prefilter: Autoregression | None) -> Colour:
        """Return the forms of a noise model, or of white noise without one."""
        places = np.append(NEIGHBOURS, 0)
        apart = np.abs(places[:, None] - places)
        if prefilter is None:
            return cls(np.where(apart == 0, 1.0, 0.0), np.zeros(apart.shape))
        next_apart = np.abs(places[:, None] - places - 1)  # places of one sample seen from those of the next
        covariance = prefilter.covariance(int(next_apart.max()))
        a = np.append(prefilter.coefficients, 0.0)
        return cls((a @ a) * covariance[apart], (a[1:] @ a[:-1]) * covariance[next_apart])


def samples_at(jumps: Jumps, rises: FloatArray, first: int, n: int) -> JumpSamples:
    """Return the samples at jumps among n samples from `first` on; `rises` are in noise levels.

    The recorded value at a jump depends on the recorder's filter and on fractions of the sample interval; the model's
    mean over the interval is only one possible value. A sample u intervals away from a rise R has the uncertainty (1 -
    |u|) R in addition to the noise, and its weight is reduced accordingly. The cost is therefore continuous in the
    instant of the jump.

    No sample uses neighbours beyond the end of a block with sensitivities, even if a block is longer. Runs with and
    without sensitivities, single or batched, must give equal residuals; otherwise the search takes their difference for
    a step that does not descend.
    """
    high = np.abs(rises) > PROBLEM.jump_sigmas
    at, since, rise = jumps.samples[high] - first, jumps.since[high], rises[high]
    both, cell = np.concatenate([at - 1, at]), np.tile((at + first) // BLOCK, 2)
    variance = np.concatenate([since * rise, (1.0 - since) * rise]) ** 2
    kept = (both >= 0) & (both < n) & ((both + first) // BLOCK == cell)
    places = np.unique(both[kept])
    # Independent variances of the noise and of the jump add; the weight is the inverse of their root.
    counts = 1.0 / np.sqrt(1.0 + PROBLEM.jump_widening**2 * np.bincount(both[kept], variance[kept], n))
    begin = (places + first) // BLOCK * BLOCK - first
    ends = np.maximum(begin, 0)[:, None], np.minimum(begin + BLOCK, n)[:, None] - 1
    about = np.clip(places[:, None] + NEIGHBOURS, *ends)
    shares = counts[about] ** 2 * (about != places[:, None])
    total = np.sum(shares, axis=-1, keepdims=True)
    counts = np.where(
        total[:, 0] > 0.0, counts[places], 1.0
    )  # a sample without neighbours in its block is left unchanged
    return JumpSamples(places, counts, about, shares / np.where(total > 0.0, total, 1.0))
