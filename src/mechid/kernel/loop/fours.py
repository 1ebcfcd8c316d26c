"""Four numbers at a time."""

from __future__ import annotations

from mechid.kernel.loop.plant import INNER, Numbers, njit


@njit(**INNER)
def put_four(w: Numbers, at: int, a: float, b: float, c: float, d: float, one: float) -> None:
    """Write four numbers side by side, each times `one`, which is 1."""
    w[at] = one * a
    w[at + 1] = one * b
    w[at + 2] = one * c
    w[at + 3] = one * d


@njit(**INNER)
def copy_four(target: Numbers, to: int, source: Numbers, at: int) -> None:
    """Copy four numbers from `at` of one array to `to` of another."""
    for i in range(4):
        target[to + i] = source[at + i]


@njit(**INNER)
def put_turned(w: Numbers, to: int, a: int, b: int, c: int, d: int, scale: int, add: int) -> None:
    """Write four adjacent rows from `to` on, whose columns stand at a to d, times the row at `scale`.

    With `add`, which is not zero, they are added to what stands there.
    """
    for i in range(4):
        row = to + 4 * i
        if add == 0:
            for l in range(4):
                w[row + l] = 0.0
        w[row] += w[a + i] * w[scale]
        w[row + 1] += w[b + i] * w[scale + 1]
        w[row + 2] += w[c + i] * w[scale + 2]
        w[row + 3] += w[d + i] * w[scale + 3]
