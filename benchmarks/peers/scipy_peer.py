"""SciPy's `solve_ivp`, split at every step edge and at every switch of the friction.

Written apart from the other peers, in the paper's own eight states, so that it also serves as the
check of the truth (`bench_sweep.py` prints it). The right-hand side is compiled by Numba. The
Jacobian is by forward differences, one run more for each parameter.
"""

from __future__ import annotations

from functools import partial
from itertools import pairwise

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from . import reference_c
from .problem import SAMPLE_TIME, Output, Problem, Run, first_seconds, start_state

NAME = "SciPy LSODA, Numba right-hand side"
REMARK = "rtol 1e-6, split at edges and switches; forward differences; on the window 29.5 s to 30.5 s"

R, L, K_M, T_FRS, D1C, D1S, D2C, D2S, T_FRD, T_VISC, K_S, D, K_RES, W0, ZETA = range(15)
HALF_POLES, J_ROT, RATIO, J_M = range(4)

WINDOW = (295_000, 305_000)
"""First and last sample of the window: there the edges come at their mean rate, 960 a second."""

SCALE = np.array([0.5, 0.5, 0.03, 5.0, 6e-4, 0.1, 0.1, 500.0])
"""Size of each state, in SI units; the absolute tolerance is the relative one times this."""

DIFFERENCE = 1e-4
"""Step of the forward differences, relative to the parameter."""

SHORTEST = 1e-13
"""Shortest piece that is integrated, in s."""


def prepare(problem: Problem, *, jacobian: bool, keep_jacobian: bool = False) -> Run:
    """Return the run over the window, from the state that the C loop has at its start."""
    first, last = WINDOW
    before = reference_c.simulate(first_seconds(problem, first * SAMPLE_TIME), n_substeps=4)
    estimated = problem.mechanism.estimated()
    window = partial(integrate, problem, state=before.final, mode=before.mode, first=first, last=last)

    def run() -> Output:
        torque = window(estimated)
        if not jacobian:
            return Output(torque, first)
        rows = np.empty((len(torque), len(estimated)))
        for column, value in enumerate(estimated):
            moved = estimated.copy()
            moved[column] += DIFFERENCE * value
            rows[:, column] = (window(moved) - torque) / (DIFFERENCE * value)
        return Output(torque, first)  # the window's start is held: no column of the whole record

    return run


def from_the_start(problem: Problem, *, method: str, rtol: float) -> np.ndarray:
    """Return y at all samples of `problem`, shape (n_samples,)."""
    state, estimated = start_state(problem), problem.mechanism.estimated()
    mode = _mode_after(1, state, estimated, problem.mechanism.constants())
    last = problem.n_samples - 1
    return integrate(problem, estimated, state=state, mode=mode, first=0, last=last, method=method, rtol=rtol)


def integrate(
    problem: Problem,
    estimated: np.ndarray,
    *,
    state: np.ndarray,
    mode: int,
    first: int,
    last: int,
    method: str = "LSODA",
    rtol: float = 1e-6,
) -> np.ndarray:
    """Return y at the samples `first` to `last`, shape (last - first + 1,).

    Parameters
    ----------
    problem : Problem
        The record.
    estimated : numpy.ndarray
        Values of `problem.PARAMETERS`, shape (15,).
    state : numpy.ndarray
        i_A, i_B, alpha, omega, alpha_g, omega_g, z, z' at the first sample, shape (8,).
    mode : int
        Sign of the rotor's speed there, 0 where it sticks.
    first, last : int
        Indices of the samples.
    method, rtol : str, float
        As for `scipy.integrate.solve_ivp`.
    """
    constants = problem.mechanism.constants()
    samples = np.arange(first, last + 1) * SAMPLE_TIME
    inside = (problem.edge_times > samples[0]) & (problem.edge_times < samples[-1])
    borders = [samples[0], *problem.edge_times[inside], samples[-1]]
    held = int(np.searchsorted(problem.edge_times, samples[0], side="right"))
    states = [state[:, None]]
    for piece, (start, stop) in enumerate(pairwise(borders)):
        wanted = samples[(samples > start) & (samples <= stop)]
        voltages = problem.voltages[held + piece]
        args = (voltages, estimated, constants)
        state, mode, found = _held(args, state, mode, start, stop, wanted, method, rtol)
        states.append(found)
    return _torque(np.hstack(states), estimated, constants)


def _held(
    args: tuple[np.ndarray, ...],
    state: np.ndarray,
    mode: int,
    start: float,
    stop: float,
    wanted: np.ndarray,
    method: str,
    rtol: float,
) -> tuple[np.ndarray, int, np.ndarray]:
    """Integrate while the voltage is held; return the last state, its mode, and those wanted."""
    found = []
    while stop - start > SHORTEST:
        left = wanted[wanted > start]
        options = {
            "method": method,
            "rtol": rtol,
            "atol": rtol * SCALE,
            "args": (float(mode), *args),
            "t_eval": np.union1d(left, stop),
        }
        piece = solve_ivp(_rates, (start, stop), state, **options)
        guard = [_switch(stop, x, *options["args"]) for x in piece.y.T]
        if min(guard) < 0.0:  # only then the events, which cost as much again
            piece = solve_ivp(_rates, (start, stop), state, events=_switch, **options)
        found.append(np.reshape(piece.y, (len(state), -1))[:, : len(left)])
        if piece.status == 1:
            start, state = piece.t_events[0][0], piece.y_events[0][0]
            state[3] = 0.0
            mode = _mode_after(mode, state, args[1], args[2])
        else:
            start, state = stop, piece.y[:, -1]
    return state, mode, np.hstack(found)


def _mode_after(mode: int, state: np.ndarray, p: np.ndarray, constants: np.ndarray) -> int:
    tau = _drive(state, p, constants)
    return 0 if mode != 0 and abs(tau) <= p[T_FRS] else int(np.sign(tau))


def _switch(t: float, x: np.ndarray, mode: float, u, p, constants) -> float:
    if mode != 0.0:
        return mode * x[3]
    return p[T_FRS] - abs(_drive(x, p, constants))


_switch.terminal = True
_switch.direction = -1.0


@njit
def _drive(x, p, constants):
    """Torque on the rotor before friction, T_mot - T_rg, in N m."""
    angle = constants[HALF_POLES] * x[2]
    T_AB = p[K_M] * (x[0] * np.sin(angle) + x[1] * np.cos(angle))
    T_D = p[D1C] * np.sin(4 * angle) + p[D1S] * np.cos(4 * angle)
    T_D += p[D2C] * np.sin(2 * angle) + p[D2S] * np.cos(2 * angle)
    return T_AB - T_D - _gear(x, p, constants)


@njit
def _gear(x, p, constants):
    """Torque of the gear on the rotor, T_rg, in N m."""
    G = constants[RATIO]
    return (p[K_S] * (x[2] - G * x[4]) + p[D] * (x[3] - G * x[5])) / G**2


@njit
def _rates(t, x, mode, u, p, constants):
    angle = constants[HALF_POLES] * x[2]
    T_res = 0.0
    if mode != 0.0:
        T_res = _drive(x, p, constants) - mode * p[T_FRD] - p[T_VISC] * x[3]
    rates = np.empty(8)
    rates[0] = (u[0] - p[R] * x[0] - p[K_M] * x[3] * np.sin(angle)) / p[L]
    rates[1] = (u[1] - p[R] * x[1] - p[K_M] * x[3] * np.cos(angle)) / p[L]
    rates[2] = x[3] if mode != 0.0 else 0.0
    rates[3] = T_res / constants[J_ROT]
    rates[4] = x[5]
    rates[5] = constants[RATIO] * _gear(x, p, constants) / constants[J_M]
    rates[6] = x[7]
    rates[7] = p[W0] ** 2 * (p[K_RES] * T_res - x[6]) - 2 * p[ZETA] * p[W0] * x[7]
    return rates


def _torque(x: np.ndarray, p: np.ndarray, constants: np.ndarray) -> np.ndarray:
    G = constants[RATIO]
    return -(x[6] + (p[K_S] * (x[2] - G * x[4]) + p[D] * (x[3] - G * x[5])) / G)
