"""Streaming reduction of [Phi r J] to its triangle, block by block, by Householder reflections.

After all blocks the rows of Phi (offset, drift: linear, projected out) are dropped. What is left is the
triangle of [r J]: the residual is (||r||, 0, ..., 0) in its basis, the Jacobian the rest. Memory does not
grow with the record, and the condition of J is not squared as by normal equations.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from mechid.arrays import FloatArray

FAST = {"contract", "reassoc", "arcp", "nsz"}


@njit(nogil=True, fastmath=FAST, error_model="numpy")
def product_of_rows(block: FloatArray, k: int, j: int, n: int) -> float:
    """Return the scalar product of two rows."""
    product = 0.0
    for i in range(n):
        product += block[k, i] * block[j, i]
    return product


@njit(nogil=True, fastmath=FAST, error_model="numpy")
def subtract_row(block: FloatArray, k: int, j: int, share: float, other: int, n: int) -> float:
    """Take `share` times row j from row k, and return the product of what is left with another row, in one pass."""
    product = 0.0
    if k == other:
        for i in range(n):
            left = block[k, i] - share * block[j, i]
            block[k, i] = left
            product += left * left
    else:
        for i in range(n):
            left = block[k, i] - share * block[j, i]
            block[k, i] = left
            product += left * block[other, i]
    return product


@njit(cache=True, nogil=True, fastmath=FAST, error_model="numpy")
def absorb(R: FloatArray, block: FloatArray, n: int) -> None:
    """Update the triangle R, (m, m), with n further rows that stand as the columns of `block`, (m, >= n)."""
    m = R.shape[0]
    dots = np.zeros(m)  # products of the row to be reflected next with the others
    for k in range(m):
        dots[k] = product_of_rows(block, k, 0, n)
    for j in range(m):
        alpha, size = R[j, j], dots[j]
        head, factor = 0.0, 0.0
        if size != 0.0:  # or not a number, which is to be seen
            R[j, j] = -math.copysign(math.sqrt(alpha * alpha + size), alpha)
            head = alpha - R[j, j]
            factor = 2.0 / (head * head + size)
        for k in range(j + 1, m):
            share = factor * (head * R[j, k] + dots[k])
            R[j, k] -= share * head
            dots[k] = subtract_row(block, k, j, share, j + 1, n)


@dataclass(frozen=True)
class Triangle:
    """The reduced least-squares problem of one or more records.

    Attributes
    ----------
    norm : float
        ||r|| after projection, in units of sigma.
    jacobian : (1 + n, n)
        In the basis in which the residual is (norm, 0, ..., 0).
    samples : int
    """

    norm: float
    jacobian: FloatArray
    samples: int

    @property
    def cost(self) -> float:
        """Sum of squares, in units of sigma squared."""
        return self.norm**2

    @property
    def fun(self) -> FloatArray:
        """The residual in the triangle's basis, (1 + n,)."""
        out = np.zeros(self.jacobian.shape[0])
        out[0] = self.norm
        return out


def finished(R: FloatArray, linear: int, samples: int) -> Triangle:
    """Drop the first `linear` rows of a triangle of [Phi r J] and fix the sign of the residual's."""
    rest = R[linear:, linear:]
    sign = -1.0 if rest[0, 0] < 0.0 else 1.0
    jacobian = rest[:, 1:].copy()
    jacobian[0] *= sign
    return Triangle(abs(float(rest[0, 0])), jacobian, samples)


def of_rows(r: FloatArray, J: FloatArray) -> Triangle:
    """Reduce residuals, (k,), and their derivatives, (k, n), that are at hand as they are."""
    R = np.zeros((J.shape[1] + 1, J.shape[1] + 1))
    absorb(R, np.ascontiguousarray(np.column_stack([r, J]).T), r.size)
    return finished(R, 0, r.size)


def combined(triangles: list[Triangle]) -> Triangle:
    """Join the triangles of independent records into one."""
    n = triangles[0].jacobian.shape[1]
    stacked = np.vstack([np.column_stack([t.fun, t.jacobian]) for t in triangles])
    R = np.zeros((n + 1, n + 1))
    absorb(R, np.ascontiguousarray(stacked.T), stacked.shape[0])
    return finished(R, 0, sum(t.samples for t in triangles))
