"""Linear fractional representation of an uncertain model, for robust control.

The covariance of the parameters is split into independent directions of one standard deviation each, delta_i. The
split uses singular values of their effects, so that as few directions as possible matter. To first order

    [x'; y] = ([A B; C D] + sum delta_i [dA_i dB_i; dC_i dD_i]) [x; u],

and each term has a low rank, [dA_i dB_i; dC_i dD_i] = L_i R_i by singular values, so that with w_i = delta_i z_i

    z_i = R_i [x; u],   [x'; y] = [A B; C D] [x; u] + sum L_i w_i.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.exports.linear.state_space import LinearModel, Matrices

NEGLIGIBLE = 1e-9
"""Relative singular value of a scaled change below which it is neglected."""
NO_EFFECT = 1e-7
"""Relative effect of a direction below which it is omitted."""


@dataclass(frozen=True, eq=False)
class Fraction:
    """Fixed part, from [w; u] to [z; y], and structure of the uncertainty.

    Attributes
    ----------
    matrices : Matrices
        Inputs: w, then those of the model; outputs: z, then those of the model.
    sizes : (d,) int
        Number of repetitions of each delta in w = blkdiag(delta_i I) z.
    directions : (k, d)
        Change of the uncertain parameters for delta_i = 1, in the units of the mechanism file.
    """

    matrices: Matrices
    sizes: IntArray
    directions: FloatArray

    def at(self, deltas: FloatArray) -> Matrices:
        """Return the model at given values of the deltas, (d,)."""
        r, M = int(self.sizes.sum()), self.matrices
        delta = np.repeat(deltas, self.sizes)[:, None]
        Bw, Dw = M.B[:, :r], M.D[r:, :r]
        return Matrices(
            M.A + Bw @ (delta * M.C[:r]),
            M.B[:, r:] + Bw @ (delta * M.D[:r, r:]),
            M.C[r:] + Dw @ (delta * M.C[:r]),
            M.D[r:, r:] + Dw @ (delta * M.D[:r, r:]),
        )

    def to_dict(self) -> dict[str, Any]:
        """Return matrices, sizes and directions as lists."""
        return {**self.matrices.to_dict(), "sizes": self.sizes.tolist(), "directions": self.directions.tolist()}


def fraction(model: LinearModel) -> Fraction:
    """Convert a model to a linear fraction of independent directions of its covariance, in order of effect.

    Directions without effect are omitted.
    """
    rows, columns = _scales(model)
    size = np.sqrt(np.outer(rows, columns))
    directions = _directions(model, size)
    changes = np.tensordot(directions.T, model.by_uncertain.block_matrix, axes=1)
    found = [_split(change, rows, columns) for change in changes]
    n, whole = len(model.matrices.A), model.matrices.block_matrix
    left = np.hstack([np.zeros((len(whole), 0)), *(one for one, _ in found)])
    right = np.vstack([np.zeros((0, whole.shape[1])), *(other for _, other in found)])
    r, own = left.shape[1], model.matrices
    matrices = Matrices(
        own.A,
        np.hstack([left[:n], own.B]),
        np.vstack([right[:, :n], own.C]),
        np.block([[np.zeros((r, r)), right[:, n:]], [left[n:], own.D]]),
    )
    return Fraction(matrices, np.array([one.shape[1] for one, _ in found], dtype=np.int64), directions)


def _directions(model: LinearModel, size: FloatArray) -> FloatArray:
    """Return independent directions of the covariance with an effect, (k, d), each of one standard deviation.

    The columns of a square root of the covariance, scaled by the standard errors, are rotated until their effects on
    the scaled matrices are orthogonal.
    """
    sigma = model.uncertain.std_errors
    # Parameters without an error would divide by 0.
    safe = np.where(sigma > 0.0, sigma, 1.0)
    spread, axes = np.linalg.eigh(model.uncertain.covariance / np.outer(safe, safe))
    root = safe[:, None] * axes * np.sqrt(np.maximum(spread, 0.0))
    effects = np.tensordot(root.T, model.by_uncertain.block_matrix / size, axes=1).reshape(root.shape[1], size.size)
    turned, effective, _ = np.linalg.svd(effects, full_matrices=False)
    return np.asarray(root @ turned[:, effective > NO_EFFECT * effective.max(initial=0.0)], dtype=np.float64)


def _scales(model: LinearModel) -> tuple[FloatArray, FloatArray]:
    """Return the magnitude of each row and column of [A B; C D], which makes entries of different units comparable."""
    whole = np.abs(model.matrices.block_matrix)
    rows, columns = whole.max(axis=1, initial=0.0), whole.max(axis=0, initial=0.0)
    return np.where(rows > 0.0, rows, 1.0), np.where(columns > 0.0, columns, 1.0)


def _split(change: FloatArray, rows: FloatArray, columns: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Factor a change into L (rows, r) and R (r, columns), by singular values of the scaled change."""
    scaled = change / np.sqrt(np.outer(rows, columns))
    u, s, v = np.linalg.svd(scaled, full_matrices=False)
    # Singular values at the level of rounding would add useless deltas.
    kept = s > NEGLIGIBLE * max(float(s.max(initial=0.0)), NEGLIGIBLE)
    root = np.sqrt(s[kept])
    return u[:, kept] * root * np.sqrt(rows)[:, None], root[:, None] * v[kept] * np.sqrt(columns)
