"""The linear filter behind the plant over a step, for all sets."""

from __future__ import annotations

from mechid.kernel.batch.loop.memory import AWAY, FOURFOLD, LENGTH, SHARE, STEP
from mechid.kernel.batch.loop.plant import SETS, apart, in_vectors
from mechid.kernel.loop.filter import PROP, WIDTH
from mechid.kernel.loop.memory import SAME
from mechid.kernel.loop.plant import (
    AT_OTHER,
    AT_REGULAR,
    AT_TABLE,
    FAST,
    INNER,
    NF,
    Numbers,
    njit,
)

MOSTLY = 16  # rows of the table that mostly suffice


@njit(**INNER, fastmath=FAST)
def use_whole_steps(w: Numbers) -> None:
    """Let the propagators be those of whole steps."""
    in_vectors()
    apart()
    for l in range(SETS):
        for i in range(NF * WIDTH):
            w[(AT_OTHER + i) * SETS + l] = w[(AT_REGULAR + i) * SETS + l]


@njit(**INNER, fastmath=FAST)
def use_propagators(w: Numbers, rows: int) -> None:
    """Work out the propagator of every set over its step from the table: a polynomial in the share of a whole step."""
    in_vectors()
    apart()
    for i in range(NF * WIDTH * SETS):
        w[AT_OTHER * SETS + i] = 0.0
    for row in range(rows - 1, MOSTLY - 1, -1):  # of a filter that is fast beside the step
        for i in range(NF * WIDTH):
            for l in range(SETS):
                at = (AT_OTHER + i) * SETS + l
                share = w[LENGTH * SETS + l] / w[STEP * SETS + l]
                w[at] = share * w[at] + w[(AT_TABLE + row * PROP + i) * SETS + l]
    for l in range(SETS):
        share = w[LENGTH * SETS + l] / w[STEP * SETS + l]
        w[SHARE * SETS + l] = share
        w[FOURFOLD * SETS + l] = (share * share) * (share * share)
        w[AWAY * SETS + l] = 1.0 if abs(share - 1.0) > SAME else 0.0
    for i in range(NF * WIDTH):
        for l in range(SETS):
            share, fourfold = w[SHARE * SETS + l], w[FOURFOLD * SETS + l]
            square = share * share
            total = w[(AT_OTHER + i) * SETS + l]
            for row in range(MOSTLY - 4, -4, -4):
                first, second = (
                    w[(AT_TABLE + row * PROP + i) * SETS + l],
                    w[(AT_TABLE + row * PROP + PROP + i) * SETS + l],
                )
                third = w[(AT_TABLE + row * PROP + 2 * PROP + i) * SETS + l]
                fourth = w[(AT_TABLE + row * PROP + 3 * PROP + i) * SETS + l]
                total = fourfold * total + ((first + share * second) + square * (third + share * fourth))
            usual, away = w[(AT_REGULAR + i) * SETS + l], w[AWAY * SETS + l] > 0.0
            w[(AT_OTHER + i) * SETS + l] = total if away else usual  # over a whole step that of all whole steps
