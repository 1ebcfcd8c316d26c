"""Standard errors in the file's coordinates: noise colour, model error, bounds, priors, held parameters.

Errors beyond noise are added as variances: the scatter of the records' parts (`model_error`); the shift by a
contradicted bound, held parameters, and the choice of the right clock where the campaign leaves it open
(`further_errors`); the remaining step where a stick/slip stopped the solver; and the distance between the mean of the
records' values of a parameter and the mechanism's (`output_error.record_parameters`).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.identification.output_error.reduction import Triangle, combine_triangles
from mechid.identification.result.grade import Consistency, FitOutcome
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.settings import SEARCH
from mechid.identification.search.solve import covariance
from mechid.identification.uncertainty.covariance import Scores, covariances, scores
from mechid.identification.uncertainty.draws import (
    Departure,
    Draws,
    LowerPoint,
    examine_draws,
    grazing_switches,
    parameters_resting_on,
)
from mechid.identification.uncertainty.further_errors import (
    OnBound,
    clock_step,
    clocks_differ,
    consider_covariance,
    newton_step,
    on_bounds,
)
from mechid.identification.uncertainty.model_error import Comparison, ModelError
from mechid.identification.uncertainty.settings import ERRORS
from mechid.identification.uncertainty.verdict import Verdict

NORMAL = 1e6
"""Degrees of freedom from which Student's t counts as the normal distribution."""


@dataclass(frozen=True)
class StandardErrors:
    """Errors of the free parameters, and the parameters whose standard error holds locally only.

    Attributes
    ----------
    names : tuple of str, (n,)
    sigma : (n,)
        Standard errors with model error included, in the file's coordinates and units.
    dof : (n,)
        Their degrees of freedom; infinite where noise explains all.
    correlation : (n, n)
    noise, white : (n, n)
        Covariances by noise alone, of any colour and white, in the file's coordinates and units.
    clock : (n,)
        Shift of each parameter if the driver's time is used instead of the recorder's; included in `sigma`. Empty
        where the clocks agree, or the campaign declares which one is right.
    without_priors : (n,)
        White standard errors of the records alone; empty where no prior is active.
    local_only : dict of str to str
        Reason, by parameter, why its standard error holds on one side of a stick/slip threshold only.
    on_bounds : dict of str to OnBound
    consistency : Consistency or None
        None where nothing is estimated.
    lower : LowerPoint or None
        A draw of lower cost than the estimate, which then is no optimum.
    warnings : tuple of str
    """

    names: tuple[str, ...] = ()
    sigma: FloatArray = field(default_factory=lambda: np.zeros(0))
    dof: FloatArray = field(default_factory=lambda: np.zeros(0))
    correlation: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    noise: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    white: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    clock: FloatArray = field(default_factory=lambda: np.zeros(0))
    without_priors: FloatArray = field(default_factory=lambda: np.zeros(0))
    local_only: dict[str, str] = field(default_factory=dict)
    on_bounds: dict[str, OnBound] = field(default_factory=dict)
    consistency: Consistency | None = None
    lower: LowerPoint | None = None
    warnings: tuple[str, ...] = ()

    def errors_of(self, name: str) -> ParameterErrors:
        """Return the errors of a parameter; all are None where it has none."""
        if name not in self.names:
            return ParameterErrors()
        i = self.names.index(name)
        dof = float(self.dof[i])
        return ParameterErrors(
            total=float(self.sigma[i]),
            noise=_standard_error(self.noise[i, i]),
            white=_standard_error(self.white[i, i]),
            clock=abs(float(self.clock[i])) if self.clock.size else None,
            dof=dof if math.isfinite(dof) else None,
        )

    def error_without_priors(self, name: str) -> float | None:
        """Return the white standard error of a parameter without any prior, None where no prior is active."""
        if name not in self.names or not self.without_priors.size:
            return None
        return float(self.without_priors[self.names.index(name)])

    def drop(self, names: Collection[str]) -> StandardErrors:
        """Remove parameters; their uncertainty stays included in the errors of the others."""
        kept = [i for i, name in enumerate(self.names) if name not in names]
        square = np.ix_(kept, kept)
        return replace(
            self,
            names=tuple(self.names[i] for i in kept),
            sigma=self.sigma[kept],
            dof=self.dof[kept],
            correlation=self.correlation[square],
            noise=self.noise[square],
            white=self.white[square],
            clock=self.clock[kept] if self.clock.size else self.clock,
            without_priors=self.without_priors[kept] if self.without_priors.size else self.without_priors,
        )

    @property
    def covariance(self) -> FloatArray:
        """Covariance with model error included, (n, n)."""
        return np.asarray(self.correlation * np.outer(self.sigma, self.sigma), dtype=np.float64)


@dataclass(frozen=True)
class ParameterErrors:
    """Standard errors of a parameter.

    `total` includes model error and has `dof` degrees of freedom. `noise`, `white` and `clock` are the errors by noise
    of any colour, by white noise, and by the choice of clock.
    """

    total: float | None = None
    noise: float | None = None
    white: float | None = None
    clock: float | None = None
    dof: float | None = None


def standard_errors(
    state: SearchState, seed: int, triangle: Triangle, verdict: Verdict, *, clock_declared: bool = False
) -> StandardErrors:
    """Compute the standard errors at the point of a verdict; `seed` is that of the draws.

    The choice of clock counts where the campaign does not declare the right one.

    A failed fit, or one interrupted in its search, has no errors. Draws test only good fits, and leave held parameters
    unchanged. Draws and switches use the covariance by noise alone, since the quadratic cost refers to it.
    """
    problem, q = state.problem, verdict.q
    failed = state.outcome is FitOutcome.FAILED or (state.outcome is FitOutcome.INTERRUPTED and not state.searched)
    if failed or not verdict.counted.any() or not np.isfinite(triangle.norm):
        return StandardErrors()
    every, slopes = problem.coordinates.value_slopes(q)
    kept = [i for i, name in enumerate(every) if name not in verdict.reasons]
    maps, windows = slopes[kept], state.windows
    names = tuple(every[i] for i in kept)
    found = scores(problem, q, windows)
    by_noise = covariances(triangle, found.variance, verdict.counted)
    white = maps @ by_noise.white @ maps.T
    considered = consider_covariance(problem, q, windows, state.frozen, names, white)
    spread = _Spread(maps)
    consistency, bounded = _collect_errors(spread, state, triangle, verdict, found)
    noise = maps @ by_noise.robust @ maps.T + considered
    if not consistency.agrees:
        growth = spread.totals(considered)[0] / np.sqrt(np.maximum(np.diag(noise), 1e-300))
        consistency = replace(consistency, parameter=names[int(np.argmax(growth))] if names else None)
    undecided = not clock_declared and clocks_differ(problem, q)
    step = clock_step(problem, q, windows, triangle, verdict.counted) if undecided else np.zeros(q.size)
    spread.add_shift(step)
    sigma, dof, correlation = spread.totals(considered)
    drawn = examine_draws(problem, q, windows, by_noise.robust, seed) if state.outcome.good else Draws()
    local = drawn.departures
    grazing = grazing_switches(problem, q, windows, by_noise.robust, found.switching)
    return StandardErrors(
        names=names,
        sigma=sigma,
        dof=dof,
        correlation=correlation,
        noise=noise,
        white=white + considered,
        clock=maps @ step if undecided else np.zeros(0),
        without_priors=_without_priors(state, q, verdict, maps),
        local_only=_local_reasons(state, q, verdict, local),
        on_bounds={b.name: b for b in bounded},
        consistency=consistency,
        lower=drawn.lower,
        warnings=(*map(_departure_warning, local), *map(str, grazing), *_disagreement_warning(consistency)),
    )


def _collect_errors(
    spread: _Spread, state: SearchState, triangle: Triangle, verdict: Verdict, found: Scores
) -> tuple[Consistency, list[OnBound]]:
    """Add the errors at a verdict's point to `spread`; return the parts' consistency and the parameters on bounds."""
    counted, on = verdict.counted, verdict.on_bound
    information = triangle.jacobian.T @ triangle.jacobian

    def over(coordinates: BoolArray) -> Comparison:
        noise = covariances(triangle, found.variance, coordinates).robust
        return Comparison(found.parts, information, noise, coordinates)

    inside = over(counted)
    consistency = inside.consistency
    bounded: list[OnBound] = []
    if not on.any():
        spread.add(inside.error_for(consistency))
    else:
        # The step beyond the bound is measured with the bounded coordinates free: only then can it be judged by chance.
        unbounded, step = over(counted | on).error_for(consistency), newton_step(triangle, counted | on)
        bounded = on_bounds(state.problem, verdict.q, on, step, unbounded.noise)
        spread.add(unbounded)
        if any(b.is_contradicted for b in bounded):
            spread.add(inside.error_for(consistency))
            spread.add_shift(step)
    if state.outcome.has_stopped_short:
        spread.add_shift(newton_step(triangle, counted))
    for score, dof in state.problem.coordinates.undetermined_means(verdict.q):
        spread.add_shift(_shift_by_score(score, triangle, counted), dof)
    return consistency, bounded


def _shift_by_score(score: FloatArray, triangle: Triangle, counted: BoolArray) -> FloatArray:
    """Return the shift of the estimated coordinates by a score, (n,)."""
    step = np.zeros(score.size)
    J = triangle.jacobian[:, counted]
    step[counted] = covariance(Triangle(triangle.norm, J, triangle.samples)) @ score[counted]
    return step


class _Spread:
    """Sum of variances of linear functions of the coordinates; `maps` is (k, n)."""

    def __init__(self, maps: FloatArray) -> None:
        self._maps = maps
        self._variance, self._spread = np.zeros(len(maps)), np.zeros(len(maps))
        self._matrix = np.zeros((len(maps), len(maps)))

    def add(self, error: ModelError) -> None:
        """Add a covariance whose excess over noise has degrees of freedom."""
        variance, spread = error.variances(self._maps)
        self._variance += variance
        self._spread += spread
        noise = self._maps @ error.noise @ self._maps.T
        beyond = self._maps @ error.matrix @ self._maps.T - noise
        share = ERRORS.correlated_share
        self._matrix += noise + share * beyond + (1.0 - share) * np.diag(np.diag(beyond))

    def add_shift(self, step: FloatArray, dof: float = math.inf) -> None:
        """Add a possible shift of the coordinates, (n,), whose size is known with `dof` degrees of freedom."""
        moved = self._maps @ step
        self._variance += moved**2
        # Welch and Satterthwaite: each variance squared over its degrees of freedom; an infinite number adds nothing.
        self._spread += moved**4 / dof
        self._matrix += np.outer(moved, moved)

    def totals(self, considered: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return standard errors, (k,), degrees of freedom, (k,), and correlation, (k, k), with `considered` added."""
        variance = self._variance + np.diag(considered)
        sigma = np.array([_standard_error(v) for v in variance])
        with np.errstate(divide="ignore", invalid="ignore"):
            # Without model error the spread is zero, and the degrees of freedom are infinite.
            dof = np.where(self._spread > variance**2 / NORMAL, variance**2 / self._spread, np.inf)
        matrix = self._matrix + considered
        scale = np.sqrt(np.maximum(np.diag(matrix), 0.0))
        scale[scale == 0.0] = 1.0
        return sigma, dof, np.asarray(matrix / np.outer(scale, scale), dtype=np.float64)


def _disagreement_warning(consistency: Consistency) -> list[str]:
    """Warn that an effect may be absorbed by a parameter where parts of the records disagree severely."""
    tests = {
        "from phase to phase of a step": consistency.phase,
        "from record to record": consistency.record,
        "over time": consistency.time,
    }
    ratio, where = max(((test.ratio, words) for words, test in tests.items() if test is not None), default=(0.0, ""))
    if ratio <= ERRORS.severe_disagreement:
        return []
    return [
        f"{where} the records disagree {ratio:.3g} times as much as noise explains: the model lacks an effect. The "
        "standard errors are widened by the disagreement, but an effect that acts exactly like a parameter shifts that "
        "parameter undetected; add candidate effects to the mechanism file and compare the fits"
    ]


def _standard_error(variance: float) -> float:
    """Return the square root of a variance; infinite where rounding made it negative, in an invisible direction."""
    return math.sqrt(variance) if variance >= 0.0 else math.inf


def _without_priors(state: SearchState, q: FloatArray, verdict: Verdict, maps: FloatArray) -> FloatArray:
    """Return the white standard errors of the records alone, (k,); empty where no prior is active.

    Infinite where a parameter depends on a direction that the records do not see.
    """
    if not state.problem.priors:
        return np.zeros(0)
    means = replace(state.problem, priors={}).prior_triangles(q)
    J = combine_triangles([*state.problem.triangles(q, state.windows), *means]).jacobian[:, verdict.counted]
    size = np.linalg.norm(J, axis=0)
    size[size == 0.0] = 1.0
    # Unit columns: the threshold on singular values then does not depend on the units of the coordinates.
    _, s, Vt = np.linalg.svd(J / size, full_matrices=False)
    seen = s > SEARCH.singular * s.max(initial=0.0)
    parts = (maps[:, verdict.counted] / size) @ Vt.T
    variance = np.sum((parts[:, seen] / s[seen]) ** 2, axis=1)
    unseen = np.linalg.norm(parts[:, ~seen], axis=1) > ERRORS.unseen_share * np.linalg.norm(parts, axis=1)
    return np.where(unseen, np.inf, np.sqrt(variance))


def _local_reasons(state: SearchState, q: FloatArray, verdict: Verdict, local: Sequence[Departure]) -> dict[str, str]:
    if not local:
        return {}
    names = parameters_resting_on(state.problem, q, state.windows, [d.record for d in local], verdict.counted)
    names = tuple(dict.fromkeys((*names, *(name for d in local for name in d.across))))
    where = "; ".join(map(str, local))
    return dict.fromkeys(names, f"near a stick/slip threshold; its error holds on this side only: {where}")


def _departure_warning(departure: Departure) -> str:
    side = "above" if departure.excess > 0.0 else "below"
    return (
        f"{departure}: near a stick/slip threshold: in {departure.draws} of 30 draws within the standard errors a "
        f"stick-slip event there turns out differently, with the cost up to {abs(departure.excess):.3g} {side} the "
        "quadratic that standard errors assume; errors that depend on this record hold on this side of the threshold "
        "only; run `mechid profile` or `mechid bootstrap`"
    )
