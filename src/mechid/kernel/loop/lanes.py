"""The lanes of the sensitivities, group by group."""

from __future__ import annotations

from mechid.kernel.loop.memory import GROUPS, MODE, STALE
from mechid.kernel.loop.plant import (
    AT_G_OLD,
    AT_K,
    AT_POINTS,
    AT_X,
    GROUP_SIZE,
    IN_DRIVE,
    INNER,
    LANES_PER_GROUP,
    MOST_GUARDS,
    NF,
    NG,
    NL,
    NP,
    NPOINT,
    NS,
    NX,
    ROW_DIR,
    ROW_S,
    Integers,
    Numbers,
    carry_filter_lanes,
    carry_lanes,
    lane_rates,
    margins,
    measure_group,
    njit,
    output_flow,
    output_gradient,
    rates,
    tangents,
)

UNUSED, FILTER_ONLY, ALL = 0, 1, 2  # what the lanes of a group move


@njit(**INNER, forceinline=True)
def lane_place(row: int, lane: int) -> int:
    """Return the place of a lane in a row of its group."""
    return (lane // LANES_PER_GROUP) * GROUP_SIZE + row * LANES_PER_GROUP + lane % LANES_PER_GROUP


@njit(**INNER, forceinline=True)
def measure_lanes(w: Numbers, discrete: Integers, k_at: int, J: Numbers, y_dot: Numbers, at: int, dot_at: int) -> None:
    """J[at:] = dy/dp along the lanes, output by output, and y_dot[dot_at:] = dy/dt at the present state."""
    output_flow(w, AT_X, k_at, y_dot, dot_at)
    output_gradient(w, AT_X)
    for n in range(NG):
        if discrete[GROUPS + n] == UNUSED:
            continue
        measure_group(w, n * GROUP_SIZE, J, at + n * LANES_PER_GROUP)


@njit(**INNER)
def refresh(w: Numbers, discrete: Integers, sensitive: int) -> None:
    """Rates, margins and the lanes' K of the present state, inputs and modes."""
    discrete[STALE] = 0
    rates(w, AT_X, AT_K)
    for s in range(NS):
        margins(s, discrete[MODE + s], w, AT_X, AT_G_OLD + s * MOST_GUARDS)
    if sensitive:
        for i in range(NPOINT):
            w[AT_POINTS + 4 * i + 3] = w[AT_X + i]
        tangents(w)
        for n in range(NG):
            if discrete[GROUPS + n] == ALL:
                lane_rates(w, n * GROUP_SIZE)


@njit(**INNER, forceinline=True)
def step_of_lanes(w: Numbers, discrete: Integers, length: float, prop: int) -> None:
    """Carry the lanes over the step that leads to AT_X_NEW."""
    tangents(w)
    for n in range(NG):
        if discrete[GROUPS + n] == ALL:
            carry_lanes(w, n * GROUP_SIZE, length, prop)
        elif discrete[GROUPS + n] == FILTER_ONLY:
            carry_filter_lanes(w, n * GROUP_SIZE, prop)


@njit(**INNER)
def use_groups(w: Numbers, directions: Numbers, discrete: Integers) -> None:
    """Copy the directions to their groups, and note in each what its lanes move."""
    for lane in range(NL):
        group = GROUPS + lane // LANES_PER_GROUP
        for q in range(NP):
            w[lane_place(ROW_DIR + q, lane)] = directions[q * NL + lane]
            if directions[q * NL + lane] != 0.0:
                discrete[group] = max(discrete[group], ALL if IN_DRIVE[q] else FILTER_ONLY)
        for i in range(NX):
            if w[lane_place(ROW_S + i, lane)] != 0.0:
                discrete[group] = ALL


@njit(**INNER)
def drop_denormals(w: Numbers) -> None:
    """Set sensitivities that have died away to zero; denormal numbers are slow."""
    for lane in range(NL):
        for i in range(NX + NF):
            here = lane_place(ROW_S + i, lane)
            if abs(w[here]) < 1e-200:
                w[here] = 0.0
