"""The time loop."""

from __future__ import annotations

import math

import numpy as np

from mechid.kernel.loop.filter import advance_filter, filter_propagator, filter_table
from mechid.kernel.loop.guards import any_suspect, arm, find_event
from mechid.kernel.loop.lanes import drop_denormals, lane_place, measure_lanes, refresh, step_of_lanes, use_groups
from mechid.kernel.loop.memory import (
    CHATTER,
    CLOSE_SAMPLES,
    DISCRETE,
    DIVERGED,
    EDGE,
    GRID_CLOSE,
    GRID_INTERVAL,
    GRID_START,
    GRID_STEP,
    LARGE,
    MODE,
    MOST_EVENTS,
    NEXT_SAMPLE,
    OK,
    REFRESH,
    ROWS,
    SAME,
    STALE,
    fill,
)
from mechid.kernel.loop.plant import (
    AT_CLOSE,
    AT_G_NEW,
    AT_G_OLD,
    AT_JUMP,
    AT_K,
    AT_K_NEW,
    AT_KNOWN,
    AT_MID,
    AT_ONE,
    AT_OTHER,
    AT_REGULAR,
    AT_TIME,
    AT_U,
    AT_X,
    AT_X_NEW,
    AT_X_P,
    END_JUMP_LANES,
    ENTRY,
    FAST,
    GUARD_FIRST,
    GUARD_TARGET,
    INNER,
    MOST_GUARDS,
    NF,
    NL,
    NONE,
    NP,
    NPF,
    NPOINT,
    NS,
    NU,
    NV,
    NX,
    NY,
    ROW_S,
    SIZE,
    Array,
    IntegerArray,
    Numbers,
    constants,
    entry_mode,
    filter_matrices,
    njit,
    numbers,
    outputs,
    rates,
    set_mode,
    start,
    step,
    turn,
)
from mechid.kernel.loop.switches import add_jump, change_mode, log_event


@njit(**ENTRY)
def begin(
    p: Array, directions: Array, inputs: Array, theta_0: float, x_0: Array, x_p: Array, discrete: IntegerArray, w: Array
) -> None:
    """Set state, modes and sensitivities to the start of a record: currents settled, gear unwound.

    x_0 (NX) and x_p (NX NP), where not empty, are a start and its derivatives that are known better.
    """
    p, directions, discrete, w = numbers(p), numbers(directions), numbers(discrete), numbers(w)
    fill(w, 0, SIZE, 0.0)
    w[AT_ONE] = 1.0
    for i in range(NU):
        w[AT_U + i] = inputs[i]
    start(p, theta_0, w, AT_X)
    for i in range(x_0.shape[0]):
        w[AT_X + i] = x_0[i]
    for i in range(x_p.shape[0]):
        w[AT_X_P + i] = x_p[i]
    constants(p, w)
    turn(w, AT_X)
    for i in range(DISCRETE):
        discrete[i] = 0
    discrete[STALE] = 1
    for s in range(NS):
        set_mode(s, 0, w)
    for _ in range(min(NS, 2)):  # a second time, as one switch's entry may ask for another's mode
        for s in range(NS):
            discrete[MODE + s] = entry_mode(s, w, AT_X)
            set_mode(s, discrete[MODE + s], w)
    for s in range(NS):
        arm(s, w, discrete)
    for i in range(NX):
        for q in range(NP):
            for lane in range(NL):
                w[lane_place(ROW_S + i, lane)] += w[AT_X_P + i * NP + q] * directions[q * NL + lane]


@njit(**INNER)
def lose(y: Numbers, row: int, rows: int) -> None:
    """Mark the samples from `row` to `rows` as lost."""
    for i in range(row * NY, rows * NY):
        y[i] = np.nan


@njit(**ENTRY, fastmath=FAST)
def run(
    p: Array,
    directions: Array,
    sensitive: int,
    grid: Array,
    edge_times: Array,
    edge_values: Array,
    discrete: IntegerArray,
    w: Array,
    y: Array,
    y_dot: Array,
    J: Array,
    events: Array,
) -> int:
    """Advance a record over len(y) / NY samples from where w stands; return OK, DIVERGED or CHATTER.

    All arrays are flat. p (NP) parameters; directions (NP NL) what each lane moves of them; sensitive: whether
    the lanes are wanted; grid: time of sample 0, sample interval, longest step, longest step close behind a
    break-away or the start, s; edge_times (E) and edge_values (E NU), inputs held from there on; discrete: next
    sample, next edge, events so far, whether the rates are stale, rows of the filter's table, modes, armed guards, what
    moves in each group of lanes; w: time, states, inputs, sensitivities and scratch; y, y_dot (n NY) and J (n NY NL)
    outputs, their time derivative and their derivative to the parameters; events, each EVENT_LANES + NL.
    """
    samples, edges, most = y.shape[0] // NY, edge_times.shape[0], events.shape[0]
    p, directions, edge_times, edge_values = numbers(p), numbers(directions), numbers(edge_times), numbers(edge_values)
    discrete, w, y, y_dot, J, events = (
        numbers(discrete),
        numbers(w),
        numbers(y),
        numbers(y_dot),
        numbers(J),
        numbers(events),
    )
    t_zero, h, longest = grid[GRID_START], grid[GRID_INTERVAL], grid[GRID_STEP]
    asked = NPF if sensitive else 0  # of the filter's parameters
    if discrete[ROWS] == 0:
        filter_matrices(p, w)
        discrete[ROWS] = filter_table(w, longest, asked)
        filter_propagator(w, 1.0, discrete[ROWS], AT_REGULAR, asked)
        w[AT_KNOWN], w[AT_CLOSE] = -longest, w[AT_TIME] + CLOSE_SAMPLES * h
    rows = discrete[ROWS]
    constants(p, w)
    for s in range(NS):
        set_mode(s, discrete[MODE + s], w)
    drop_denormals(w)
    if sensitive:
        use_groups(w, directions, discrete)
    for row in range(samples):
        t_sample = t_zero + discrete[NEXT_SAMPLE] * h
        if discrete[NEXT_SAMPLE] % REFRESH == 0:
            turn(w, AT_X)
            discrete[STALE] = 1
        jumped, edge_last, n_events = False, False, 0
        while True:
            t, t_end, at_edge = w[AT_TIME], t_sample, False
            if discrete[EDGE] < edges and edge_times[discrete[EDGE]] < t_sample - 1e-9 * h:
                t_end, at_edge = edge_times[discrete[EDGE]], True
            reach = longest
            if t < w[AT_CLOSE] - SAME * h:
                reach = grid[GRID_CLOSE]
                if w[AT_CLOSE] < t_end - SAME * h:
                    t_end, at_edge = w[AT_CLOSE], False
            count, whole = 1, t_end - t
            if whole > 1.000000001 * reach:
                count = int(math.ceil(whole / reach - 1e-9))
                whole /= count
            elif whole < 1e-9 * reach:
                count = 0
            length, fired, guard, searched = whole, NONE, NONE, False
            while count > 0:
                if discrete[STALE]:
                    refresh(w, discrete, sensitive)
                step(w, AT_X, AT_K, length, AT_X_NEW, AT_MID)
                if not searched and any_suspect(w, discrete, whole):
                    share, fired, guard = find_event(w, discrete, whole)
                    length, searched = share * whole if fired >= 0 else whole, True
                    continue  # take the step again, now to the instant of the event if there is one
                prop = AT_REGULAR
                if NF > 0 and abs(length - longest) > SAME * longest:
                    prop = AT_OTHER
                    if abs(length - w[AT_KNOWN]) > SAME * longest:
                        filter_propagator(w, length / longest, rows, AT_OTHER, asked)
                        w[AT_KNOWN] = length
                rates(w, AT_X_NEW, AT_K_NEW)
                advance_filter(w, prop, AT_K, AT_MID, AT_K_NEW, asked)
                if sensitive:
                    step_of_lanes(w, discrete, length, prop)
                for i in range(NPOINT):
                    w[AT_X + i] = w[AT_X_NEW + i]
                for i in range(NX + NV):
                    w[AT_K + i] = w[AT_K_NEW + i]
                for i in range(NS * MOST_GUARDS):
                    w[AT_G_OLD + i] = w[AT_G_NEW + i]
                w[AT_TIME] += length
                if fired >= 0:
                    break
                count, n_events, searched = count - 1, 0, False
            if fired >= 0:
                if not jumped:
                    fill(w, AT_JUMP, END_JUMP_LANES, 0.0)
                    jumped = True
                old_mode = discrete[MODE + fired]
                passed = 1.0 - (t_sample - w[AT_TIME]) / h
                slope = change_mode(fired, guard, passed, h, w, discrete, sensitive, int(edge_last))
                log_event(events, most, discrete, w, fired, old_mode, slope)
                discrete[STALE], edge_last = 1, False
                if GUARD_TARGET[GUARD_FIRST[fired, old_mode] + guard] >= 0:
                    w[AT_CLOSE] = w[AT_TIME] + CLOSE_SAMPLES * h
                n_events += 1
                if n_events > MOST_EVENTS:
                    lose(y, row, samples)
                    return CHATTER
                continue  # what is left until t_end, in the steps close behind a break-away
            w[AT_TIME] = t_end
            if at_edge:
                for i in range(NU):
                    w[AT_U + i] = edge_values[discrete[EDGE] * NU + i]
                discrete[EDGE] += 1
                discrete[STALE], edge_last = 1, True
            elif t_end == t_sample:
                break
        outputs(w, AT_X, y, row * NY)
        if sensitive:
            if discrete[STALE]:
                refresh(w, discrete, sensitive)
            measure_lanes(w, discrete, AT_K, J, y_dot, row * NY * NL, row * NY)
        if jumped:
            add_jump(w, y, y_dot, J, row, sensitive)
        for j in range(NY):
            if not abs(y[row * NY + j]) < LARGE:
                lose(y, row, samples)
                return DIVERGED
        discrete[NEXT_SAMPLE] += 1
    return OK
