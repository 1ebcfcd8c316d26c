"""Looking into a kernel's workspace: where the tests read and write its state by the names of its places."""

from dataclasses import dataclass, replace

import numpy as np

from mechid.command import Command, RateProfile
from mechid.kernel.twin import TwinState
from mechid.simulation.simulator import Simulator, TimeBase
from paper import SENSITIVE

STANDSTILL = Command(stepping="full", microsteps=1, rate=RateProfile.constant(0.0))


def places(kernel):
    """Return the names of a generated module: AT_X, END_X, ROW_S, MODE, ..."""
    return vars(kernel.module)


def lane_rows(run, first, count):
    """Return (count, lanes) numbers of all lanes in rows of their groups, from the row of that name on."""
    at = places(run.simulator.kernel)
    groups = run.buffers.w[: at["NG"] * at["GROUP_SIZE"]].reshape(at["NG"], -1, at["LANES_PER_GROUP"])
    return groups[:, at[first] : at[first] + count].transpose(1, 0, 2).reshape(count, -1)


def set_lanes(run, S):
    """Set the lanes' states to S, (n_x + n_z, m), and those beyond to zero."""
    at = places(run.simulator.kernel)
    rows = np.zeros((S.shape[0], at["NL"]))
    rows[:, : S.shape[1]] = S
    groups = run.buffers.w[: at["NG"] * at["GROUP_SIZE"]].reshape(at["NG"], -1, at["LANES_PER_GROUP"])
    groups[:, at["ROW_S"] : at["ROW_S"] + len(S)] = rows.reshape(len(S), at["NG"], -1).transpose(1, 0, 2)


def twin_state(run) -> TwinState:
    """Return where a run stands, for the twin to go on from."""
    kernel, buffers = run.simulator.kernel, run.buffers
    at, w, discrete = places(kernel), buffers.w, buffers.discrete
    x, z = w[at["AT_X"] : at["END_X"]], w[at["AT_Z"] : at["END_Z"]]
    modes = discrete[at["MODE"] : at["MODE"] + at["NS"]]
    armed = discrete[at["ARMED"] : at["GROUPS"]].reshape(at["NS"], -1)
    counts = [len(list(s.guards.values())[m]) for s, m in zip(run.simulator.plant.switches, modes, strict=True)]
    m = len(run.simulator.sensitive)
    rows = at["NX"] + at["NF"]
    S = lane_rows(run, "ROW_S", rows)[:, :m] if m else np.zeros((rows, 0))
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


def evaluated(m, x, z, u, mode, sensitive) -> Point:
    """Evaluate a mechanism's kernel at one state; derivatives are to x, z, and then to parameters `sensitive`."""
    by_state = _at(m, x, z, u, mode, np.eye(len(x) + len(z)), ())
    by_parameter = _at(m, x, z, u, mode, np.zeros((len(x) + len(z), 0)), sensitive)
    rates_by = np.hstack([by_state.rates_by, by_parameter.rates_by])
    return replace(by_state, rates_by=rates_by, y_by=np.hstack([by_state.y_by, by_parameter.y_by]))


def _at(m, x, z, u, mode, S, sensitive) -> Point:
    """Take one sample at the very instant at which the state is set: nothing flows."""
    lanes_wanted = tuple((i,) for i in sensitive) or ((0,),)
    run = Simulator(m.plant, STANDSTILL, TimeBase(1e4, 1), lanes_wanted, capacity=len(SENSITIVE)).run(m.kernel_values())
    at, b = places(run.simulator.kernel), run.buffers
    n = S.shape[1] or len(sensitive)
    if not sensitive:
        b.directions[:] = 0.0  # no lane moves a parameter; each starts as one state
    set_lanes(run, S)
    b.w[at["AT_X"] : at["END_X"]], b.w[at["AT_Z"] : at["END_Z"]] = x, z
    b.w[at["AT_U"] : at["END_U"]] = u
    b.discrete[at["MODE"]] = mode
    (block,) = run.blocks()
    rates_by = lane_rows(run, "ROW_K", at["NX"])
    rates = b.w[at["AT_K"] : at["AT_K"] + at["NX"]]
    return Point(
        rates.copy(), block.y[0].copy(), block.rate[0].copy(), rates_by[:, :n].copy(), block.jacobian[0, :, :n].copy()
    )
