"""Records that are plainly not as declared, told before any search: rate, stepping, unit, two of them swapped.

A record's spectrum says how its motor was stepped, whatever the mechanism's values: full steps fill it with lines,
microsteps leave it nearly empty, and all lines are multiples of the step rate. So the model is run under the declared
command at a few points of the box in which the search starts, and under what the record might be instead at those
points that fit all records best. Spectra are compared in decades, where values that are wrong by factors of two or
three count little, a unit that is wrong by a hundred or a thousand counts most, and phases and start angles nothing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from mechid.command import Command, MeasuredCommand, RateProfile
from mechid.identification.computation.parallel import mapped
from mechid.identification.contradiction.alternatives import samples_of
from mechid.identification.output_error.declaration import DECLARED, Taken, taken_command, taken_target
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.search.multistart import sample_box
from mechid.records.step_rate import SuggestedRate, suggested_beside_hum
from mechid.signal.likeness import noise_power, power_over_time, spectral_distance
from mechid.signal.lines import prominence, spectral_lines

FloatArray = NDArray[np.float64]
POINTS, BEST = 16, 4
"""Points of the box at which the declared commands are run, and of these those at which others are."""
STEPS, LEAST_S, MOST_S, PIECE_S = 8.0, 0.25, 2.0, 0.5
"""Full steps of a record that are run, within these times; of a rate that varies in pieces, as its lines move."""
HIGHEST_HZ = 1000.0
SCALES = (1e-3, 1e-2, 1e2, 1e3)
"""What a torque is to be multiplied by where its unit is a wrong one: mN m, N cm for N m, and the reverse."""
COARSE = 2
"""Steps a full step, at most, that fill a spectrum."""
USUAL_MICROSTEPS = 16
COMMON, UNIT, STEPPING, RATE, SWAP = 1.2, 2.5, 1.15, 1.2, 1.2
"""Times as far off as declared than as read otherwise, from which a record is plainly so."""
RIVAL = 2.0
"""Times as far off by a hundred as by a thousand, or the reverse, up to which it may be either."""
GIVEN_UP = 2.5
"""Times as far off as declared at the first point from which a reading is not looked at further."""
AS_WELL = 1.15
"""Times as far off as by causes of their own, up to which two records are rather swapped."""
OWN_LINES_S, OWN_RIDGE_S = 4.0, 8.0
"""How much of a record is looked at for its own step rate, by its lines and over time."""
SAME_RATE, SAME_END = 0.01, 0.1
"""Of a rate, and of a swept rate's end: what is off by no more is no other one."""
REPEATS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
"""Full steps at the rate declared after which a record may repeat itself."""
FULL_STEPS = (1.0, 2.0)
"""Times the rate declared that the lines of full steps may suggest."""
PARTS = (1.0, 2.0, 4.0)
"""Times what its lines are multiples of that a step rate may be; of a ridge over time, the first two."""


@dataclass(frozen=True)
class FirstSight:
    """What a first sight of records says.

    Attributes
    ----------
    common_scale : float
        What the torque of all records alike is plainly to be multiplied by; 1 where nothing is.
    otherwise : mapping of record to Taken
        What is plainly otherwise with single records.
    doubtful : frozenset of str
        Those of which it may as well be half or twice that rate, or a unit ten times as large or small.
    """

    common_scale: float = 1.0
    otherwise: Mapping[str, Taken] = field(default_factory=dict)
    doubtful: frozenset[str] = frozenset()

    @property
    def sure(self) -> dict[str, Taken]:
        """The readings that are no other ones as well."""
        return {name: taken for name, taken in self.otherwise.items() if name not in self.doubtful}


@dataclass(frozen=True, eq=False)
class _Sight:
    """A record's first steps, and its power over frequency in them, (pieces, F)."""

    target: Target
    whole: Target
    pieces: int

    @cached_property
    def bins(self) -> int:
        base, size = self.target.base, self.target.samples // self.pieces
        return int(min(HIGHEST_HZ, 0.5 * base.sample_rate_hz) * size / base.sample_rate_hz)

    @cached_property
    def power(self) -> FloatArray:
        return power_over_time(self.target.leading.measured, self.pieces)[:, : self.bins]

    @cached_property
    def noise(self) -> float:
        return noise_power(self.target.leading.sigma, self.target.samples // self.pieces)

    @cached_property
    def own(self) -> SuggestedRate | None:
        """How the record seems to be driven by its own lines."""
        fs = self.whole.base.sample_rate_hz
        y = self.whole.leading.measured[: round(self.own_s * fs)]
        found = prominence(y, fs)
        return suggested_beside_hum(y, found, spectral_lines(found))

    @property
    def own_s(self) -> float:
        """How much of it is looked at for that, s."""
        return min(OWN_LINES_S if _is_constant(self.command) else OWN_RIDGE_S, self.whole.base.duration_s)

    @property
    def fastest(self) -> float:
        """The largest rate that is declared within that, full steps/s."""
        rate = self.command.rate
        inside = [one for time, one in zip(rate.times_s, rate.rates, strict=True) if time < self.own_s]
        return max(map(abs, (*inside, float(np.interp(self.own_s, rate.times_s, rate.rates)))))

    @property
    def command(self) -> Command:
        """As declared."""
        return self.whole.command

    def modelled(self, problem: Problem, taken: Taken, q: FloatArray) -> FloatArray | None:
        """Return the model's power under another command, or None where it cannot be run."""
        own = self.target if taken == DECLARED else taken_target(self.target, replace(taken, scale=1.0))
        y = problem.model.predict(own, q, own.samples)[0]
        return power_over_time(y, self.pieces)[:, : self.bins] if np.all(np.isfinite(y)) else None

    def distances(self, modelled: FloatArray | None, scales: Sequence[float]) -> list[float]:
        """Return how far it is off if it were to be multiplied by each scale; inf where that cannot be said."""
        if modelled is None:
            return [math.inf] * len(scales)
        return [spectral_distance(self.power, modelled / scale**2, self.noise) for scale in scales]


def first_sight(problem: Problem, seed: int = 0) -> FirstSight:
    """Return what is plainly otherwise than declared, by each record's own spectrum.

    Parameters
    ----------
    problem : Problem
        All records as declared. Looked at are those of which the torque leads, under a command.
    seed : int
        Of the points of the box.
    """
    sights = {t.name: _sight(t) for t in problem.targets if _is_looked_at(t)}
    own = problem.coordinates.of_records(problem.start)
    points = [np.concatenate([q, own]) for q in sample_box(problem.space, POINTS, seed)]
    scales = (1.0, *SCALES)
    each = partial(_declared, problem, points, scales)
    of = dict(zip(sights, mapped(each, list(sights.values()), problem.workers), strict=True))
    of = {name: distances for name, distances in of.items() if np.isfinite(distances[:, 0]).any()}
    if not of:
        return FirstSight()
    total = np.sum(np.sqrt(list(of.values())), axis=0)
    least = np.min(total, axis=0)
    common = int(np.argmin(least))
    if common and least[0] > COMMON * least[common]:
        return FirstSight(scales[common])
    best = np.argsort(total[:, 0], kind="stable")[:BEST]
    at = _Comparison(problem, [points[i] for i in best], {name: sights[name] for name in of})
    return at.otherwise({name: distances[best] for name, distances in of.items()})


def _is_looked_at(target: Target) -> bool:
    return target.leading.quantity == "torque" and not isinstance(target.command, MeasuredCommand)


def _sight(target: Target) -> _Sight:
    """Return the first steps of a record, its own parameters at their values."""
    rate = target.base.sample_rate_hz
    steps = max(samples_of(target, STEPS), round(LEAST_S * rate))
    samples = min(steps, round(MOST_S * rate), target.samples)
    pieces = 1 if _is_constant(target.command) else max(round(samples / rate / PIECE_S), 1)
    return _Sight(target.beginning(samples), target, pieces)


def _is_constant(command: Command) -> bool:
    return len(set(command.rate.rates)) == 1


def _declared(problem: Problem, points: Sequence[FloatArray], scales: Sequence[float], sight: _Sight) -> FloatArray:
    """Return how far off a record is as declared, (points, scales)."""
    return np.array([sight.distances(sight.modelled(problem, DECLARED, q), scales) for q in points])


@dataclass(frozen=True)
class _Comparison:
    """Readings of the records beside their declarations, at points that fit all of them best as declared."""

    problem: Problem
    points: Sequence[FloatArray]
    sights: Mapping[str, _Sight]

    def otherwise(self, distances: Mapping[str, FloatArray]) -> FirstSight:
        """Return the readings that are plainly nearer; two records swapped are one cause for both.

        `distances` are those as declared, (points, scales) by record.
        """
        declared = {name: float(some[:, 0].min()) for name, some in distances.items()}
        singles = {name: self._single(self.sights[name], some) for name, some in distances.items()}
        swapped = self._swapped(declared, {name: off for name, (off, _) in singles.items()})
        otherwise = {**{name: taken for name, (_, taken) in singles.items() if taken != DECLARED}, **swapped}
        doubtful = {name for name, taken in otherwise.items() if self._is_doubtful(name, taken, distances[name])}
        partners = {name for name, taken in otherwise.items() if taken.swapped in doubtful}
        return FirstSight(1.0, otherwise, frozenset(doubtful | partners))

    def _is_doubtful(self, name: str, taken: Taken, distances: FloatArray) -> bool:
        """Tell whether another reading of the same kind is as good: another unit, or half or twice the rate."""
        if taken.scale == 1.0:
            return _is_doubtful_rate(self.sights[name], taken)
        least = distances[:, 1:].min(axis=0)
        rivals = (k for k, scale in enumerate(SCALES) if scale != taken.scale and (scale > 1.0) == (taken.scale > 1.0))
        return any(least[k] < RIVAL * least[SCALES.index(taken.scale)] for k in rivals)

    def _distance(self, sight: _Sight, taken: Taken, declared: float) -> float:
        """Return how far off a record is as read; at the first point alone where that is far from the declared one."""
        least = math.inf
        for q in self.points:
            least = min(least, *sight.distances(sight.modelled(self.problem, taken, q), [1.0]))
            if least > GIVEN_UP * declared:
                break
        return least

    def _swapped(self, declared: Mapping[str, float], singles: Mapping[str, float]) -> dict[str, Taken]:
        """Return the two records that are nearer by each other's command, the clearest such pair.

        None where each by itself is nearer still in another way, where its own lines are at another rate, or where no
        own line speaks against what is declared.
        """
        found: list[tuple[float, dict[str, Taken]]] = []
        spoken = {name for name in declared if _contradicts(self.sights[name])}
        for pair in combinations(declared, 2):
            if spoken.isdisjoint(pair):
                continue
            taken = {name: _driven_as(self.sights[other].whole) for name, other in zip(pair, pair[::-1], strict=True)}
            if all(taken_command(self.sights[name].command, taken[name]) == self.sights[name].command for name in pair):
                continue
            off = sum(self._distance(self.sights[name], taken[name], declared[name]) for name in pair)
            before = sum(declared[name] for name in pair)
            if before > SWAP * off and off <= AS_WELL * sum(singles[name] for name in pair):
                found.append((before / off, taken))
        _, best = max(found, key=lambda one: one[0], default=(0.0, {}))
        agreed = all(_is_driven_so(self.sights[name], taken, FULL_STEPS) for name, taken in best.items())
        return best if agreed else {}

    def _single(self, sight: _Sight, distances: FloatArray) -> tuple[float, Taken]:
        """Return the likeliest reading of one record by itself, and how far off it is; the declared one mostly."""
        declared = float(distances[:, 0].min())
        units = [(float(distances[:, k].min()), UNIT, Taken(scale=scale)) for k, scale in enumerate(SCALES, 1)]
        others = _other_commands(sight)
        commands = [(self._distance(sight, taken, declared), limit, taken) for limit, taken in others]
        plain = [(off, taken) for off, limit, taken in (*units, *commands) if declared > limit * off]
        return min(plain, key=lambda one: one[0], default=(declared, DECLARED))


def _driven_as(other: Target) -> Taken:
    command = other.command
    return Taken(
        rate=command.rate, stepping=command.stepping, microsteps=command.microsteps,
        start_angle_deg=command.start_angle_deg, swapped=other.name,
    )  # fmt: skip


def _other_commands(sight: _Sight) -> list[tuple[float, Taken]]:
    """Return what a record's command may be instead, each with how much nearer it has to be."""
    command, own = sight.command, sight.own
    full = own is not None and own.stepping == "full"
    steppings = []
    if command.microsteps <= COARSE and not full:
        steppings = [Taken(stepping="micro", microsteps=USUAL_MICROSTEPS)]
    elif command.microsteps > COARSE and full:
        steppings = [Taken(stepping="full", microsteps=1), Taken(stepping="half", microsteps=2)]
    return [
        *((STEPPING, taken) for taken in steppings),
        *((RATE, Taken(rate=rate)) for rate in _own_rates(sight)),
    ]


def _times(rate: RateProfile, factor: float) -> RateProfile:
    return RateProfile(rate.times_s, tuple(factor * one for one in rate.rates))


def _own_rates(sight: _Sight) -> list[RateProfile]:
    """Return the rates that a record's own lines tell where they are at no part of the one declared."""
    own = sight.own
    if own is None or _is_part(own, sight):
        return []
    sign = math.copysign(1.0, max(sight.command.rate.rates, key=abs))
    if own.is_constant and own.stepping == "full":
        return [_times(own.profile, sign)]
    factors = [part * own.repetition_hz / own.rate for part in PARTS] if own.is_constant else PARTS[:2]
    return [_times(_to_the_end(own.profile, sight.whole.base.duration_s), sign * factor) for factor in factors]


def _to_the_end(rate: RateProfile, seconds: float) -> RateProfile:
    """Return a straight line of the rate from the start to the end of a record."""
    if len(rate.rates) == 1:
        return rate
    (_, until), (first, last) = rate.times_s, rate.rates
    return RateProfile.through([(0.0, first), (seconds, first + (last - first) * seconds / until)])


def _contradicts(sight: _Sight) -> bool:
    """Tell whether a record's own lines speak against its declaration: another rate, or full steps and microsteps."""
    own, coarse = sight.own, sight.command.microsteps <= COARSE
    if own is None:
        return False
    return not _is_part(own, sight) or (own.stepping != "" and (own.stepping == "full") != coarse)


def _is_driven_so(sight: _Sight, taken: Taken, multiples: Sequence[float]) -> bool:
    """Tell whether a record whose own lines are those of full steps has them at such multiples of the rate read."""
    own, command = sight.own, taken_command(sight.command, taken)
    if own is None or own.stepping != "full" or command.microsteps > COARSE:
        return True
    rate = max(abs(rate) for rate in command.rate.rates) * command.microsteps
    return own.is_constant and any(abs(own.rate / rate / one - 1.0) < SAME_RATE for one in multiples)


def _is_doubtful_rate(sight: _Sight, taken: Taken) -> bool:
    """Tell whether half or twice the rate that is read would explain the record's lines as well."""
    if taken.rate is None:
        return False
    if taken.swapped is None:
        return len(_own_rates(sight)) > 1
    declared, read = (max(abs(rate) for rate in rate.rates) for rate in (sight.command.rate, taken.rate))
    same = taken_command(sight.command, taken).microsteps == sight.command.microsteps
    related = any(abs(declared / read / one - 1.0) < SAME_RATE for one in REPEATS)
    return same and related and not _is_driven_so(sight, taken, FULL_STEPS[:1])


def _is_part(own: SuggestedRate, sight: _Sight) -> bool:
    """Tell whether a record may suggest what it does at the rate declared."""
    command, declared = sight.command, sight.fastest
    if own.is_constant != _is_constant(command):
        return False
    if command.microsteps == 1 and own.stepping == "full":
        return any(abs(own.rate / declared / one - 1.0) < SAME_RATE for one in FULL_STEPS)
    repeats = declared / (own.repetition_hz if own.is_constant else own.rate)
    return any(abs(repeats / one - 1.0) < (SAME_RATE if own.is_constant else SAME_END) for one in REPEATS)
