"""Bands from the covariance of the parameters, with the share of each parameter in the variance."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri
from scipy.stats import qmc

from mechid.arrays import FloatArray
from mechid.budgets.settings import LEVEL

TWO_SIDED_95 = 1.959964
CURVATURE = "curvature"
"""Share of a sampled variance that is not linear in the parameters."""


@dataclass(frozen=True)
class Band:
    """Value with its standard error, and each parameter's share of the variance.

    The shares are g_i (C g)_i / (g' C g), g the gradient and C the covariance: they add to 1. With correlated
    parameters a share may be negative: it offsets others.
    """

    value: float
    sigma: float
    shares: Mapping[str, float]

    @property
    def ci95(self) -> tuple[float, float]:
        """95 % interval."""
        return self.value - TWO_SIDED_95 * self.sigma, self.value + TWO_SIDED_95 * self.sigma


def deviations(covariance: FloatArray, count: int, rng: np.random.Generator) -> FloatArray:
    """Return draws (count, n) of deviations from a covariance (n, n), which may be singular."""
    sizes, axes = np.linalg.eigh(covariance)
    root = axes * np.sqrt(np.maximum(sizes, 0.0))
    return np.asarray(rng.normal(size=(count, len(sizes))) @ root.T, dtype=np.float64)


def band_from_draws(
    value: float, function: Callable[[FloatArray], float], covariance: FloatArray, names: Sequence[str]
) -> Band:
    """Return the band of a function with kinks, such as a quantile, where a gradient at one point is not sufficient.

    The parameters' deviations are drawn from their covariance by a scrambled Sobol sequence. The
    gradient of the shares comes from a linear regression through the draws; the remaining variance is `CURVATURE`.

    Parameters
    ----------
    value : float
    function : callable
        Value as a function of the parameters' deviations, (n,).
    covariance : (n, n)
    names : sequence of str, (n,)
    """
    sizes, axes = np.linalg.eigh(covariance)
    # A singular covariance has directions without variance, which need no coordinate of the sequence.
    keep = sizes > 1e-12 * sizes.max(initial=0.0)
    if not keep.any():
        return Band(value, 0.0, dict.fromkeys(names, 0.0))
    root = axes[:, keep] * np.sqrt(sizes[keep])
    white = ndtri(qmc.Sobol(root.shape[1], seed=0).random(LEVEL.share_draws))
    results = np.array([function(root @ row) for row in white])
    columns = np.column_stack([white, np.ones(LEVEL.share_draws)])
    fitted = np.linalg.lstsq(columns, results, rcond=None)[0]
    line, rest = fitted[:-1], float(np.var(results - columns @ fitted))
    variance = float(line @ line) + rest
    if variance <= 0.0:
        return Band(value, 0.0, dict.fromkeys(names, 0.0))
    gradient = axes[:, keep] @ (line / np.sqrt(sizes[keep]))
    shares = gradient * (root @ line) / variance
    return Band(
        value, float(np.sqrt(variance)), {**dict(zip(names, shares.tolist(), strict=True)), CURVATURE: rest / variance}
    )
