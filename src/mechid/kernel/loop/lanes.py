"""The lanes of the sensitivities, group by group."""

from __future__ import annotations

from mechid.kernel.loop.memory import GROUPS, LAYER, LAYER_SIZE, LAYERS, MODE, OWN, STALE, fill
from mechid.kernel.loop.plant import (
    AT_G_OLD,
    AT_K,
    AT_POINTS,
    AT_SCALE,
    AT_TANGENT,
    AT_X,
    GROUP_SIZE,
    IN_DRIVE,
    INNER,
    LANES_PER_GROUP,
    MOST_GUARDS,
    NF,
    NFORCED,
    NG,
    NL,
    NP,
    NPOINT,
    NS,
    NX,
    ROW_DIR,
    ROW_FORCE,
    ROW_S,
    SEED_COEFFICIENT,
    SEED_FIRST,
    SEED_PARAMETER,
    Integers,
    Numbers,
    carry_filter_lanes,
    carry_lanes,
    force_filter,
    lane_rates,
    margins,
    measure_group,
    njit,
    output_flow,
    output_gradient,
    put_turned,
    rates,
    tangents,
)

POINTS = 4  # of a step: three stages and its end
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


@njit(**INNER, forceinline=True)
def force_lanes(w: Numbers, discrete: Integers, n: int) -> None:
    """Write the direct effect of group n's directions on its nodes, at the step's points."""
    for k in range(discrete[LAYERS + n], discrete[LAYERS + n + 1]):
        at = LAYER + LAYER_SIZE * k
        a, b, c, d = discrete[at + 1], discrete[at + 2], discrete[at + 3], discrete[at + 4]
        put_turned(w, discrete[at], a, b, c, d, AT_SCALE + LANES_PER_GROUP * k, discrete[at + 5])


@njit(**INNER)
def refresh(w: Numbers, discrete: Integers, sensitive: int) -> None:
    """Rates, margins and the lanes' K of the present state, inputs and modes."""
    discrete[STALE] = 0
    rates(w, AT_X, AT_K)
    for s in range(NS):
        margins(s, discrete[MODE + s], w, AT_X, AT_G_OLD + s * MOST_GUARDS)
    if sensitive:
        for i in range(NPOINT):
            w[AT_POINTS + 3 * NPOINT + i] = w[AT_X + i]
        tangents(w)
        for n in range(NG):
            if discrete[GROUPS + n] == ALL:
                force_lanes(w, discrete, n)
                lane_rates(w, n * GROUP_SIZE)


@njit(**INNER, forceinline=True)
def step_of_lanes(w: Numbers, discrete: Integers, length: float, prop: int) -> None:
    """Carry the lanes over the step that leads to AT_X_NEW."""
    tangents(w)
    for n in range(NG):
        if discrete[GROUPS + n] == ALL:
            force_lanes(w, discrete, n)
            if discrete[OWN + n]:
                force_filter(w, n * GROUP_SIZE)
            carry_lanes(w, n * GROUP_SIZE, length, prop)
        elif discrete[GROUPS + n] == FILTER_ONLY:
            carry_filter_lanes(w, n * GROUP_SIZE, prop)


@njit(**INNER)
def lay_directions(w: Numbers, directions: Numbers, discrete: Integers, n: int) -> None:
    """Sort the direct effects of group n's directions into layers, of one parameter a lane and node.

    Nearly every direction moves one parameter or two, so that a node needs one layer, where a sum over all parameters
    would multiply mostly zeros.
    """
    end = discrete[LAYERS + n]
    for node in range(NFORCED):
        first = end
        for l in range(LANES_PER_GROUP):
            k = first
            for seed in range(SEED_FIRST[node], SEED_FIRST[node + 1]):
                part = directions[SEED_PARAMETER[seed] * NL + n * LANES_PER_GROUP + l]
                if part == 0.0:
                    continue
                at = LAYER + LAYER_SIZE * k
                if k == end:
                    end += 1
                    discrete[at] = n * GROUP_SIZE + (ROW_FORCE + POINTS * node) * LANES_PER_GROUP
                    discrete[at + 5] = int(k > first)
                    for other in range(LANES_PER_GROUP):
                        discrete[at + 1 + other] = AT_TANGENT
                        w[AT_SCALE + LANES_PER_GROUP * k + other] = 0.0
                discrete[at + 1 + l] = AT_TANGENT + POINTS * SEED_COEFFICIENT[seed]
                w[AT_SCALE + LANES_PER_GROUP * k + l] = part
                k += 1
    discrete[LAYERS + n + 1] = end


@njit(**INNER)
def use_groups(w: Numbers, directions: Numbers, discrete: Integers) -> None:
    """Copy the directions to their groups, and note in each what its lanes move."""
    for lane in range(NL):
        n = lane // LANES_PER_GROUP
        for q in range(NP):
            w[lane_place(ROW_DIR + q, lane)] = directions[q * NL + lane]
            if directions[q * NL + lane] != 0.0:
                discrete[GROUPS + n] = max(discrete[GROUPS + n], ALL if IN_DRIVE[q] else FILTER_ONLY)
                discrete[OWN + n] = max(discrete[OWN + n], 0 if IN_DRIVE[q] else 1)
        for i in range(NX):
            if w[lane_place(ROW_S + i, lane)] != 0.0:
                discrete[GROUPS + n] = ALL
    discrete[LAYERS] = 0
    for n in range(NG):
        fill(w, n * GROUP_SIZE + ROW_FORCE * LANES_PER_GROUP, (n + 1) * GROUP_SIZE, 0.0)
        lay_directions(w, directions, discrete, n)


@njit(**INNER)
def drop_denormals(w: Numbers) -> None:
    """Set sensitivities that have died away to zero; denormal numbers are slow."""
    for lane in range(NL):
        for i in range(NX + NF):
            here = lane_place(ROW_S + i, lane)
            if abs(w[here]) < 1e-200:
                w[here] = 0.0
