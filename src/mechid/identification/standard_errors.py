"""Standard errors in the file's coordinates: colour, priors, held parameters, and where they are local only."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from mechid.identification.draws import Departure, departures, told_by
from mechid.identification.ending import Ending, Frozen
from mechid.identification.problem import Problem
from mechid.identification.reduction import Triangle
from mechid.identification.space import SearchSpace
from mechid.identification.uncertainty import uncertainty
from mechid.identification.verdict import Verdict

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class StandardErrors:
    """Covariances of the free parameters, and those whose standard error is local only, with where.

    Attributes
    ----------
    names : tuple of str, (n,)
    robust, white : (n, n)
        In the file's coordinates and units.
    local_only : dict of str to str
    warnings : tuple of str
    """

    names: tuple[str, ...] = ()
    robust: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    white: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    local_only: dict[str, str] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def of(self, name: str) -> tuple[float | None, float | None]:
        """Return the standard error of a parameter, robust and white, or None twice."""
        if name not in self.names:
            return None, None
        i = self.names.index(name)
        return math.sqrt(self.robust[i, i]), math.sqrt(self.white[i, i])

    @property
    def correlation(self) -> FloatArray:
        """Correlation matrix, (n, n)."""
        scale = np.sqrt(np.diag(self.robust))
        scale[scale == 0.0] = 1.0
        return np.asarray(self.robust / np.outer(scale, scale), dtype=np.float64)


def standard_errors(ending: Ending, triangle: Triangle, verdict: Verdict) -> StandardErrors:
    """Return the standard errors at the point of a verdict.

    Those of a fit that is not good are not tested by draws.
    """
    problem, q = ending.problem, verdict.q
    if not verdict.counted.any() or not np.isfinite(triangle.norm):
        return StandardErrors()
    every, slopes = file_slopes(problem, q)
    kept = [i for i, name in enumerate(every) if name not in verdict.reasons]
    found = uncertainty(problem, q, ending.windows, triangle, verdict.counted)
    considered = _considered(ending, q, found.white)
    robust, white = found.robust + considered, found.white + considered
    maps = slopes[kept]
    local = departures(problem, q, ending.windows, robust, ending.seed) if ending.outcome.good else []
    return StandardErrors(
        names=tuple(every[i] for i in kept),
        robust=maps @ robust @ maps.T,
        white=maps @ white @ maps.T,
        local_only=_concerned(ending, q, verdict, local),
        warnings=tuple(map(_warning, local)),
    )


def file_slopes(problem: Problem, q: FloatArray) -> tuple[tuple[str, ...], FloatArray]:
    """Return the names of all free parameters, (m,), and d(value)/dq, (m, n), time offsets included."""
    names, slopes = problem.space.value_jacobian(q[: problem.space.size])
    delays = tuple(f"record.{name}.time_offset_s" for name in problem.delayed_targets)
    whole = np.zeros((len(names) + len(delays), problem.size))
    whole[: len(names), : problem.space.size] = slopes
    whole[len(names) :, problem.space.size :] = np.eye(len(delays))
    return (*names, *delays), whole


def _considered(ending: Ending, q: FloatArray, white: FloatArray) -> FloatArray:
    """Return what the uncertainty of held parameters adds to the covariance, in search coordinates.

    Consider covariance: an error c of a held parameter moves the estimate by -P J^T J_c c.
    """
    total = np.zeros_like(white)
    for held in ending.frozen:
        if held.sigma:
            moved = white @ _pull(ending, q, held) * held.sigma
            total += np.outer(moved, moved)
    return total


def _pull(ending: Ending, q: FloatArray, held: Frozen) -> FloatArray:
    """Return J^T J_c, (n,), with J_c the derivative to the held parameter in its own unit."""
    problem = ending.problem
    mechanism = problem.space.at(q[: problem.space.size])
    pairs = {name: p.amplitude for p in mechanism.plant.polar_pairs for name in (p.amplitude, p.phase)}
    polar = problem.space.polar | ({pairs[held.name]} if held.name in pairs else frozenset())
    free = (*(p.name for p in mechanism.free), held.name)
    wider = replace(problem, space=SearchSpace(mechanism.with_free(free), polar))
    here = np.concatenate([wider.space.start, q[problem.space.size :]])
    J = wider.joint(here, ending.windows).jacobian
    own = wider.names.index(held.name)
    names, slopes = file_slopes(wider, here)
    per_unit = J[:, own] / slopes[names.index(held.name), own]
    return np.asarray(np.delete(J, own, axis=1).T @ per_unit, dtype=np.float64)


def _concerned(ending: Ending, q: FloatArray, verdict: Verdict, local: list[Departure]) -> dict[str, str]:
    if not local:
        return {}
    names = told_by(ending.problem, q, ending.windows, [d.record for d in local], verdict.counted)
    where = "; ".join(map(str, local))
    return dict.fromkeys(names, f"local only: a stick/slip may fall the other way within the error: {where}")


def _warning(departure: Departure) -> str:
    return (
        f"{departure}: the cost departs from what its derivatives say in {departure.draws} of 30 draws from the "
        f"covariance, by up to {departure.excess:.3g}: a stick/slip hangs by a thread there, and the standard errors "
        "that rest on this record are local only; see `mechid profile` and `mechid bootstrap`"
    )
