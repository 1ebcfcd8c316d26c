"""What happens when a guard fires."""

from __future__ import annotations

from mechid.kernel.loop.guards import arm, margin_after
from mechid.kernel.loop.lanes import lane_place, measure_lanes
from mechid.kernel.loop.memory import (
    AHEAD,
    EVENT_AFTER,
    EVENT_BEFORE,
    EVENT_LANES,
    EVENT_RISE,
    EVENT_SLOPE,
    EVENT_SWITCH,
    EVENT_TIME,
    EVENTS,
    MODE,
    THROWN,
    fill,
)
from mechid.kernel.loop.plant import (
    AT_B,
    AT_DOT_PAIR,
    AT_G_NEW,
    AT_G_P,
    AT_G_SLOPE,
    AT_G_X,
    AT_J_PAIR,
    AT_JUMP,
    AT_JUMP_LANES,
    AT_K,
    AT_K_EVENT,
    AT_PAIR,
    AT_PINNED,
    AT_TIME,
    AT_X,
    AT_X_TRY,
    END_G_P,
    END_PINNED,
    GUARD_FIRST,
    GUARD_TARGET,
    INNER,
    NF,
    NL,
    NP,
    NS,
    NV,
    NX,
    NY,
    ROW_DIR,
    ROW_DTAU,
    ROW_S,
    ROW_SZ,
    Integers,
    Numbers,
    entry_mode,
    gradients,
    margins,
    njit,
    outputs,
    rates,
    reset_states,
    set_mode,
    slopes,
    turn,
)


@njit(**INNER)
def saltation(w: Numbers, s: int, mode: int, i: int, slope: float, h: float, at_edge: int) -> None:
    """Write dtau/dp = -(g_x S + g_p)/(g_x f) of the instant at which guard i of a mode fires, into its row.

    A guard that was thrown below zero by a jump fires with that jump: at an edge, which no parameter moves, or with
    the switch before, whose dtau/dp stands there still.
    """
    margins(s, mode, w, AT_X, AT_G_NEW)
    thrown = w[AT_G_NEW + i] < -THROWN * abs(slope) * h
    if thrown and not at_edge:
        return
    fill(w, AT_G_X, END_G_P, 0.0)
    if not thrown:
        gradients(s, mode, w, AT_X)
    for lane in range(NL):
        total = 0.0
        for n in range(NX):
            total += w[AT_G_X + i * NX + n] * w[lane_place(ROW_S + n, lane)]
        for q in range(NP):
            total += w[AT_G_P + i * NP + q] * w[lane_place(ROW_DIR + q, lane)]
        w[lane_place(ROW_DTAU, lane)] = -total / slope if total != 0.0 else 0.0


@njit(**INNER)
def jump_of_lanes(w: Numbers) -> None:
    """S+ = S- + (f- - f+) dtau/dp; a state that takes a fixed value keeps only what flows after."""
    for lane in range(NL):
        dtau = w[lane_place(ROW_DTAU, lane)]
        for i in range(NX):
            here = lane_place(ROW_S + i, lane)
            old = w[here] + w[AT_K + i] * dtau
            if w[AT_PINNED + i] > 0.0:
                old = 0.0
            w[here] = old - w[AT_K_EVENT + i] * dtau
        for i in range(NF):
            for n in range(NV):
                drop = w[AT_B + i * NV + n] * (w[AT_K + NX + n] - w[AT_K_EVENT + NX + n])
                w[lane_place(ROW_SZ + i, lane)] += drop * dtau


@njit(**INNER)
def entered(s: int, mode: int, i: int, w: Numbers, h: float) -> int:
    """Return the mode that switch s takes where guard i has ended its mode.

    Where that would be the same mode again, nothing pulls either way at this instant: what follows decides.
    """
    found = entry_mode(s, w, AT_X)
    if found == mode:
        margin_after(AHEAD, s, mode, i, w, h)
        found = entry_mode(s, w, AT_X_TRY)
    return found


@njit(**INNER)
def change_mode(
    s: int, i: int, share: float, h: float, w: Numbers, discrete: Integers, sensitive: int, at_edge: int
) -> float:
    """Guard i of switch s fires: new mode, jump of the sensitivities and of the outputs; return its slope.

    Where y itself jumps, the sample that ends the interval takes the jump's mean over it: `share` of the
    interval has passed (negative: the switch is older than it), AT_JUMP collects what is to be added. at_edge: no
    switch has come since the last edge.
    """
    mode = discrete[MODE + s]
    slopes(s, mode, w, AT_X, AT_K, AT_G_SLOPE)
    slope = w[AT_G_SLOPE + i]
    outputs(w, AT_X, w, AT_PAIR)
    if sensitive:
        saltation(w, s, mode, i, slope, h, at_edge)
        measure_lanes(w, discrete, AT_K, w, w, AT_J_PAIR, AT_DOT_PAIR)
    fill(w, AT_PINNED, END_PINNED, 0.0)
    guard = GUARD_FIRST[s, mode] + i
    reset_states(guard, w, AT_X)
    turn(w, AT_X)
    discrete[MODE + s] = GUARD_TARGET[guard] if GUARD_TARGET[guard] >= 0 else entered(s, mode, i, w, h)
    set_mode(s, discrete[MODE + s], w)
    for other in range(NS):
        arm(other, w, discrete)
    rates(w, AT_X, AT_K_EVENT)
    outputs(w, AT_X, w, AT_PAIR + NY)
    if sensitive:
        jump_of_lanes(w)
        measure_lanes(w, discrete, AT_K_EVENT, w, w, AT_J_PAIR + NY * NL, AT_DOT_PAIR + NY)
    for j in range(NY if share > 0.0 else 0):
        rise, bend = w[AT_PAIR + NY + j] - w[AT_PAIR + j], w[AT_DOT_PAIR + NY + j] - w[AT_DOT_PAIR + j]
        w[AT_JUMP + j] -= rise * share
        w[AT_JUMP + NY + j] -= rise / h
        for l in range(NL):
            at, dtau = AT_J_PAIR + j * NL + l, w[lane_place(ROW_DTAU, l)]
            rise_p = w[at + NY * NL] - w[at] + bend * dtau
            w[AT_JUMP_LANES + j * NL + l] -= rise_p * share + rise / h * dtau
    return slope


@njit(**INNER)
def add_jump(w: Numbers, y: Numbers, y_dot: Numbers, J: Numbers, row: int, sensitive: int) -> None:
    """Give the sample its share of the jumps in its interval."""
    for j in range(NY):
        y[row * NY + j] += w[AT_JUMP + j]
        if sensitive:
            y_dot[row * NY + j] -= w[AT_JUMP + NY + j]
            for l in range(NL):
                J[(row * NY + j) * NL + l] += w[AT_JUMP_LANES + j * NL + l]


@njit(**INNER)
def log_event(events: Numbers, most: int, discrete: Integers, w: Numbers, s: int, old_mode: int, slope: float) -> None:
    """Note instant, switch, modes before and after, slope of the guard, rise of the outputs, lanes of the instant."""
    at = discrete[EVENTS] * (EVENT_LANES + NL)
    if at < most:
        events[at + EVENT_TIME], events[at + EVENT_SLOPE] = w[AT_TIME], slope
        events[at + EVENT_SWITCH] = s
        events[at + EVENT_BEFORE], events[at + EVENT_AFTER] = old_mode, discrete[MODE + s]
        for j in range(NY):
            events[at + EVENT_RISE + j] = w[AT_PAIR + NY + j] - w[AT_PAIR + j]
        for l in range(NL):
            events[at + EVENT_LANES + l] = w[lane_place(ROW_DTAU, l)]
    discrete[EVENTS] += 1
