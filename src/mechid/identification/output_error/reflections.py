"""Householder reflections of rows into a triangle, compiled.

`reduction` has this text compiled as a module of the cache of kernels, whose files are known by their digests: Numba by
itself loads machine code that was damaged on disk, and that ends Python.
"""

import math

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


# one signature: another one would change the files in the cache after they have been sealed
@njit("void(float64[:, ::1], float64[:, ::1], int64)", cache=True, nogil=True, fastmath=FAST, error_model="numpy")
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
