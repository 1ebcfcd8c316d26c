"""CasADi: a Runge-Kutta step, mapaccumulated over the samples, as generated and compiled C.

The fixed step of 0.1 ms knows neither step edges nor switches: the voltage is its mean over the
sample, and friction is smoothed. The two widths of the smoothing were chosen for the least RMS error
against the truth that stays stable. Sensitivities are CasADi's forward mode through the step.
"""

from __future__ import annotations

import subprocess
import tempfile
from functools import cache
from pathlib import Path

import casadi as ca
import numpy as np

from .problem import PARAMETERS, SAMPLE_TIME, Output, Problem, Run, mean_voltages, start_state

NAME = "CasADi, generated C"
REMARK = "RK4 at 0.1 ms on 8 states, mean voltage over the sample, smoothed friction; 5 s a call"

BLOCK = 50_000
"""Samples a call of the compiled function."""

SMOOTHING = 0.2
"""Speed, in rad/s, over which the sign of the friction turns."""

STRIBECK_SPEED = 1.0
"""Speed, in rad/s, over which static friction falls to Coulomb friction."""

COMPILE = ("gcc", "-O3", "-march=native", "-shared", "-fPIC")
STATES = 8


def prepare(problem: Problem, *, jacobian: bool, keep_jacobian: bool = False) -> Run:
    """Return the run over the whole record, block by block; the Jacobian is kept if asked for."""
    step = _compiled(jacobian)
    n_steps = problem.n_samples - 1
    padded = np.zeros((2, -(-n_steps // BLOCK) * BLOCK))
    padded[:, :n_steps] = mean_voltages(problem).T

    def run() -> Output:
        state = _start(problem, jacobian)
        outputs = [np.zeros((1 + jacobian * len(PARAMETERS), 1))]
        for first in range(0, n_steps, BLOCK):
            states, block = step(state, padded[:, first : first + BLOCK])
            state = states[:, -1]
            outputs.append(np.asarray(block if keep_jacobian else block[0, :]))
        if keep_jacobian:
            rows = np.hstack(outputs)[:, : n_steps + 1]
            return Output(rows[0], jacobian=rows[1:].T)
        return Output(np.hstack([block[0] for block in outputs])[: n_steps + 1])

    return run


def _start(problem: Problem, jacobian: bool) -> np.ndarray:
    """State, parameters, constants and, with `jacobian`, sensitivities (column by column)."""
    state = start_state(problem)
    values = [state, problem.mechanism.estimated(), problem.mechanism.constants()]
    if jacobian:
        S = np.zeros((STATES, len(PARAMETERS)))
        S[:2, 0] = -state[:2] / problem.mechanism.coil_resistance
        values.append(S.ravel(order="F"))
    return np.concatenate(values)


def rates(x: ca.SX, u: ca.SX, p: ca.SX, constants: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return dx/dt and the measured torque y."""
    i_A, i_B, alpha, omega, alpha_g, omega_g, z, z_dot = ca.vertsplit(x)
    R, L, k, T_frs, d1c, d1s, d2c, d2s, T_frd, T_visc, K_s, D, K_res, w0, zeta = ca.vertsplit(p)
    n, J_rot, G, J_m = ca.vertsplit(constants)
    s, c = ca.sin(n * alpha), ca.cos(n * alpha)
    s2, c2 = 2 * s * c, 1 - 2 * s * s
    T_D = d1c * 2 * s2 * c2 + d1s * (1 - 2 * s2 * s2) + d2c * s2 + d2s * c2
    T_rg = (K_s * (alpha - G * alpha_g) + D * (omega - G * omega_g)) / G**2
    dry = T_frd + (T_frs - T_frd) * ca.exp(-((omega / STRIBECK_SPEED) ** 2))
    T_fr = dry * ca.tanh(omega / SMOOTHING) + T_visc * omega
    T_res = k * (i_A * s + i_B * c) - T_D - T_fr - T_rg
    rates = ca.vertcat(
        (u[0] - R * i_A - k * omega * s) / L,
        (u[1] - R * i_B - k * omega * c) / L,
        omega,
        T_res / J_rot,
        omega_g,
        G * T_rg / J_m,
        z_dot,
        w0**2 * (K_res * T_res - z) - 2 * zeta * w0 * z_dot,
    )
    return rates, -(z + G * T_rg)


def _step(jacobian: bool) -> ca.Function:
    """One sample: (state and what stays with it, voltages) -> (the same one sample on, [y, dy/dp])."""
    x, p = ca.SX.sym("x", STATES), ca.SX.sym("p", len(PARAMETERS))
    u, constants, h = ca.SX.sym("u", 2), ca.SX.sym("constants", 4), SAMPLE_TIME
    k1, _ = rates(x, u, p, constants)
    k2, _ = rates(x + h / 2 * k1, u, p, constants)
    k3, _ = rates(x + h / 2 * k2, u, p, constants)
    k4, _ = rates(x + h * k3, u, p, constants)
    after = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    _, y = rates(after, u, p, constants)
    carried, output = [x, p, constants], [y]
    result = [after, p, constants]
    if jacobian:
        S = ca.SX.sym("S", STATES, len(PARAMETERS))
        seeds = ca.vertcat(S, ca.SX.eye(len(PARAMETERS)))
        both = ca.jtimes(ca.vertcat(after, y), ca.vertcat(x, p), ca.densify(seeds))
        carried.append(ca.vec(S))
        result.append(ca.vec(both[:STATES, :]))
        output.append(both[STATES, :].T)
    outputs = ca.cse([ca.vertcat(*result), ca.vertcat(*output)])
    return ca.Function("step", [ca.vertcat(*carried), u], outputs)


@cache
def _compiled(jacobian: bool) -> ca.Function:
    accumulated = _step(jacobian).mapaccum("sweep", BLOCK)
    with tempfile.TemporaryDirectory() as folder:
        generator = ca.CodeGenerator("sweep.c")
        generator.add(accumulated)
        generator.generate(f"{folder}/")
        target = Path(folder) / "sweep.so"
        source = str(target.with_suffix(".c"))
        subprocess.run([*COMPILE, "-o", str(target), source, "-lm"], check=True)
        return ca.external("sweep", str(target))
