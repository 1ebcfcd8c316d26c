"""Until when each set of a batch goes next: its next edge, the end of its short steps, or its sample."""

from __future__ import annotations

import numpy as np

from mechid.kernel.batch.loop.memory import (
    COUNT,
    COUNTED,
    EDGES,
    END,
    GOING,
    INTERVAL,
    NEXT_EDGE,
    ON_EDGE,
    SAMPLE,
    SHORT,
    STALE_SETS,
    STEP,
    STEP_CLOSE,
    WHOLE,
)
from mechid.kernel.batch.loop.plant import SETS, apart, in_vectors, rarely
from mechid.kernel.batch.loop.sets import edge_after
from mechid.kernel.batch.loop.suspects import any_marked
from mechid.kernel.loop.memory import SAME
from mechid.kernel.loop.plant import AT_CLOSE, AT_TIME, AT_U, FAST, INNER, NU, Integers, Numbers, njit


@njit(**INNER, fastmath=FAST)
def plan(w: Numbers) -> tuple[int, bool, bool]:
    """Set until when each set goes next, and in how many steps; return the most steps, and whether any meets an edge.

    The last is whether any is not at its sample then. The rules are those of a kernel's own loop.
    """
    in_vectors()
    apart()
    for l in range(SETS):
        t, end, interval = w[AT_TIME * SETS + l], w[SAMPLE * SETS + l], w[INTERVAL * SETS + l]
        next_edge, close = w[NEXT_EDGE * SETS + l], w[AT_CLOSE * SETS + l]
        long, short = w[STEP * SETS + l], w[STEP_CLOSE * SETS + l]
        on_edge = next_edge < end - 1e-9 * interval
        stop = next_edge if on_edge else end
        near = t < close - SAME * interval
        reach = short if near else long
        cut = near & (close < stop - SAME * interval)
        stop = close if cut else stop
        whole = stop - t
        count = -np.floor(1e-9 - whole / reach)
        count = count if whole > 1.000000001 * reach else 1.0
        count = count if whole >= 1e-9 * reach else 0.0
        going = w[GOING * SETS + l] > 0.0
        count = count if going else 0.0
        w[END * SETS + l], w[COUNT * SETS + l] = stop, count
        w[WHOLE * SETS + l] = whole / max(count, 1.0)
        w[ON_EDGE * SETS + l] = 1.0 if on_edge & going & (not cut) else 0.0
        w[SHORT * SETS + l] = 1.0 if going & (stop < end) else 0.0
    most = 0.0
    for l in range(SETS):
        most = max(most, w[COUNT * SETS + l])
    return int(most), any_marked(w, ON_EDGE), any_marked(w, SHORT)


@njit(**INNER)
def meet_edges(w: Numbers, discrete: Integers, times: Numbers, values: Numbers, edges: int) -> None:
    """Give the sets that stand at an edge the inputs from there on."""
    rarely()
    for l in range(discrete[COUNTED]):
        if w[ON_EDGE * SETS + l] > 0.0 and w[GOING * SETS + l] > 0.0:
            edge = discrete[EDGES + l]
            for i in range(NU):
                w[(AT_U + i) * SETS + l] = values[edge * NU + i]
            discrete[EDGES + l] = edge + 1
            w[NEXT_EDGE * SETS + l] = edge_after(edge + 1, times, edges)
            discrete[STALE_SETS] = 1


@njit(**INNER)
def quiet_samples(w: Numbers, discrete: Integers) -> int:
    """Return so many samples in which no set meets an edge or is close behind a break-away."""
    rarely()
    least = 1e6
    for l in range(discrete[COUNTED]):
        if w[GOING * SETS + l] > 0.0:
            t, interval = w[AT_TIME * SETS + l], w[INTERVAL * SETS + l]
            near = t < w[AT_CLOSE * SETS + l] - SAME * interval
            least = 0.0 if near else min(least, (w[NEXT_EDGE * SETS + l] - t) / interval - 1e-6)
    return int(least)
