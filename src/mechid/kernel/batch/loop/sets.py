"""How a set leaves the others, to go alone through what they do not do, and comes back."""

from __future__ import annotations

import numpy as np

from mechid.kernel.batch.loop.memory import ARMED_SETS, EDGES, GOING, IN_MODE, LEFT_AT, NEXT, NEXT_EDGE
from mechid.kernel.batch.loop.plant import SETS, rarely
from mechid.kernel.loop.memory import ARMED, DISCRETE, EDGE, MODE, NEXT_SAMPLE, STALE
from mechid.kernel.loop.plant import (
    AT_CLOSE,
    AT_M,
    AT_TIME,
    AT_U,
    AT_X,
    AT_Z,
    INNER,
    MOST_GUARDS,
    NF,
    NM,
    NPOINT,
    NS,
    NU,
    SIZE,
    Integers,
    Numbers,
    njit,
)

MOVED = np.concatenate(
    (
        np.arange(AT_X, AT_X + NPOINT),
        np.arange(AT_Z, AT_Z + NF),
        np.arange(AT_U, AT_U + NU),
        np.arange(AT_M, AT_M + NM),
        np.array([AT_TIME, AT_CLOSE]),
    )
)
MOVED_COUNT = NPOINT + NF + NU + NM + 2
FAR_OFF = 1e300  # an edge that never comes, s


@njit(**INNER)
def edge_after(edge: int, times: Numbers, edges: int) -> float:
    """Return the instant of an edge, s."""
    return times[edge] if edge < edges else FAR_OFF


@njit(**INNER)
def come(w: Numbers, discrete: Integers, l: int, ones: Numbers, owns: Integers, times: Numbers, edges: int) -> None:
    """Let set l go with the others, from where its own workspace stands."""
    rarely()
    own = l * DISCRETE
    for k in range(MOVED_COUNT):
        w[MOVED[k] * SETS + l] = ones[l * SIZE + MOVED[k]]
    for k in range(NS):
        w[(IN_MODE + k) * SETS + l] = owns[own + MODE + k]
    for k in range(NS * MOST_GUARDS):
        w[(ARMED_SETS + k) * SETS + l] = owns[own + ARMED + k]
    discrete[EDGES + l] = owns[own + EDGE]
    w[NEXT_EDGE * SETS + l] = edge_after(owns[own + EDGE], times, edges)
    w[GOING * SETS + l] = 1.0


@njit(**INNER)
def leave(w: Numbers, discrete: Integers, l: int, row: int, ones: Numbers, owns: Integers) -> None:
    """Let set l go alone from where it stands, before the step at hand, in the sample that comes next."""
    rarely()
    own = l * DISCRETE
    for k in range(MOVED_COUNT):
        ones[l * SIZE + MOVED[k]] = w[MOVED[k] * SETS + l]
    for k in range(NS * MOST_GUARDS):
        owns[own + ARMED + k] = 1 if w[(ARMED_SETS + k) * SETS + l] > 0.0 else 0
    owns[own + EDGE], owns[own + STALE], owns[own + NEXT_SAMPLE] = discrete[EDGES + l], 1, discrete[NEXT]
    w[GOING * SETS + l] = 0.0
    discrete[LEFT_AT + l] = row
