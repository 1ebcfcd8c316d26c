"""Guards of a batch: in which sets one may have fired within the step."""

from __future__ import annotations

from mechid.kernel.batch.loop.memory import (
    ARMED_SETS,
    FAR,
    GOING,
    IN_MODE,
    LENGTH,
    MARGIN,
    PRESENT,
    SLOPES,
    SUSPECT,
)
from mechid.kernel.batch.loop.plant import MODES, MOST_MODES, SETS, apart, in_vectors, margins, slopes
from mechid.kernel.loop.plant import (
    AT_G_NEW,
    AT_G_OLD,
    AT_K,
    AT_X,
    AT_X_NEW,
    FAST,
    GUARD_COUNT,
    INNER,
    MOST_GUARDS,
    NPOINT,
    NS,
    NX,
    Integers,
    Numbers,
    njit,
)


@njit(**INNER, forceinline=True)
def where_in_mode(w: Numbers, s: int, mode: int, g_at: int) -> None:
    """Take what was worked out of a mode's guards for the sets that are in it; the others keep theirs."""
    for i in range(GUARD_COUNT[s, mode]):
        for l in range(SETS):
            here = w[(IN_MODE + s) * SETS + l] == mode
            at = (g_at + s * MOST_GUARDS + i) * SETS + l
            found, other = w[(MARGIN + i) * SETS + l], w[at]
            w[at] = found if here else other


@njit(**INNER, forceinline=True)
def margins_of_sets(w: Numbers, discrete: Integers, x_at: int, g_at: int) -> None:
    """Write the margins of the guards of each set's modes; where a mode has fewer guards than others, one."""
    in_vectors()
    for l in range(SETS):
        for i in range(NS * MOST_GUARDS):
            w[(g_at + i) * SETS + l] = 1.0
    for s in range(NS):
        for mode in range(MODES[s]):
            if GUARD_COUNT[s, mode] > 0 and discrete[PRESENT + s * MOST_MODES + mode] > 0:
                margins(s, mode, w, x_at, MARGIN)
                where_in_mode(w, s, mode, g_at)


@njit(**INNER, forceinline=True)
def slopes_of_sets(w: Numbers, discrete: Integers) -> None:
    """Write the time derivatives of the same margins along the flow at the step's start."""
    in_vectors()
    for l in range(SETS):
        for i in range(NS * MOST_GUARDS):
            w[(SLOPES + i) * SETS + l] = 0.0
    for s in range(NS):
        for mode in range(MODES[s]):
            if GUARD_COUNT[s, mode] > 0 and discrete[PRESENT + s * MOST_MODES + mode] > 0:
                slopes(s, mode, w, AT_X, AT_K, MARGIN)
                where_in_mode(w, s, mode, SLOPES)


@njit(**INNER, fastmath=FAST)
def any_suspect(w: Numbers, discrete: Integers) -> bool:
    """Mark the sets in which a guard may have fired within the step, or an angle has turned far; arm grown guards.

    The rules are those of a kernel's own `any_suspect`, all of them worked out for every set.
    """
    in_vectors()
    apart()
    margins_of_sets(w, discrete, AT_X_NEW, AT_G_NEW)
    slopes_of_sets(w, discrete)
    for l in range(SETS):
        h = w[LENGTH * SETS + l]
        suspect = False
        for i in range(NS * MOST_GUARDS):
            before, after = w[(AT_G_OLD + i) * SETS + l], w[(AT_G_NEW + i) * SETS + l]
            slope, grown = w[(SLOPES + i) * SETS + l] * h, w[(ARMED_SETS + i) * SETS + l]
            armed = grown > 0.0
            low, bend = min(before, after), after - before - slope
            clear = armed & (low + min(slope, 0.0) > 0.0)
            falling = armed & (slope < 0.0)
            dips = falling & (bend > 0.0) & (4.0 * bend * (before - 0.3 * low) < slope * slope)
            wrong = (after < 0.0) | (before < 0.0) | (armed & (after == 0.0)) | dips
            suspect = suspect | (wrong & (not clear))
            w[(ARMED_SETS + i) * SETS + l] = grown if wrong | falling | (after <= 0.0) else 1.0
        for i in range(NX, NPOINT):
            moved = abs(w[(AT_X_NEW + i) * SETS + l] - w[(AT_X + i) * SETS + l])
            suspect = suspect | (moved > 0.5 * FAR)
        suspect = suspect & (h > 0.0) & (w[GOING * SETS + l] > 0.0)
        w[SUSPECT * SETS + l] = 1.0 if suspect else 0.0
    return any_marked(w, SUSPECT)


@njit(**INNER, fastmath=FAST, forceinline=True)
def any_marked(w: Numbers, place: int) -> bool:
    """Whether a place is not zero in any set."""
    in_vectors()
    total = 0
    for l in range(SETS):
        total += 1 if w[place * SETS + l] > 0.0 else 0
    return total > 0
