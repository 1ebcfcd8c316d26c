"""Comparison of a mode and the errors of other sources with a requirement."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mechid.arrays import FloatArray
from mechid.budgets.ensemble import Ensemble
from mechid.budgets.ensemble_level import FromDraws, ensemble_level
from mechid.budgets.flying_mechanism import Estimate
from mechid.budgets.levels import CONE, Mixture, member_level, mixed_level
from mechid.budgets.line_of_sight import ErrorFunction, LineOfSight, Response
from mechid.budgets.main_effects import MainEffects, main_effects
from mechid.budgets.other_errors import OtherError
from mechid.budgets.pointing_error import PointingError
from mechid.budgets.requirement import Requirement, Standing
from mechid.budgets.settings import LEVEL
from mechid.budgets.shares import Band, band_from_draws
from mechid.budgets.summation import Contribution, total

DISCREPANCY = "model discrepancy"
RESIDUAL = "lines that the model lacks"
SIDE = "forces and moments beside the torque"
SAMPLING = "draws of the ensemble"
Parts = Sequence[tuple[float, LineOfSight]]
"""Lines of sight with the share of the time of each; for the rest of the time the mechanism is at rest."""


def assess_standing(
    requirement: Requirement, mode: str, parts: Parts, estimate: Estimate, ensemble: Ensemble
) -> Standing:
    """Return the result of a mode, or of several by their share of the time, against a requirement."""
    at = _Assessment(requirement, parts, estimate, ensemble)
    nominal, quick = at.level(at.member()), at.quick(at.member())
    effects = main_effects(lambda z: at.rank(at.unit(z)), len(ensemble.variables))
    worst = at.level_over_ensemble(effects)
    # The parameters' band is sampled at the nominal unit with few instants; its ratio to the full level is constant to
    # first order.
    scale = worst.value / quick if quick > 0.0 else 1.0
    known = band_from_draws(
        worst.value, lambda by: scale * at.quick(at.member(by)), estimate.covariance, estimate.names
    )
    return Standing(
        requirement=requirement,
        mode=mode,
        level=at.with_other_parts(known, scale, worst.sigma),
        residual_rad=worst.value - scale * at.quick_without_residual() if at.has_residual else 0.0,
        nominal_rad=nominal,
        sampling_rad=worst.sigma,
        ecss_rad=at.ecss_level(),
        others_rad=at.level(at.resting_member()) if ensemble.errors else 0.0,
        spread_shares=effects.shares(ensemble.variables),
    )


def nominal_level(requirement: Requirement, parts: Parts, errors: Sequence[OtherError] = ()) -> float:
    """Return the level in rad over time of the nominal member, errors of other sources included."""
    index = requirement.index
    own = [(share, part.error_under(index)(np.zeros(part.columns))) for share, part in parts]
    member = _combine(own, len(parts[0][1].axes), errors, np.zeros(len(errors)))
    return mixed_level([member], index, requirement.confidence, axis_of(requirement, parts[0][1]))


def axis_of(requirement: Requirement, line_of_sight: LineOfSight) -> int | None:
    """Return the position of a requirement's axis, None for the cone."""
    return None if requirement.axis == CONE else line_of_sight.axes.index(requirement.axis)


def others_square(requirement: Requirement, line_of_sight: LineOfSight, errors: Sequence[OtherError]) -> float:
    """Return the mean square of the errors of other sources alone under a requirement's index, rad^2."""
    axes, axis = len(line_of_sight.axes), axis_of(requirement, line_of_sight)
    ((_, whole),) = _combine([], axes, errors, np.zeros(len(errors)))
    square = whole.rms(requirement.index) ** 2
    return float(square.sum() if axis is None else square[axis])


def _combine(
    own: list[tuple[float, PointingError]], axes: int, errors: Sequence[OtherError], draws: FloatArray
) -> Mixture:
    """Return a member: its errors by their share of the time, rest for the remainder, other sources added."""
    rest = 1.0 - sum(share for share, _ in own)
    # Shares that add to 1 up to rounding leave no rest.
    if rest > 1e-9:
        own = [*own, (rest, PointingError(np.zeros(axes)))]
    member = []
    for share, error in own:
        whole = error
        for other, draw in zip(errors, draws, strict=True):
            whole = other.add_to(whole, float(draw))
        member.append((share, whole))
    return member


class _Assessment:
    """Errors of the parts under one requirement, as functions of the varying quantities."""

    def __init__(self, requirement: Requirement, parts: Parts, estimate: Estimate, ensemble: Ensemble) -> None:
        self.requirement, self.parts, self.estimate, self.ensemble = requirement, parts, estimate, ensemble
        self.axis = axis_of(requirement, parts[0][1])
        self.error_functions: list[tuple[float, ErrorFunction]] = [
            (share, part.error_under(requirement.index)) for share, part in parts
        ]

    def member(self, by: FloatArray | None = None, draw: FloatArray | None = None) -> Mixture:
        """Return a member for deviations `by` (n,) of the estimate and a draw of the ensemble."""
        s = len(self.ensemble.names)
        draw = np.zeros(s + len(self.ensemble.errors)) if draw is None else draw
        by = np.zeros(len(self.estimate.names)) if by is None else by
        off = np.concatenate([by, draw[:s] * self.ensemble.spread])
        return self._with_rest([(share, error_at(off)) for share, error_at in self.error_functions], draw[s:])

    def unit(self, z: FloatArray) -> Mixture:
        """Return the member at a point of the ensemble's variables, (d,) standard deviations."""
        return self.member(draw=z @ self.ensemble.follows)

    def resting_member(self) -> Mixture:
        """Return the nominal member while the mechanism rests."""
        return self._with_rest([], np.zeros(len(self.ensemble.errors)))

    def _with_rest(self, own: list[tuple[float, PointingError]], draw: FloatArray) -> Mixture:
        axes = len(self.parts[0][1].axes)
        return _combine(own, axes, self.ensemble.errors, draw)

    def level(self, member: Mixture, points: int = LEVEL.points) -> float:
        """Return the level over time of one member."""
        r = self.requirement
        return mixed_level([member], r.index, r.confidence, self.axis, points)

    def quick(self, member: Mixture) -> float:
        """Return the level over time of one member, at fewer instants."""
        return self.level(member, LEVEL.quick_points)

    def rank(self, member: Mixture, points: int = LEVEL.quick_points) -> float:
        """Return the value by which members are ranked under the requirement's interpretation."""
        r = self.requirement
        return member_level(member, r.index, r.confidence, self.axis, r.interpretation, points)

    def level_over_ensemble(self, effects: MainEffects) -> FromDraws:
        """Return the level by the requirement's interpretation.

        Ranked members are evaluated at few instants; the difference that this makes for the nominal member is added.
        """
        whole, few = self.rank(self.member(), LEVEL.points), effects.centre
        if not self.ensemble.variables:
            return FromDraws(whole, 0.0)
        r, members = self.requirement, self.ensemble.along(effects.direction)
        found = ensemble_level(
            lambda draw: self.member(draw=draw), members, r.index, r.confidence, self.axis, r.interpretation
        )
        left_out = 0.0 if r.interpretation == "mixed" else whole - few
        return FromDraws(found.value + left_out, found.sigma)

    def discrepancy_sigma(self) -> float:
        """Return the scatter of the nominal level due to the model discrepancy."""
        missed = self.estimate.discrepancy
        if not missed.overall and not missed.orders:
            return 0.0
        # A fixed seed: the band must not change from run to run.
        rng = np.random.default_rng(0)
        drawn = (
            [(share, part.draw_discrepancy(missed, rng)) for share, part in self.parts]
            for _ in range(LEVEL.missed_draws)
        )
        return float(np.std([self._drawn_level(parts) for parts in drawn]))

    @property
    def has_residual(self) -> bool:
        """Whether the bench's records have a residual that flies."""
        return any(isinstance(part, Response) and part.lacking is not None for _, part in self.parts)

    def quick_without_residual(self) -> float:
        """Return the nominal level of the model alone, at fewer instants."""
        return self._drawn_level([(share, part.without_residual()) for share, part in self.parts])

    def residual_sigma(self) -> float:
        """Return the scatter of the nominal level due to phases and sizes of the unmodelled lines."""
        if not self.has_residual:
            return 0.0
        rng = np.random.default_rng(0)
        drawn = ([(share, part.with_residual(rng)) for share, part in self.parts] for _ in range(LEVEL.missed_draws))
        return float(np.std([self._drawn_level(parts) for parts in drawn]))

    def side_sigma(self) -> float:
        """Return the scatter of the nominal level due to the errors of the other components."""
        rng = np.random.default_rng(0)
        drawn = ([(share, part.with_side(rng)) for share, part in self.parts] for _ in range(LEVEL.missed_draws))
        return float(np.std([self._drawn_level(parts) for parts in drawn]))

    @property
    def has_side(self) -> bool:
        """Whether any other component flies."""
        return any(isinstance(part, Response) and part.side is not None for _, part in self.parts)

    def with_other_parts(self, known: Band, scale: float, sampling: float) -> Band:
        """Add model discrepancy, unmodelled torque and the ensemble's sampling error to a band."""
        band = _with_part(known, scale * self.discrepancy_sigma(), DISCREPANCY)
        if self.has_residual:
            band = _with_part(band, scale * self.residual_sigma(), RESIDUAL)
        if self.has_side:
            band = _with_part(band, scale * self.side_sigma(), SIDE)
        return _with_part(band, sampling, SAMPLING)

    def _drawn_level(self, parts: Parts) -> float:
        """Return the nominal level of drawn lines of sight."""
        index = self.requirement.index
        own = [(share, part.error_under(index)(np.zeros(part.columns))) for share, part in parts]
        return self.quick(self._with_rest(own, np.zeros(len(self.ensemble.errors))))

    def ecss_level(self) -> float:
        """Return the level by the standard's summation; for a cone the root of the sum of its axes' squares."""
        axes = range(len(self.parts[0][1].axes)) if self.axis is None else [self.axis]
        r = self.requirement
        sums = [total(list(self._contributions(k)), r.interpretation, r.confidence) for k in axes]
        return float(np.hypot.reduce(np.array(sums)))

    def _contributions(self, axis: int) -> Iterator[Contribution]:
        """Yield the mechanism's waveform, its non-repeating part, and the other errors, as the index keeps them."""
        index, variables = self.requirement.index, len(self.ensemble.variables)
        peak = main_effects(lambda z: self._peak(self._mechanism(z), axis), variables)
        nominal = self._mechanism(np.zeros(variables))
        if peak.mean > 0.0 and peak.centre > 0.0:
            rms = np.sqrt(sum(share * e.parts[0].square(index)[axis] for share, e in nominal))
            form = float(rms) / peak.centre
            yield Contribution(name="mechanism", kind="periodic", size=peak.mean, spread=peak.sigma, form=form)
        noise = float(np.sqrt(sum(share * e.sigma(index)[axis] ** 2 for share, e in nominal)))
        yield Contribution(name="not steady", kind="random", size=noise)
        yield from filter(None, (error.contribution(index, axis) for error in self.ensemble.errors))

    def _mechanism(self, z: FloatArray) -> list[tuple[float, PointingError]]:
        """Return the mechanism's own errors with their shares of the time, at a point of the ensemble's variables."""
        draw = (z @ self.ensemble.follows)[: len(self.ensemble.names)]
        off = np.concatenate([np.zeros(len(self.estimate.names)), draw * self.ensemble.spread])
        return [(share, error_at(off)) for share, error_at in self.error_functions if share > 0.0]

    def _peak(self, errors: Sequence[tuple[float, PointingError]], axis: int) -> float:
        waveforms = (e.waveforms(self.requirement.index, LEVEL.quick_points)[:, axis] for _, e in errors)
        return max((float(np.abs(w).max()) for w in waveforms), default=0.0)


def _with_part(band: Band, sigma: float, name: str) -> Band:
    """Return the band with an additional independent part."""
    variance = band.sigma**2 + sigma**2
    if variance <= 0.0:
        return band
    # Variances add, and all shares refer to the new sum.
    shares = {each: share * band.sigma**2 / variance for each, share in band.shares.items()}
    return Band(band.value, float(np.sqrt(variance)), {**shares, name: sigma**2 / variance})
