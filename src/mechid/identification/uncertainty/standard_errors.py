"""Standard errors in the file's coordinates: colour, priors, held parameters, and where they are local only."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mechid.identification.identifiability.verdict import Verdict
from mechid.identification.output_error.reduction import Triangle, combined
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.doubts import SINGULAR
from mechid.identification.uncertainty.consider import consider_covariance
from mechid.identification.uncertainty.covariance import uncertainty
from mechid.identification.uncertainty.draws import Departure, departures, told_by
from mechid.identification.uncertainty.grazing import grazing_switches

FloatArray = NDArray[np.float64]
UNSEEN_SHARE = 1e-4
"""Share of a parameter in a direction that no record sees, below which it is rounding."""


@dataclass(frozen=True)
class StandardErrors:
    """Covariances of the free parameters, and those whose standard error is local only, with where.

    Attributes
    ----------
    names : tuple of str, (n,)
    robust, white : (n, n)
        In the file's coordinates and units.
    without_priors : (n,)
        White standard errors of the records alone; empty where no prior counts.
    local_only : dict of str to str
    warnings : tuple of str
    """

    names: tuple[str, ...] = ()
    robust: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    white: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    without_priors: FloatArray = field(default_factory=lambda: np.zeros(0))
    local_only: dict[str, str] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def of(self, name: str) -> tuple[float | None, float | None]:
        """Return the standard error of a parameter, robust and white, or None twice."""
        if name not in self.names:
            return None, None
        i = self.names.index(name)
        return _root(self.robust[i, i]), _root(self.white[i, i])

    def of_records_alone(self, name: str) -> float | None:
        """Return the white standard error of a parameter without any prior, None where no prior counts."""
        if name not in self.names or not self.without_priors.size:
            return None
        return float(self.without_priors[self.names.index(name)])

    @property
    def correlation(self) -> FloatArray:
        """Correlation matrix, (n, n)."""
        scale = np.sqrt(np.maximum(np.diag(self.robust), 0.0))
        scale[scale == 0.0] = 1.0
        return np.asarray(self.robust / np.outer(scale, scale), dtype=np.float64)


def standard_errors(state: SearchState, seed: int, triangle: Triangle, verdict: Verdict) -> StandardErrors:
    """Return the standard errors at the point of a verdict; `seed` is that of the draws.

    Those of a fit that is not good are not tested by draws. Draws leave held parameters where they are held.
    """
    problem, q = state.problem, verdict.q
    if not verdict.counted.any() or not np.isfinite(triangle.norm):
        return StandardErrors()
    every, slopes = problem.coordinates.value_slopes(q)
    kept = [i for i, name in enumerate(every) if name not in verdict.reasons]
    maps, windows = slopes[kept], state.windows
    names = tuple(every[i] for i in kept)
    found = uncertainty(problem, q, windows, triangle, verdict.counted)
    white = maps @ found.white @ maps.T
    considered = consider_covariance(problem, q, windows, state.frozen, names, white)
    local = departures(problem, q, windows, found.robust, seed) if state.outcome.good else []
    grazing = grazing_switches(problem, q, windows, found.robust)
    return StandardErrors(
        names=names,
        robust=maps @ found.robust @ maps.T + considered,
        white=white + considered,
        without_priors=_without_priors(state, q, verdict, maps),
        local_only=_concerned(state, q, verdict, local),
        warnings=(*map(_warning, local), *map(str, grazing)),
    )


def _root(variance: float) -> float:
    """Return the square root of a variance; infinite where rounding has left none, in a direction that is not seen."""
    return math.sqrt(variance) if variance >= 0.0 else math.inf


def _without_priors(state: SearchState, q: FloatArray, verdict: Verdict, maps: FloatArray) -> FloatArray:
    """Return the white standard errors that the records alone give, (k,); none where no prior counts.

    Infinite where a parameter has part in a direction that the records do not see.
    """
    if not state.problem.priors:
        return np.zeros(0)
    J = combined(state.problem.triangles(q, state.windows)).jacobian[:, verdict.counted]
    size = np.linalg.norm(J, axis=0)
    size[size == 0.0] = 1.0
    _, s, Vt = np.linalg.svd(J / size, full_matrices=False)
    seen = s > SINGULAR * s.max(initial=0.0)
    parts = (maps[:, verdict.counted] / size) @ Vt.T
    variance = np.sum((parts[:, seen] / s[seen]) ** 2, axis=1)
    unseen = np.linalg.norm(parts[:, ~seen], axis=1) > UNSEEN_SHARE * np.linalg.norm(parts, axis=1)
    return np.where(unseen, np.inf, np.sqrt(variance))


def _concerned(state: SearchState, q: FloatArray, verdict: Verdict, local: list[Departure]) -> dict[str, str]:
    if not local:
        return {}
    names = told_by(state.problem, q, state.windows, [d.record for d in local], verdict.counted)
    names = tuple(dict.fromkeys((*names, *(name for d in local for name in d.across))))
    where = "; ".join(map(str, local))
    return dict.fromkeys(names, f"local only: a stick/slip may fall the other way within the error: {where}")


def _warning(departure: Departure) -> str:
    return (
        f"{departure}: the cost departs from what its derivatives say in {departure.draws} of 30 draws from the "
        f"covariance, by up to {departure.excess:.3g}: a stick/slip hangs by a thread there, and the standard errors "
        "that rest on this record are local only; see `mechid profile` and `mechid bootstrap`"
    )
