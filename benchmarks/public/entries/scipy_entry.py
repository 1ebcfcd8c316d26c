"""SciPy's entry: `least_squares` from the catalogue on all records, forward differences, nothing else.

It is given the generator's own equations, stick and slip located as there, so that what it loses is lost by the search.
"""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from ..maker.campaigns import values_of
from ..maker.runs import Run, torque_of
from ..mechid_benchmark.emission import emission_of
from .task import Clock, Task, TimeSpentError, entry_of, half_widths_of, read_task, without_line

NAME = "SciPy least squares from the catalogue"
DIFFERENCE = 1e-5
"""Step of the forward differences, as a share of the range between the bounds."""


class Residual:
    """Residual of all records over the scaled parameters, its Jacobian, and the best point so far."""

    def __init__(self, task: Task, clock: Clock) -> None:
        self.task, self.clock = task, clock
        self.best: tuple[float, np.ndarray] = (np.inf, self.scaled(task.catalogue))

    def scaled(self, values: np.ndarray) -> np.ndarray:
        """Return parameters over the range between their bounds, (P,)."""
        return (values - self.task.low) / (self.task.high - self.task.low)

    def values(self, u: np.ndarray) -> np.ndarray:
        """Return the parameters of a scaled point, (P,)."""
        values = self.task.low + u * (self.task.high - self.task.low)
        # Where the friction at rest is the smaller one, a rotor that sticks and slips at once is bisected without end.
        static, coulomb = (self.task.names.index(f"friction.{name}") for name in ("static", "coulomb"))
        values[static] = max(values[static], values[coulomb])
        return values

    def __call__(self, u: np.ndarray) -> np.ndarray:
        """Return the residual, (N,) N m, offset and drift of each record taken out."""
        self.clock.check()
        v = values_of(dict(zip(self.task.names, self.values(u), strict=True)), {})
        parts = []
        for name, y in self.task.records.items():
            one = self.task.table["records"][name]
            parts.append(without_line(torque_of(v, Run(one["command"], one["seconds"])) - y))
        residual = np.concatenate(parts)
        residual = np.where(np.isfinite(residual), residual, 1e3)
        cost = float(residual @ residual)
        if cost < self.best[0]:
            self.best = cost, u.copy()
        return residual

    def jacobian(self, u: np.ndarray) -> np.ndarray:
        """Return the residual's derivatives by the scaled parameters, (N, P)."""
        here, columns = self(u), []
        for k in range(u.size):
            step = DIFFERENCE if u[k] + DIFFERENCE < 1.0 else -DIFFERENCE
            moved = u.copy()
            moved[k] += step
            columns.append((self(moved) - here) / step)
        return np.stack(columns, axis=1)


def enter(folder: Path, work: Path) -> dict[str, Any]:
    """Return the entry of a campaign as a submission holds it."""
    task, clock = read_task(folder), Clock()
    residual = Residual(task, clock)
    start = np.clip(residual.scaled(task.catalogue), 1e-6, 1.0 - 1e-6)
    widths = None
    try:
        found = least_squares(residual, start, jac=residual.jacobian, bounds=(0.0, 1.0), x_scale="jac")
        u, remark = found.x, f"ended after {found.nfev} steps"
        half = half_widths_of(found.jac, found.fun)
        widths = None if half is None else half * (task.high - task.low)
    except TimeSpentError:
        u, remark = residual.best[1], "stopped by its CPU time; no intervals"
    seconds, values = clock.seconds, residual.values(u)
    v = values_of(dict(zip(task.names, values, strict=True)), {})
    predicted = partial(_emission, v)
    return {
        "parameters": entry_of(values, widths, task.names),
        "emission": {name: predicted(one) for name, one in task.table["held_out"].items()},
        "cpu_s": seconds,
        "remark": remark,
    }


def _emission(v, one) -> dict[str, Any]:
    return emission_of(torque_of(v, Run(one["command"], one["seconds"])), one["command"]["rate"])
