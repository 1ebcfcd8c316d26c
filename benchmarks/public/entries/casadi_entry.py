"""CasADi's entry: multiple shooting with smoothed friction, solved by IPOPT with a Gauss-Newton Hessian.

The model is that of `peers.casadi_peer`: Runge-Kutta steps of a sample, mean voltages over each, a smooth sign of the
friction. The first part of every record but the sweep is used, so that a campaign ends within its CPU time.
"""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from scipy.sparse import bmat, csc_matrix
from scipy.sparse.linalg import splu

from incomplete.stepping import STEPS, edges
from peers.casadi_peer import rates
from peers.problem import PAPER, PARAMETERS, SAMPLE_TIME, Problem, mean_voltages

from ..mechid_benchmark.emission import emission_of
from .task import MOST_CPU_S, Clock, Task, entry_of, read_task

NAME = "CasADi multiple shooting, smoothed friction"
USED_S, INTERVAL, NOISE_NM = 0.3, 50, 2e-3
"""Part of each record; samples of a shooting interval; the sheet's noise, by which residuals are weighted."""
STATES = 8
SCALE = np.array([0.5, 0.5, 0.03, 5.0, 6e-4, 0.1, 0.1, 500.0])
"""Size of each state, in SI units."""
SIZES = np.array([10.0, 0.03, 0.3, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 3e-3, 1500.0, 0.4, 3.0, 5000.0, 0.08])
"""Size of each of `PARAMETERS`, in SI units."""


def enter(folder: Path, work: Path) -> dict[str, Any]:
    """Return the entry of a campaign as a submission holds it."""
    task, clock = read_task(folder), Clock()
    solver = _Shooting(task)
    p, covariance, remark = solver.solve()
    values, half_widths = _asked(task, p, covariance)
    return {
        "parameters": entry_of(values, half_widths, task.names),
        "emission": {name: _emission(p, one) for name, one in task.table["held_out"].items()},
        "cpu_s": clock.seconds,
        "remark": remark,
    }


def _step() -> ca.Function:
    """Return one sample: (state, parameters, voltages) -> (state one sample on, torque)."""
    x, p, u, h = ca.SX.sym("x", STATES), ca.SX.sym("p", len(PARAMETERS)), ca.SX.sym("u", 2), SAMPLE_TIME
    constants = ca.DM(PAPER.constants())
    k1, _ = rates(x, u, p, constants)
    k2, _ = rates(x + h / 2 * k1, u, p, constants)
    k3, _ = rates(x + h / 2 * k2, u, p, constants)
    k4, _ = rates(x + h * k3, u, p, constants)
    after = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return ca.Function("step", [x, p, u], [after, rates(after, u, p, constants)[1]])


def _interval() -> ca.Function:
    """Return a shooting interval: (state, parameters, voltages (2, INTERVAL)) -> (state at its end, torques)."""
    x, p, u = ca.MX.sym("x", STATES), ca.MX.sym("p", len(PARAMETERS)), ca.MX.sym("u", 2, INTERVAL)
    # A loop over one step: written out, its derivatives take longer to build than a solution takes.
    states, torques = _step().mapaccum("steps", INTERVAL)(x, ca.repmat(p, 1, INTERVAL), u)
    return ca.Function("interval", [x, p, u], [states[:, -1], torques.T])


def problem_of(command: Mapping[str, Any], seconds: float) -> Problem:
    """Return a run as the peers take it."""
    times, voltages = edges(command, seconds)
    start = math.radians(command["start_angle_deg"])
    n = STEPS.get(command["stepping"]) or command["microsteps"]
    angles = start + np.arange(len(voltages)) * (0.5 * math.pi / n)
    inside = times < seconds
    samples = round(seconds / SAMPLE_TIME) + 1
    return Problem(
        name="run",
        mechanism=PAPER,
        start_angle=start,
        n_samples=samples,
        edge_times=times[inside],
        edge_angles=angles[: np.count_nonzero(inside) + 1],
    )


class _Shooting:
    """Nonlinear program of a campaign: scaled parameters, then the scaled states at all nodes of all records."""

    def __init__(self, task: Task) -> None:
        self.p = ca.MX.sym("p", len(PARAMETERS))
        parameters = self.p * ca.DM(SIZES)
        interval = _interval()
        unknowns, starts, defects, residuals = [self.p], [_catalogue(task) / SIZES], [], []
        for name, y in task.records.items():
            command = task.table["records"][name]["command"]
            if "rate" not in command:
                continue
            problem = problem_of(command, USED_S)
            nodes = (problem.n_samples - 1) // INTERVAL
            u = mean_voltages(problem).T
            x = ca.MX.sym(name, STATES, nodes)
            states = x * ca.DM(np.tile(SCALE[:, None], nodes))
            ends, torques = interval.map(nodes)(
                states, ca.repmat(parameters, 1, nodes), ca.DM(np.hstack(np.split(u, nodes, axis=1)))
            )
            first = _start(problem, parameters)
            wanted = ca.horzcat(first, ends[:, :-1])
            defects.append(ca.vec((states - wanted) / ca.DM(np.tile(SCALE[:, None], nodes))))
            # Offset and drift are unknowns: taken out of the residual, they would fill the Jacobian.
            line = ca.MX.sym(f"line_{name}", 2)
            time = ca.DM(np.linspace(-1.0, 1.0, problem.n_samples - 1))
            off = ca.vec(torques) - ca.DM(y[1 : problem.n_samples])
            residuals.append(off / NOISE_NM + line[0] + line[1] * time)
            unknowns += [ca.vec(x), line]
            starts += [(_guess(problem) / SCALE[:, None]).ravel(order="F"), np.zeros(2)]
        self.x, self.start = ca.vertcat(*unknowns), np.concatenate(starts)
        self.defects, self.residual = ca.vertcat(*defects), ca.vertcat(*residuals)
        low, high = _bounds(task)
        self.low = np.concatenate([low / SIZES, np.full(self.start.size - low.size, -np.inf)])
        self.high = np.concatenate([high / SIZES, np.full(self.start.size - high.size, np.inf)])

    def solve(self) -> tuple[np.ndarray, np.ndarray | None, str]:
        """Return the parameters, their covariance where the program was solved, and how it ended."""
        J = ca.jacobian(self.residual, self.x)
        H, weight = J.T @ J, ca.MX.sym("weight")
        program = {"x": self.x, "f": 0.5 * ca.dot(self.residual, self.residual), "g": self.defects}
        hessian = ca.Function(
            "nlp_hess_l",
            {"x": self.x, "lam_f": weight, "hess_gamma_x_x": weight * ca.triu(H)},
            ["x", "p", "lam_f", "lam_g"],
            ["hess_gamma_x_x"],
        )
        options = {"max_cpu_time": MOST_CPU_S, "print_level": 0, "max_iter": 500, "tol": 1e-6}
        solver = ca.nlpsol("solver", "ipopt", program, {"hess_lag": hessian, "ipopt": options, "print_time": False})
        found = solver(x0=self.start, lbx=self.low, ubx=self.high, lbg=0.0, ubg=0.0)
        stats = solver.stats()
        x = np.asarray(found["x"]).ravel()
        p = x[: len(PARAMETERS)] * SIZES
        remark = f"{stats['return_status']} after {stats['iter_count']} iterations"
        if not stats["success"]:
            return p, None, f"{remark}; no intervals"
        evaluate = ca.Function("linear", [self.x], [H, ca.jacobian(self.defects, self.x), self.residual])
        return p, _covariance(*(part for part in evaluate(x))), remark


def _covariance(H: ca.DM, A: ca.DM, residual: ca.DM) -> np.ndarray:
    """Return the covariance of the parameters, (P, P), by the inverse of the Karush-Kuhn-Tucker matrix."""
    top, side = csc_matrix(H.sparse()), csc_matrix(A.sparse())
    solve = splu(csc_matrix(bmat([[top, side.T], [side, None]]))).solve
    right = np.zeros((top.shape[0] + side.shape[0], len(PARAMETERS)))
    right[: len(PARAMETERS)] = np.eye(len(PARAMETERS))
    r = np.asarray(residual).ravel()
    inverse = solve(right)[: len(PARAMETERS)]
    return r @ r / (r.size - len(PARAMETERS)) * inverse * np.outer(SIZES, SIZES)


def _start(problem: Problem, p: ca.MX) -> ca.MX:
    """Return the state at rest, currents settled."""
    u, alpha = problem.voltages[0], problem.start_angle / 50.0
    return ca.vertcat(u[0] / p[0], u[1] / p[0], alpha, 0, alpha / 50.0, 0, 0, 0)


def _guess(problem: Problem) -> np.ndarray:
    """Return the states at the nodes, (STATES, nodes), of a rotor that goes as commanded."""
    times = np.arange(0, problem.n_samples - 1, INTERVAL) * SAMPLE_TIME
    held = np.searchsorted(problem.edge_times, times, side="right")
    alpha, zero = problem.edge_angles[held] / 50.0, np.zeros(times.size)
    u = problem.voltages[held] / PAPER.coil_resistance
    return np.stack([u[:, 0], u[:, 1], alpha, zero, alpha / 50.0, zero, zero, zero])


def _catalogue(task: Task) -> np.ndarray:
    """Return the catalogue values of `PARAMETERS`."""
    table = dict(zip(task.names, task.catalogue, strict=True))
    return np.array([_coordinate(table, name) for name in PARAMETERS])


def _coordinate(table: Mapping[str, float], name: str) -> float:
    detent, _, part = name.rpartition(".")
    if part not in ("cos", "sin"):
        return table[name]
    phase = math.radians(table[f"{detent}.phase_deg"])
    return table[f"{detent}.amplitude"] * (math.cos(phase) if part == "cos" else math.sin(phase))


def _bounds(task: Task) -> tuple[np.ndarray, np.ndarray]:
    """Return the bounds of `PARAMETERS`; a detent's coordinates are within its largest amplitude, either way."""
    high, low = (dict(zip(task.names, ends, strict=True)) for ends in (task.high, task.low))
    lows, highs = [], []
    for name in PARAMETERS:
        detent, _, part = name.rpartition(".")
        largest = high.get(f"{detent}.amplitude")
        lows.append(-largest if part in ("cos", "sin") else low[name])
        highs.append(largest if part in ("cos", "sin") else high[name])
    return np.array(lows), np.array(highs)


def _asked(task: Task, p: np.ndarray, covariance: np.ndarray | None) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the asked parameters and half-widths of their 95 % intervals, by the delta method for the detents."""
    at = {name: k for k, name in enumerate(PARAMETERS)}
    values, slopes = np.empty(len(task.names)), np.zeros((len(task.names), p.size))
    for row, name in enumerate(task.names):
        detent, _, part = name.rpartition(".")
        if name in at:
            values[row], slopes[row, at[name]] = p[at[name]], 1.0
            continue
        both = [at[f"{detent}.cos"], at[f"{detent}.sin"]]
        c, s = p[both]
        size = math.hypot(c, s)
        if part == "amplitude":
            values[row], slopes[row, both] = size, np.array([c, s]) / size
        else:
            values[row], slopes[row, both] = math.degrees(math.atan2(s, c)), np.degrees([-s, c]) / size**2
    if covariance is None:
        return values, None
    variance = np.einsum("ij,jk,ik->i", slopes, covariance, slopes)
    return values, 1.96 * np.sqrt(np.where(variance > 0.0, variance, np.inf))


def _emission(p: np.ndarray, one: Mapping[str, Any]) -> dict[str, Any]:
    """Return the emission of a held-out run by the same model."""
    problem = problem_of(one["command"], one["seconds"])
    step = _step()
    u = mean_voltages(problem).T
    first = np.asarray(ca.evalf(_start(problem, ca.DM(p)))).ravel()
    _, torque = step.mapaccum("run", u.shape[1])(first, ca.repmat(ca.DM(p), 1, u.shape[1]), u)
    return emission_of(np.append(0.0, np.asarray(torque).ravel()), one["command"]["rate"])
