"""Looking into a kernel's workspace: where the tests read and write its state by the names of its places."""

from dataclasses import dataclass

import numpy as np

from mechid.kernel.compiled import allocate
from mechid.kernel.twin import TwinState


def places(kernel):
    """Return the names of a generated module: AT_X, END_X, ROW_S, MODE, ..."""
    return kernel.run.py_func.__globals__


def twin_state(run) -> TwinState:
    """Return where a run stands, for the twin to go on from."""
    kernel, buffers = run.simulator.kernel, run.buffers
    at, w, discrete = places(kernel), buffers.w, buffers.discrete
    x, z = w[at["AT_X"] : at["END_X"]], w[at["AT_Z"] : at["END_Z"]]
    modes = discrete[at["MODE"] : at["MODE"] + at["NS"]]
    armed = discrete[at["ARMED"] :].reshape(at["NS"], -1)
    counts = [len(list(s.guards.values())[m]) for s, m in zip(run.simulator.plant.switches, modes, strict=True)]
    m = len(run.simulator.sensitive)
    rows = at["NX"] + at["NF"]
    first = at.get("ROW_S", 0) * at["NL"]
    S = w[first : first + rows * at["NL"]].reshape(rows, -1)[:, :m] if m else np.zeros((rows, 0))
    return TwinState(
        time=float(w[at["AT_TIME"]]),
        s=np.concatenate([x, z]),
        S=S.copy(),
        inputs=w[at["AT_U"] : at["END_U"]].copy(),
        modes=tuple(map(int, modes)),
        armed=tuple(tuple(map(bool, flags[:n])) for flags, n in zip(armed, counts, strict=True)),
    )


@dataclass(frozen=True)
class Point:
    """What a kernel makes of one state: rates (n_x,), y and dy/dt (n_y,), and derivatives of rates and y."""

    rates: np.ndarray
    y: np.ndarray
    y_dot: np.ndarray
    rates_by: np.ndarray
    y_by: np.ndarray


def evaluated(kernel, p, x, z, u, mode, sensitive) -> Point:
    """Evaluate a kernel with lanes at one state; derivatives are to x, z, and then to parameters `sensitive`."""
    by_state = _at(kernel, p, x, z, u, mode, np.eye(len(x) + len(z)), ())
    by_parameter = _at(kernel, p, x, z, u, mode, np.zeros((len(x) + len(z), 0)), sensitive)
    return Point(
        by_state.rates,
        by_state.y,
        by_state.y_dot,
        np.hstack([by_state.rates_by, by_parameter.rates_by]),
        np.hstack([by_state.y_by, by_parameter.y_by]),
    )


def _at(kernel, p, x, z, u, mode, S, sensitive) -> Point:
    """Take one sample at the very instant at which the state is set: nothing flows."""
    at, b = places(kernel), allocate(kernel.plant, kernel.source, samples=1, events=0)
    b.lane[list(sensitive)] = np.arange(len(sensitive))
    kernel.begin(p, b.lane, u, 0.0, b.discrete, b.w)
    n, lanes = S.shape[1] or len(sensitive), at["NL"]
    rows = b.w[at["ROW_S"] * lanes : (at["ROW_S"] + at["NX"] + at["NF"]) * lanes].reshape(-1, lanes)
    rows[:] = 0.0
    rows[:, : S.shape[1]] = S
    b.w[at["AT_X"] : at["END_X"]], b.w[at["AT_Z"] : at["END_Z"]] = x, z
    b.discrete[at["MODE"]] = mode
    kernel.run(p, b.lane, np.array([0.0, 1e-4, 1e-4]), np.zeros(0), np.zeros(0), *b.run_arguments(1))
    first = at["ROW_K1"] * lanes
    K1 = b.w[first : first + at["NX"] * lanes].reshape(-1, lanes)
    rates = b.w[at["AT_K"] : at["AT_K"] + at["NX"]]
    J = b.J.reshape(-1, lanes)
    return Point(rates.copy(), b.y.copy(), b.y_dot.copy(), K1[:, :n].copy(), J[:, :n].copy())
