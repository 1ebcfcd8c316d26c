"""heyoka: Taylor series, begun anew at each step edge; one trajectory or eight in the lanes of one integrator."""

from __future__ import annotations

import heyoka as hy
import numpy as np

from .mechid_batch import SETS, moves
from .problem import Output, Run
from .sliding import COEFFICIENTS, IN_RATES, OMEGA, STATES, Window, rates, torque


def prepare(window: Window, *, tolerance: float, batch: bool) -> Run:
    """Return the run over the window; where there are eight sets the first is the problem's and gives the torque.

    From edge to edge there is one call from Python, which also gives the samples between.
    """
    x = hy.make_vars(*STATES)
    c = {name: hy.par[2 + k] for k, name in enumerate(IN_RATES)}
    system = list(zip(x, rates(x, (hy.par[0], hy.par[1]), c, hy.sin, hy.cos), strict=True))
    sets = SETS if batch else 1
    values = [
        list(window.coefficients(p).values()) for p in window.problem.mechanism.estimated() + moves(window.problem)
    ]
    start, parameters = np.tile(window.start[:, None], sets), np.zeros((2 + len(c), sets))
    parameters[2:] = np.array(values[:sets])[:, : len(c)].T
    if not batch:
        start, parameters = start[:, 0], parameters[:, 0]
    solver = hy.taylor_adaptive_batch if batch else hy.taylor_adaptive
    integrator = solver(system, start.copy(), pars=parameters.copy(), tol=tolerance)
    grids = [grid if not batch else np.tile(grid[:, None], sets) for grid in window.grids]
    kept = window.kept
    nominal = dict(zip(COEFFICIENTS, values[0], strict=True))

    def run() -> Output:
        _restart(integrator, start, window.samples[0])
        found = [start[None]]
        for grid, u in zip(grids, window.voltages, strict=True):
            integrator.pars[:2] = u[:, None] if batch else u
            found.append(integrator.propagate_grid(grid)[-1][1:])
        states = np.concatenate(found)[kept]
        window.checked(states[:, OMEGA])
        return Output(torque(states[..., 0].T if batch else states.T, nominal), window.first)

    return run


def _restart(integrator: object, start: np.ndarray, time: float) -> None:
    integrator.state[:] = start
    if start.ndim > 1:
        integrator.set_time(np.full(start.shape[1], time))
    else:
        integrator.time = time
