"""CasADi from step edge to step edge in the window: its Runge-Kutta step as generated C, and CVODES."""

from __future__ import annotations

import subprocess
import tempfile
from pathlib import Path

import casadi as ca
import numpy as np

from .casadi_peer import COMPILE
from .problem import Output, Run
from .sliding import IN_RATES, OMEGA, STATES, Window, rates, torque


def prepare_steps(window: Window, *, substeps: int) -> Run:
    """Return the run by RK4, mapaccumulated over the pieces between samples and edges, so many steps each."""
    lengths = np.diff(window.times)
    sweep = _compiled(substeps, len(lengths), window)
    held, given = np.vstack([_held(window), lengths]), _values(window)

    def run() -> Output:
        y, omega = (np.asarray(row)[0, window.kept] for row in sweep(window.start, held, given))
        window.checked(omega)
        return Output(y, window.first)

    return run


def prepare_cvodes(window: Window, *, tolerance: float) -> Run:
    """Return the run by CVODES (BDF, Newton), begun anew where the voltages change."""
    x, u, c = _symbols()
    system = {"x": x, "u": u, "p": c, "ode": _rates(x, u, c)}
    options = {
        "reltol": tolerance,
        "abstol": tolerance,
        "max_num_steps": 1_000_000,
        "jit": True,
        "jit_options": {"flags": ["-O3", "-march=native"], "compiler": "gcc"},
        "compiler": "shell",
    }
    times = window.times - window.times[0]
    options["jit_options"]["directory"] = f"{tempfile.gettempdir()}/"
    solve = ca.integrator("sweep", "cvodes", system, 0.0, times[1:], options)
    held, given = _held(window), _values(window)

    def run() -> Output:
        states = np.asarray(solve(x0=window.start, u=held, p=given)["xf"])
        return _output(window, np.hstack([window.start[:, None], states]))

    return run


def _symbols() -> tuple[ca.SX, ca.SX, ca.SX]:
    return ca.SX.sym("x", len(STATES)), ca.SX.sym("u", 2), ca.SX.sym("c", len(IN_RATES))


def _rates(x: ca.SX, u: ca.SX, c: ca.SX) -> ca.SX:
    named = dict(zip(IN_RATES, ca.vertsplit(c), strict=True))
    return ca.vertcat(*rates(ca.vertsplit(x), ca.vertsplit(u), named, ca.sin, ca.cos))


def _held(window: Window) -> np.ndarray:
    """Return the voltages of each piece between two of the window's times, (2, n)."""
    return np.repeat(window.voltages, [len(grid) - 1 for grid in window.grids], axis=0).T


def _values(window: Window) -> np.ndarray:
    named = window.coefficients(window.problem.mechanism.estimated())
    return np.array([named[name] for name in IN_RATES])


def _output(window: Window, states: np.ndarray) -> Output:
    named = window.coefficients(window.problem.mechanism.estimated())
    at_samples = states[:, window.kept]
    window.checked(at_samples[OMEGA])
    return Output(torque(at_samples, named), window.first)


def _compiled(substeps: int, pieces: int, window: Window) -> ca.Function:
    x, u, c = _symbols()
    length, after = ca.SX.sym("length"), x
    h = length / substeps
    for _ in range(substeps):
        k1 = _rates(after, u, c)
        k2 = _rates(after + h / 2 * k1, u, c)
        k3 = _rates(after + h / 2 * k2, u, c)
        k4 = _rates(after + h * k3, u, c)
        after += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    carried = ca.vertcat(after, c)
    step = ca.Function("step", [ca.vertcat(x, c), ca.vertcat(u, length)], [ca.cse(carried)])
    start, held, given = (
        ca.MX.sym("start", len(STATES)),
        ca.MX.sym("held", 3, pieces),
        ca.MX.sym("given", len(IN_RATES)),
    )
    states = ca.horzcat(start, step.mapaccum("states", pieces)(ca.vertcat(start, given), held)[: len(STATES), :])
    y = torque(ca.vertsplit(states), window.coefficients(window.problem.mechanism.estimated()))
    whole = ca.Function("pieces", [start, held, given], [y, states[OMEGA, :]])
    with tempfile.TemporaryDirectory() as folder:
        generator = ca.CodeGenerator("pieces.c")
        generator.add(whole)
        generator.generate(f"{folder}/")
        target = Path(folder) / "pieces.so"
        subprocess.run([*COMPILE, "-o", str(target), str(target.with_suffix(".c")), "-lm"], check=True)
        return ca.external("pieces", str(target))
