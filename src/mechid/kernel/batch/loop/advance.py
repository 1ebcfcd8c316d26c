"""The time loop of a batch: all sets go together, and one in which something else than flowing happens goes alone."""

from __future__ import annotations

from mechid.kernel.batch.loop.filter import use_propagators, use_whole_steps
from mechid.kernel.batch.loop.memory import (
    CHUNK,
    COUNT,
    COUNTED,
    END,
    GOING,
    IN_MODE,
    INTERVAL,
    LEFT_AT,
    LENGTH,
    NEXT,
    OUTPUT,
    PRESENT,
    SAMPLE,
    STALE_SETS,
    START,
    STEP,
    SUSPECT,
    WHOLE,
)
from mechid.kernel.batch.loop.plan import meet_edges, plan, quiet_samples
from mechid.kernel.batch.loop.plant import (
    MOST_MODES,
    SETS,
    apart,
    called,
    in_vectors,
    outputs,
    rarely,
    rates,
    step,
    turn,
)
from mechid.kernel.batch.loop.sets import come, leave
from mechid.kernel.batch.loop.suspects import any_marked, any_suspect, margins_of_sets
from mechid.kernel.loop.advance import lose
from mechid.kernel.loop.filter import WIDTH
from mechid.kernel.loop.memory import DISCRETE, GRID_INTERVAL, LARGE, OK, REFRESH, ROWS, SAME
from mechid.kernel.loop.plant import (
    AT_CLOSE,
    AT_DZ,
    AT_G_NEW,
    AT_G_OLD,
    AT_K,
    AT_K_NEW,
    AT_MID,
    AT_OTHER,
    AT_TIME,
    AT_X,
    AT_X_NEW,
    AT_Z,
    FAST,
    INNER,
    MOST_GUARDS,
    NF,
    NP,
    NPOINT,
    NS,
    NV,
    NX,
    NY,
    SIZE,
    Array,
    IntegerArray,
    Integers,
    Numbers,
    njit,
    numbers,
)


@njit(**INNER)
def refresh_sets(w: Numbers, discrete: Integers) -> None:
    """Rates and margins of the present states, inputs and modes."""
    in_vectors()
    apart()
    discrete[STALE_SETS] = 0
    rates(w, AT_X, AT_K)
    margins_of_sets(w, discrete, AT_X, AT_G_OLD)


@njit(**INNER)
def expel(w: Numbers, discrete: Integers, row: int, ones: Numbers, owns: Integers) -> None:
    """Let the sets go alone that are suspect."""
    rarely()
    for l in range(discrete[COUNTED]):
        if w[SUSPECT * SETS + l] > 0.0:
            leave(w, discrete, l, row, ones, owns)


@njit(**INNER, fastmath=FAST, forceinline=True)
def accept(w: Numbers) -> None:
    """Let the end of the step at hand be where the sets stand, their filters too."""
    in_vectors()
    for l in range(SETS):
        for i in range(NF):
            total = 0.0
            for j in range(NF):
                total += w[(AT_OTHER + i * WIDTH + j) * SETS + l] * w[(AT_Z + j) * SETS + l]
            for n in range(NV):
                total += w[(AT_OTHER + i * WIDTH + NF + n) * SETS + l] * w[(AT_K + NX + n) * SETS + l]
                total += w[(AT_OTHER + i * WIDTH + NF + NV + n) * SETS + l] * w[(AT_MID + n) * SETS + l]
                total += w[(AT_OTHER + i * WIDTH + NF + 2 * NV + n) * SETS + l] * w[(AT_K_NEW + NX + n) * SETS + l]
            w[(AT_DZ - NF + i) * SETS + l] = total
        for i in range(NF):
            w[(AT_Z + i) * SETS + l] = w[(AT_DZ - NF + i) * SETS + l]
        for i in range(NPOINT):
            w[(AT_X + i) * SETS + l] = w[(AT_X_NEW + i) * SETS + l]
        for i in range(NX + NV):
            w[(AT_K + i) * SETS + l] = w[(AT_K_NEW + i) * SETS + l]
        for i in range(NS * MOST_GUARDS):
            w[(AT_G_OLD + i) * SETS + l] = w[(AT_G_NEW + i) * SETS + l]
        w[AT_TIME * SETS + l] += w[LENGTH * SETS + l]


@njit(**INNER, fastmath=FAST)
def one_step(w: Numbers, discrete: Integers, row: int, ones: Numbers, owns: Integers) -> None:
    """Take the step at hand; sets in which a guard may fire in it leave before."""
    in_vectors()
    apart()
    if discrete[STALE_SETS]:
        refresh_sets(w, discrete)
    step(w, AT_X, AT_K, AT_X_NEW, AT_MID)
    if any_suspect(w, discrete):
        expel(w, discrete, row, ones, owns)
    rates(w, AT_X_NEW, AT_K_NEW)
    accept(w)


@njit(**INNER)
def flow(w: Numbers, discrete: Integers, row: int, most: int, rows: int, ones: Numbers, owns: Integers) -> None:
    """Take the steps that `plan` has set."""
    in_vectors()
    apart()
    for k in range(most):
        for l in range(SETS):
            w[LENGTH * SETS + l] = w[WHOLE * SETS + l] if k < w[COUNT * SETS + l] else 0.0
        use_propagators(w, rows)
        one_step(w, discrete, row, ones, owns)


@njit(**INNER, fastmath=FAST)
def measure(w: Numbers, y: Numbers, row: int, samples: int) -> bool:
    """Write the outputs of every set that goes, each set's samples one behind the other; mark what has diverged."""
    in_vectors()
    apart()
    outputs(w, AT_X, w, OUTPUT)
    for l in range(SETS):
        lost = False
        for j in range(NY):
            lost = lost | (not (abs(w[(OUTPUT + j) * SETS + l]) < LARGE))
        lost = lost & (w[GOING * SETS + l] > 0.0)
        w[SUSPECT * SETS + l] = 1.0 if lost else 0.0
    for l in range(SETS):
        for j in range(NY):
            y[(l * samples + row) * NY + j] = w[(OUTPUT + j) * SETS + l]
    return any_marked(w, SUSPECT)


@njit(**INNER, fastmath=FAST)
def go_together(
    w: Numbers,
    discrete: Integers,
    first: int,
    stop: int,
    samples: int,
    rows: int,
    ones: Numbers,
    owns: Integers,
    times: Numbers,
    values: Numbers,
    edges: int,
    y: Numbers,
) -> None:
    """Advance all sets that go together from row `first` to `stop` of a block of so many samples."""
    in_vectors()
    apart()
    quiet, steps = 0, int(w[INTERVAL * SETS] / w[STEP * SETS] + 0.5)
    for row in range(first, stop):
        if discrete[NEXT] % REFRESH == 0:
            turn(w, AT_X)
            discrete[STALE_SETS] = 1
        for l in range(SETS):
            w[SAMPLE * SETS + l] = w[START * SETS + l] + discrete[NEXT] * w[INTERVAL * SETS + l]
        if quiet > 0:
            quiet -= 1
            for _ in range(steps):
                one_step(w, discrete, row, ones, owns)
            for l in range(SETS):
                w[AT_TIME * SETS + l] = w[SAMPLE * SETS + l]
        else:
            short = True
            while short:
                most, edge, short = plan(w)
                flow(w, discrete, row, most, rows, ones, owns)
                for l in range(SETS):
                    w[AT_TIME * SETS + l] = w[END * SETS + l]
                if edge:
                    meet_edges(w, discrete, times, values, edges)
            quiet = quiet_samples(w, discrete)
            for l in range(SETS):
                w[LENGTH * SETS + l] = w[STEP * SETS + l]
            use_whole_steps(w)
        if measure(w, y, row, samples):
            expel(w, discrete, row, ones, owns)
        discrete[NEXT] += 1


@njit(**INNER)
def is_close(l: int, grids: Numbers, ones: Numbers) -> bool:
    """Whether set l stands close behind its start or a break-away, where steps are short."""
    return ones[l * SIZE + AT_TIME] < ones[l * SIZE + AT_CLOSE] - SAME * grids[4 * l + GRID_INTERVAL]


@njit(**INNER)
def gather(
    w: Numbers,
    discrete: Integers,
    grids: Numbers,
    ones: Numbers,
    owns: Integers,
    statuses: Integers,
    times: Numbers,
    edges: int,
) -> None:
    """Let those come that may: what is close behind a break-away comes where most are."""
    rarely()
    close = 0
    for k in range(NS * MOST_MODES):
        discrete[PRESENT + k] = 0
    for l in range(discrete[COUNTED]):
        waits = w[GOING * SETS + l] == 0.0 and statuses[l] == OK
        close += 1 if waits and is_close(l, grids, ones) else 0
    for l in range(discrete[COUNTED]):
        waits = w[GOING * SETS + l] == 0.0 and statuses[l] == OK
        if waits and (2 * close >= SETS or not is_close(l, grids, ones)):
            come(w, discrete, l, ones, owns, times, edges)
            discrete[STALE_SETS] = 1
        for k in range(NS):
            if w[GOING * SETS + l] > 0.0:
                discrete[PRESENT + k * MOST_MODES + int(w[(IN_MODE + k) * SETS + l])] = 1


@njit(error_model="numpy", cache=True, nogil=True, no_cfunc_wrapper=True)
def run_batch(
    address: int,
    p: Array,
    directions: Array,
    grids: Array,
    edge_times: Array,
    edge_values: Array,
    owns: IntegerArray,
    ones: Array,
    statuses: IntegerArray,
    discrete: IntegerArray,
    w: Array,
    y: Array,
    events: Array,
) -> None:
    """Advance all sets of a batch over len(y) / NY / SETS samples from where they stand.

    address is that of the kernel's `run`. All arrays are flat, those of each set one behind the other: p (SETS NP),
    grids (SETS 4), owns (SETS DISCRETE), ones (SETS SIZE) and events are what `run` takes of one; directions (NP NL)
    are zeros; statuses (SETS) say what became of each; discrete (DISCRETE_SETS) and w (PLACES SETS) are the batch's
    own; y (SETS n NY) the outputs, NaN where a set has failed.
    """
    samples, edges, most = y.shape[0] // (NY * SETS), edge_times.shape[0], events.shape[0] // SETS
    none, rows = y[:0], 0
    W, D, G, O, N, S = numbers(w), numbers(discrete), numbers(grids), numbers(ones), numbers(owns), numbers(statuses)
    T, V, Y = numbers(edge_times), numbers(edge_values), numbers(y)
    D[COUNTED] = SETS
    for l in range(D[COUNTED]):
        rows = max(rows, N[l * DISCRETE + ROWS])
    for first in range(0, samples, CHUNK):
        stop, begin = min(first + CHUNK, samples), D[NEXT]
        gather(W, D, G, O, N, S, T, edges)
        together = 0
        for l in range(D[COUNTED]):
            D[LEFT_AT + l] = stop if W[GOING * SETS + l] > 0.0 else first
            together += D[LEFT_AT + l] - first
        if together > 0:
            go_together(W, D, first, stop, samples, rows, O, N, T, V, edges, Y)
        for l in range(D[COUNTED]):
            left = l * samples + D[LEFT_AT + l]
            last = l * samples + stop
            if left < last and S[l] == OK:
                S[l] = called(
                    address,
                    p[l * NP : (l + 1) * NP],
                    directions,
                    0,
                    grids[4 * l : 4 * l + 4],
                    edge_times,
                    edge_values,
                    owns[l * DISCRETE : (l + 1) * DISCRETE],
                    ones[l * SIZE : (l + 1) * SIZE],
                    y[left * NY : last * NY],
                    none,
                    none,
                    events[l * most : (l + 1) * most],
                )
            elif left < last:
                lose(Y, left, last)
        D[NEXT] = begin + stop - first
