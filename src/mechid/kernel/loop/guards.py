"""Guards: which of them fires within a step, and when."""

from __future__ import annotations

import math

from mechid.kernel.loop.memory import ARMED, MODE, THROWN
from mechid.kernel.loop.plant import (
    AT_G_NEW,
    AT_G_OLD,
    AT_G_SLOPE,
    AT_K,
    AT_K_NEW,
    AT_MID_TRY,
    AT_X,
    AT_X_NEW,
    AT_X_TRY,
    GUARD_COUNT,
    INNER,
    MOST_GUARDS,
    NS,
    Integers,
    Numbers,
    margins,
    njit,
    rates,
    slopes,
    step,
)


@njit(**INNER)
def margin_after(share: float, s: int, mode: int, i: int, w: Numbers, h: float) -> float:
    """Return the margin of guard i of a mode after a share of the step."""
    step(w, AT_X, AT_K, share * h, AT_X_TRY, AT_MID_TRY)
    margins(s, mode, w, AT_X_TRY, AT_G_SLOPE)
    return w[AT_G_SLOPE + i]


@njit(**INNER)
def locate(s: int, mode: int, i: int, w: Numbers, h: float, inside: float, outside: float) -> float:
    """Return the share of a step of length h after which a margin, positive at `inside`, reaches zero.

    Illinois variant of the secant rule on the step itself, so that the state there is the step's own.
    """
    f_inside = margin_after(inside, s, mode, i, w, h)
    f_outside = margin_after(outside, s, mode, i, w, h)
    side = 0
    for _ in range(100):
        if f_inside <= 0.0 or f_outside == 0.0 or outside - inside <= 4e-16 * outside:
            break
        share = (inside * f_outside - outside * f_inside) / (f_outside - f_inside)
        if not inside < share < outside:
            share = 0.5 * (inside + outside)
        f = margin_after(share, s, mode, i, w, h)
        if f > 0.0:
            inside, f_inside = share, f
            if side == 1:
                f_outside *= 0.5
            side = 1
        else:
            outside, f_outside = share, f
            if side == -1:
                f_inside *= 0.5
            side = -1
    return outside if f_inside > 0.0 else inside


@njit(**INNER, forceinline=True)
def any_suspect(w: Numbers, discrete: Integers, h: float) -> bool:
    """Whether any guard may have fired within the step: cheap, and never wrongly False.

    After a step that ends on the right side the parabola through both margins and the first slope must
    stay clear of zero. Arms the guards that have grown. The margins at the step's start are known from before.
    """
    suspect = False
    for s in range(NS):
        mode, first = discrete[MODE + s], s * MOST_GUARDS
        margins(s, mode, w, AT_X_NEW, AT_G_NEW + first)
        slopes(s, mode, w, AT_X, AT_K, AT_G_SLOPE)
        count = GUARD_COUNT[s, mode]
        for i in range(MOST_GUARDS):
            if i >= count:
                break
            before, after, slope = w[AT_G_OLD + first + i], w[AT_G_NEW + first + i], w[AT_G_SLOPE + i] * h
            armed = discrete[ARMED + first + i]
            if armed and min(before, after) + min(slope, 0.0) > 0.0:
                continue  # far enough: the parabola's lowest point is above half of the margin before
            if after < 0.0 or before < 0.0 or (armed and after == 0.0):
                suspect = True
            elif armed and slope < 0.0:
                bend = after - before - slope
                if bend > 0.0 and before - slope * slope / (4.0 * bend) < 0.3 * min(before, after):
                    suspect = True
            elif after > 0.0:
                discrete[ARMED + first + i] = 1
    return suspect


@njit(**INNER)
def lowest_point(s: int, mode: int, i: int, w: Numbers, h: float, f_0: float, f_1: float) -> float:
    """Return where the cubic through a margin and its slopes at both ends has its minimum, else -1."""
    rates(w, AT_X_NEW, AT_K_NEW)
    slopes(s, mode, w, AT_X, AT_K, AT_G_SLOPE)
    d_0 = w[AT_G_SLOPE + i] * h
    slopes(s, mode, w, AT_X_NEW, AT_K_NEW, AT_G_SLOPE)
    d_1 = w[AT_G_SLOPE + i] * h
    b, a = 3.0 * (f_1 - f_0) - 2.0 * d_0 - d_1, 2.0 * (f_0 - f_1) + d_0 + d_1
    root = b * b - 3.0 * a * d_0
    if root < 0.0 or b + math.sqrt(root) == 0.0:
        return -1.0
    return -d_0 / (b + math.sqrt(root))


@njit(**INNER)
def first_crossing(s: int, mode: int, i: int, w: Numbers, h: float, armed: int) -> float:
    """Return the share of the step at which guard i ends the mode of switch s, or 2.0 where it does not.

    A guard not yet armed stands at zero since its mode began: its margin must first have grown. One that a jump, of
    the inputs or of another switch, has thrown below zero fires at once.
    """
    after, before = margin_after(1.0, s, mode, i, w, h), margin_after(0.0, s, mode, i, w, h)
    if before < -THROWN * abs(after - before):
        return 0.0
    outside = 1.0
    inside = 0.0 if armed else -1.0
    if not armed:
        if after >= 0.0:
            return 2.0
        for _ in range(40):
            if margin_after(0.5 * outside, s, mode, i, w, h) > 0.0:
                inside = 0.5 * outside
                break
            outside *= 0.5
        if inside < 0.0:
            return 0.0
    elif after > 0.0:
        outside = lowest_point(s, mode, i, w, h, before, after)
        if not 0.0 < outside < 1.0 or margin_after(outside, s, mode, i, w, h) > 0.0:
            return 2.0
    return locate(s, mode, i, w, h, inside, outside)


@njit(**INNER)
def find_event(w: Numbers, discrete: Integers, h: float) -> tuple[float, int, int]:
    """Return (share, switch, guard) of the first guard that fires within the step; switch -1: none."""
    share, fired, guard = 2.0, -1, -1
    for s in range(NS):
        mode = discrete[MODE + s]
        for i in range(GUARD_COUNT[s, mode]):
            at = first_crossing(s, mode, i, w, h, discrete[ARMED + s * MOST_GUARDS + i])
            if at < share:
                share, fired, guard = at, s, i
    return share, fired, guard


@njit(**INNER)
def arm(s: int, w: Numbers, discrete: Integers) -> None:
    """Mark the guards of switch s that stand clear of zero in its present mode."""
    first = s * MOST_GUARDS
    margins(s, discrete[MODE + s], w, AT_X, AT_G_OLD + first)
    for i in range(GUARD_COUNT[s, discrete[MODE + s]]):
        discrete[ARMED + first + i] = 1 if w[AT_G_OLD + first + i] > 0.0 else 0
