"""The linear filter behind the plant, over a step in closed form."""

from __future__ import annotations

from mechid.kernel.loop.memory import fill
from mechid.kernel.loop.plant import (
    AT_A,
    AT_B,
    AT_DA,
    AT_DB,
    AT_DZ,
    AT_POWER,
    AT_PRODUCT,
    AT_TABLE,
    AT_Z,
    END_POWER,
    END_TABLE,
    FAST,
    INNER,
    NF,
    NPF,
    NV,
    NX,
    TERMS,
    Numbers,
    njit,
)

WIDTH = NF + 3 * NV
PROP = (1 + NPF) * NF * WIDTH  # size of a propagator with its derivatives


@njit(**INNER)
def multiply(w: Numbers, a: int, b: int, out: int, scale: float, keep: float) -> None:
    """Write out = keep out + scale a b, NF by NF matrices by their places in w."""
    for i in range(NF):
        for j in range(NF):
            total = 0.0
            for n in range(NF):
                total += w[a + i * NF + n] * w[b + n * NF + j]
            w[out + i * NF + j] = keep * w[out + i * NF + j] + scale * total


@njit(**INNER)
def add_term(w: Numbers, power: int, gains: int, begin: float, middle: float, end: float, now: int, later: int) -> None:
    """Add one term of the series to the table: the power itself, and its weighted products with the gains."""
    for i in range(NF):
        for j in range(NF):
            w[now + i * WIDTH + j] += w[power + i * NF + j] if gains == AT_B else 0.0
            for n in range(NV):
                gain = w[power + i * NF + j] * w[gains + j * NV + n]
                w[later + i * WIDTH + NF + n] += begin * gain
                w[later + i * WIDTH + NF + NV + n] += middle * gain
                w[later + i * WIDTH + NF + 2 * NV + n] += end * gain


@njit(**INNER)
def filter_table(w: Numbers, h: float, parameters: int) -> int:
    """Write the propagator of z' = A z + B v as a polynomial in the share of h, row by row from AT_TABLE.

    A propagator is [Phi, Gamma_begin, Gamma_middle, Gamma_end], then its derivatives to the filter's
    `parameters` (their number, or 0 where nobody asks), for v quadratic over the step. A Runge-Kutta step
    knows v half way as (2 v_2 + 2 v_3 + v_4 - v_end)/4 to fourth order; the middle slot takes
    (2 v_2 + 2 v_3 + v_4)/4, the end slot the rest. The rows are the terms of the exponential series and its
    integrals, to 1e-13 at the whole of h. Returns the number of rows.
    """
    square, size = NF * NF, NF * WIDTH
    fill(w, AT_TABLE, END_TABLE, 0.0)
    fill(w, AT_POWER, END_POWER, 0.0)
    for i in range(NF):
        w[AT_POWER + i * NF + i] = 1.0
    for k in range(TERMS):
        a, b, d = 1.0 / (k + 1), 1.0 / ((k + 1) * (k + 2)), 2.0 / ((k + 1) * (k + 2) * (k + 3))
        begin, middle, end = h * (a - 3.0 * b + 2.0 * d), h * 4.0 * (b - d), h * (3.0 * d - 2.0 * b)
        now = AT_TABLE + k * PROP
        add_term(w, AT_POWER, AT_B, begin, middle, end, now, now + PROP)
        for f in range(parameters):
            here = now + (1 + f) * size
            add_term(w, AT_POWER + (1 + f) * square, AT_B, begin, middle, end, here, here + PROP)
            add_term(w, AT_POWER, AT_DB + f * NF * NV, begin, middle, end, here, here + PROP)
        largest = 0.0
        for i in range(AT_POWER, AT_POWER + square):
            largest = max(largest, abs(w[i]))
        if largest < 1e-13:
            return k + 2
        scale = h / (k + 1)
        for f in range(parameters):
            here = AT_PRODUCT + (1 + f) * square
            multiply(w, AT_A, AT_POWER + (1 + f) * square, here, scale, 0.0)
            multiply(w, AT_DA + f * square, AT_POWER, here, scale, 1.0)
        multiply(w, AT_A, AT_POWER, AT_PRODUCT, scale, 0.0)
        for i in range((1 + parameters) * square):
            w[AT_POWER + i] = w[AT_PRODUCT + i]
    return TERMS + 1


@njit(**INNER, fastmath=FAST)
def filter_propagator(w: Numbers, share: float, rows: int, place: int, parameters: int) -> None:
    """Write the propagator over a share of the step that the table was made for, four terms at a time."""
    row, size = AT_TABLE, (1 + parameters) * NF * WIDTH
    square = share * share
    keep, fourfold, a, b, c, d = 0.0, square * square, 1.0, share, square, share * square
    for _ in range(0, rows, 4):
        second, third, fourth = row + PROP, row + 2 * PROP, row + 3 * PROP
        for i in range(size):
            low, high = a * w[row + i] + b * w[second + i], c * w[third + i] + d * w[fourth + i]
            w[place + i] = keep * w[place + i] + (low + high)
        row, keep = fourth + PROP, 1.0
        a, b, c, d = a * fourfold, b * fourfold, c * fourfold, d * fourfold


@njit(**INNER, fastmath=FAST, forceinline=True)
def advance_filter(w: Numbers, prop: int, k_at: int, mid_at: int, new_at: int, parameters: int) -> None:
    """Advance z over one step; dz[f] is what the filter's parameter f changes in it."""
    for f in range(1 + parameters):
        for i in range(NF):
            total, row = 0.0, prop + (f * NF + i) * WIDTH
            for j in range(NF):
                total += w[row + j] * w[AT_Z + j]
            for n in range(NV):
                total += w[row + NF + n] * w[k_at + NX + n]
                total += w[row + NF + NV + n] * w[mid_at + n]
                total += w[row + NF + 2 * NV + n] * w[new_at + NX + n]
            w[AT_DZ - NF + f * NF + i] = total
    for i in range(NF):
        w[AT_Z + i] = w[AT_DZ - NF + i]
