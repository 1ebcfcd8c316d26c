"""Grazing switches: stick/slip whose instant is too uncertain to be sure of its order among its neighbours.

Where the standard deviation of a switch's instant, carried over from the covariance of the estimate by the
derivative of the instant, is above a tenth of the gap to the neighbouring switch, another order of stick and slip
lies within the errors, and derivatives know nothing of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.target import Target
from mechid.identification.uncertainty.settings import ERRORS


@dataclass(frozen=True)
class Grazing:
    """The grazing switches of a record: how many, and the worst with its instant in s of record time.

    `spread_s` is the standard deviation of the worst one's instant, `gap_s` the distance to its neighbour.
    """

    record: str
    count: int
    of: int
    instant_s: float
    spread_s: float
    gap_s: float

    def __str__(self) -> str:
        """Say it as a warning."""
        more = f"; {self.count} of its {self.of} switches are such" if self.count > 1 else ""
        return (
            f"record {self.record} at {self.instant_s:.6g} s: the instant of a stick/slip is known to "
            f"{self.spread_s:.2g} s only, and the next switch is {self.gap_s:.2g} s away: which comes first is not "
            f"certain{more}"
        )


def grazing_switches(problem: Problem, q: FloatArray, windows: Windows, covariance: FloatArray) -> list[Grazing]:
    """Return the grazing switches of each record that has any.

    Parameters
    ----------
    problem : Problem
    q : (n,)
        The estimate.
    windows : mapping of record to (first, stop)
    covariance : (n, n)
        In search coordinates.
    """
    found = (_of(problem, t, q, windows[t.name][1], covariance) for t in problem.targets if t.name in windows)
    return [g for g in found if g]


def _of(problem: Problem, target: Target, q: FloatArray, stop: int, covariance: FloatArray) -> Grazing | None:
    run = problem.model.run(target, q, stop, jacobian=True, events=ERRORS.most_switches)
    for _ in run.blocks():
        pass
    log, moved = run.switching, problem.space.size
    if log.time.size < 2 or not moved:
        return None
    S = log.sensitivity[:, :moved]
    spread = np.sqrt(np.einsum("ij,jk,ik->i", S, covariance[:moved, :moved], S).clip(min=0.0))
    gaps = np.diff(log.time, prepend=-np.inf, append=np.inf)
    gap = np.minimum(gaps[:-1], gaps[1:])
    share = spread / np.maximum(gap, np.finfo(float).tiny)
    grazes = ~(share <= ERRORS.share_of_gap)
    if not grazes.any():
        return None
    worst = int(np.argmax(np.where(grazes, np.nan_to_num(share, nan=np.inf), 0.0)))
    at = problem.coordinates.timing(target, q).record_s(float(log.time[worst]))
    return Grazing(target.name, int(grazes.sum()), log.time.size, at, float(spread[worst]), float(gap[worst]))
