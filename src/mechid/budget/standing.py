"""How what a mode makes of the line of sight, with the errors of other sources, stands against a requirement."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechid.budget.flying_mechanism import Estimate
from mechid.budget.indices import Index
from mechid.budget.levels import CONE, Mixture, ensemble_level, mixed_level
from mechid.budget.line_of_sight import LineOfSight, Moved
from mechid.budget.other_errors import OtherError
from mechid.budget.pointing_error import POINTS, PointingError
from mechid.budget.requirement import Requirement, Standing
from mechid.budget.shares import Band, drawn, line_shares
from mechid.budget.summation import Contribution, total

FloatArray = NDArray[np.float64]

MEMBERS = 100
"""Draws of the ensemble that [flight.spread] and the spread of other errors describe."""
MISSED_DRAWS = 128
"""Of what the model misses."""
DISCREPANCY = "model discrepancy"
QUICK_POINTS = 1024
"""Instants of a level where many are compared; all have the same, so that what they differ by is good."""
Parts = Sequence[tuple[float, LineOfSight]]
"""Lines of sight by the share of the time in which each is there; what is left to 1, the mechanism rests."""


@dataclass(frozen=True, eq=False)
class Ensemble:
    """Units and conditions: what spreads, the errors of other sources, and seeded draws of both.

    Attributes
    ----------
    spread : mapping of dotted name to standard deviation
        Their derivatives are the last columns of a response's.
    errors : tuple of OtherError
    draws : (k, s + e)
        In standard deviations, the nominal member first; one row where nothing spreads.
    """

    names: tuple[str, ...]
    spread: FloatArray
    errors: tuple[OtherError, ...]
    draws: FloatArray


def make_ensemble(names: Sequence[str], spread: FloatArray, errors: Sequence[OtherError], seed: int) -> Ensemble:
    """Return the ensemble; errors of one group are drawn together."""
    varies = bool(np.any(spread > 0.0)) or any(e.spread_rad > 0.0 for e in errors)
    draws = np.random.default_rng(seed).normal(size=(MEMBERS if varies else 1, len(names) + len(errors)))
    draws[0] = 0.0
    groups: dict[str, int] = {}
    for k, error in enumerate(errors):
        first = groups.setdefault(error.group or f" {k}", k)
        draws[:, len(names) + k] = draws[:, len(names) + first]
    return Ensemble(tuple(names), spread, tuple(errors), draws)


def standing(requirement: Requirement, mode: str, parts: Parts, estimate: Estimate, ensemble: Ensemble) -> Standing:
    """Return how a mode, or several by their share of the time, stands against a requirement."""
    at = _View(requirement, parts, estimate, ensemble)
    nominal, quick = at.level(at.member()), at.quick(at.member())
    members = [at.member(draw=draw) for draw in ensemble.draws]
    one = len(members) == 1 and requirement.interpretation != "ensemble"
    worst = nominal if one else at.ensemble_level(members)
    scale = worst / quick if quick > 0.0 else 1.0
    known = drawn(worst, lambda by: scale * at.quick(at.member(by)), estimate.covariance, estimate.names)
    return Standing(
        requirement=requirement, mode=mode, level=_with_missed(known, scale * at.missed_sigma()),
        nominal_rad=nominal, ecss_rad=at.by_ecss(), others_rad=at.level(at.rests()) if ensemble.errors else 0.0,
        spread_shares=_spread_shares(at, members) if len(members) > 1 else {},
    )  # fmt: skip


def nominal_level(requirement: Requirement, parts: Parts, errors: Sequence[OtherError] = ()) -> float:
    """Return the level in rad over time of the nominal member, errors of other sources with it."""
    index = requirement.index
    own = [(share, part.under(index)(np.zeros(part.columns))) for share, part in parts]
    member = _together(own, len(parts[0][1].axes), errors, np.zeros(len(errors)), index)
    return mixed_level([member], index, requirement.confidence, axis_of(requirement, parts[0][1]))


def axis_of(requirement: Requirement, line_of_sight: LineOfSight) -> int | None:
    """Return the position of a requirement's axis, None for the cone."""
    return None if requirement.axis == CONE else line_of_sight.axes.index(requirement.axis)


def _together(
    own: list[tuple[float, PointingError]], axes: int, errors: Sequence[OtherError], draws: FloatArray, index: Index
) -> Mixture:
    """Return a member: its errors by their share of the time, rest for what is left of it, other sources on top."""
    rest = 1.0 - sum(share for share, _ in own)
    if rest > 1e-9:
        own = [*own, (rest, PointingError(np.zeros(axes)))]
    member = []
    for share, error in own:
        whole = error
        for other, draw in zip(errors, draws, strict=True):
            whole = other.added(whole, float(draw), index.longest_s)
        member.append((share, whole))
    return member


class _View:
    """Errors of the parts under one requirement, as functions of what varies."""

    def __init__(self, requirement: Requirement, parts: Parts, estimate: Estimate, ensemble: Ensemble) -> None:
        self.requirement, self.parts, self.estimate, self.ensemble = requirement, parts, estimate, ensemble
        self.axis = axis_of(requirement, parts[0][1])
        self.moved: list[tuple[float, Moved]] = [(share, part.under(requirement.index)) for share, part in parts]

    def member(self, by: FloatArray | None = None, draw: FloatArray | None = None) -> Mixture:
        """Return a member: the estimate off by `by` (n,), at a draw of the ensemble."""
        s = len(self.ensemble.names)
        draw = np.zeros(s + len(self.ensemble.errors)) if draw is None else draw
        by = np.zeros(len(self.estimate.names)) if by is None else by
        off = np.concatenate([by, draw[:s] * self.ensemble.spread])
        return self._with_rest([(share, moved(off)) for share, moved in self.moved], draw[s:])

    def rests(self) -> Mixture:
        """Return the nominal member while the mechanism rests."""
        return self._with_rest([], np.zeros(len(self.ensemble.errors)))

    def _with_rest(self, own: list[tuple[float, PointingError]], draw: FloatArray) -> Mixture:
        axes = len(self.parts[0][1].axes)
        return _together(own, axes, self.ensemble.errors, draw, self.requirement.index)

    def level(self, member: Mixture, points: int = POINTS) -> float:
        """Return the level over time of one member."""
        r = self.requirement
        return mixed_level([member], r.index, r.confidence, self.axis, points)

    def quick(self, member: Mixture) -> float:
        """Return the same at fewer instants."""
        return self.level(member, QUICK_POINTS)

    def ensemble_level(self, members: Sequence[Mixture]) -> float:
        """Return the level by the requirement's interpretation."""
        r = self.requirement
        return ensemble_level(members, r.index, r.confidence, self.axis, r.interpretation)

    def missed_sigma(self) -> float:
        """Return the scatter of the nominal level by what the model misses on validation records."""
        missed = self.estimate.discrepancy
        if not missed.overall and not missed.orders:
            return 0.0
        rng, levels, index = np.random.default_rng(0), [], self.requirement.index
        for _ in range(MISSED_DRAWS):
            drawn_parts = [(share, part.missed(missed, rng)) for share, part in self.parts]
            own = [(share, part.under(index)(np.zeros(part.columns))) for share, part in drawn_parts]
            levels.append(self.quick(self._with_rest(own, np.zeros(len(self.ensemble.errors)))))
        return float(np.std(levels))

    def by_ecss(self) -> float:
        """Return the level by the standard's summation; a cone is the root of its axes' squares."""
        axes = range(len(self.parts[0][1].axes)) if self.axis is None else [self.axis]
        r = self.requirement
        sums = [total(list(self._contributions(k)), r.interpretation, r.confidence) for k in axes]
        return float(np.hypot.reduce(np.array(sums)))

    def _contributions(self, axis: int) -> Iterator[Contribution]:
        """Yield the mechanism's waveform, what of it does not repeat, and the other errors, as the index keeps them."""
        index, s = self.requirement.index, len(self.ensemble.names)
        peaks, squares, noise = [], [], 0.0
        for draw in self.ensemble.draws:
            off = np.concatenate([np.zeros(len(self.estimate.names)), draw[:s] * self.ensemble.spread])
            errors = [(share, moved(off)) for share, moved in self.moved if share > 0.0]
            peaks.append(max((np.abs(e.waveforms(index, QUICK_POINTS)[:, axis]).max() for _, e in errors), default=0.0))
            squares.append(sum(share * e.parts[0].square(index)[axis] for share, e in errors))
            noise = float(np.sqrt(sum(share * e.sigma(index)[axis] ** 2 for share, e in errors)))
        size = float(np.mean(peaks))
        if size > 0.0:
            form = float(np.sqrt(squares[0])) / peaks[0]
            yield Contribution(name="mechanism", kind="periodic", size=size, spread=float(np.std(peaks)), form=form)
        yield Contribution(name="not steady", kind="random", size=noise)
        yield from filter(None, (error.contribution(index, axis) for error in self.ensemble.errors))


def _with_missed(band: Band, missed: float) -> Band:
    """Return the band with what the model misses as one more, independent part."""
    variance = band.sigma**2 + missed**2
    if variance <= 0.0:
        return band
    shares = {name: share * band.sigma**2 / variance for name, share in band.shares.items()}
    return Band(band.value, float(np.sqrt(variance)), {**shares, DISCREPANCY: missed**2 / variance})


def _spread_shares(at: _View, members: Sequence[Mixture]) -> dict[str, float]:
    """Return the share of each thing that spreads in the variance of the members' levels, by a straight line."""
    own = [f"error {e.name}" for e in at.ensemble.errors]
    levels = np.array([at.quick(member) for member in members])
    return line_shares(at.ensemble.draws, levels, (*at.ensemble.names, *own))
