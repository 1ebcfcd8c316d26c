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
from functools import partial
from itertools import combinations

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.computation.parallel import in_threads, mapped
from mechid.identification.contradiction.record_sight import (
    COARSE,
    FULL_STEPS,
    RecordSight,
    contradicts,
    is_doubtful_rate,
    is_driven_so,
    is_looked_at,
    own_rates,
    sight_of,
)
from mechid.identification.output_error.declaration import DECLARED, Reading, command_as_read
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.search.box import sample_box
from mechid.parameter import Role

POINTS, BEST = 16, 4
"""Points of the box at which the declared commands are run, and of these those at which others are. Of 37 campaigns
as declared one had two records swapped with 8 points, none with 16."""
SCALES = (1e-3, 1e-2, 1e2, 1e3)
"""What a torque is to be multiplied by where its unit is a wrong one: mN m, N cm for N m, and the reverse."""
CUT_OFFS_HZ = (30.0, 50.0, 70.0, 100.0, 140.0, 200.0, 280.0, 400.0, 560.0)
"""Of low-passes that a record may have passed; of one beyond them too little is seen. A factor of 1.4 apart: a
choice, not measured."""
USUAL_MICROSTEPS = 16
"""What full steps are tried as: how many there are changes little in the band that is compared. A choice, not
measured."""
COMMON, UNIT, STEPPING, RATE, SWAP, LOW_PASS = 1.2, 2.5, 1.15, 1.2, 1.2, 2.5
"""Times as far off as declared than as read otherwise, from which a record is plainly so. With these none of 112
campaigns as declared was told off (benchmarks/first_sight.py); a unit at 1.2 was wrong, as a model without
detents gives microsteps a tenth of their torque."""
RIVAL = 2.0
"""Times as far off by a hundred as by a thousand, or the reverse, up to which it may be either. What they tell is
in the table of faults of docs/identification.md; the figure itself is a choice."""
GIVEN_UP = 2.5
"""Times as far off as declared at the first point from which a reading is not looked at further. Saves time alone.
A choice, not measured."""
AS_WELL = 1.15
"""Times as far off as by causes of their own, up to which two records are rather swapped; a choice, not measured."""


@dataclass(frozen=True)
class FirstSight:
    """What a first sight of records says.

    Attributes
    ----------
    common_scale : float
        What the torque of all records alike is plainly to be multiplied by; 1 where nothing is.
    otherwise : mapping of record to Reading
        What is plainly otherwise with single records.
    doubtful : frozenset of str
        Those of which it may as well be half or twice that rate, or another unit.
    cut_off_hz : mapping of record to float
        From about where on records fall as behind a low-pass, where the mechanism has none.
    rival_scales : tuple of float
        Further scales of all records that fit about as well as `common_scale`.
    rivals : mapping of record to tuple of Reading
        Further readings of single records that fit about as well, where a search compared them.
    unexplained : frozenset of str
        Records that a reading seemed to fit by its spectrum, and that no reading fits in a search.
    level : float
        Where no usual unit fits: 1 where the torque of all records is far larger than the mechanism's, -1 where it is
        far smaller; else 0.
    failing : int
        Of the points of the box, those at which a record cannot be simulated, where these are most of them; else 0.
    """

    common_scale: float = 1.0
    otherwise: Mapping[str, Reading] = field(default_factory=dict)
    doubtful: frozenset[str] = frozenset()
    cut_off_hz: Mapping[str, float] = field(default_factory=dict)
    rival_scales: tuple[float, ...] = ()
    rivals: Mapping[str, tuple[Reading, ...]] = field(default_factory=dict)
    unexplained: frozenset[str] = frozenset()
    level: float = 0.0
    failing: int = 0

    @property
    def doubted(self) -> frozenset[str]:
        """Records that are not as declared, with a cause or without one."""
        return frozenset(self.otherwise) | self.unexplained

    @property
    def sure(self) -> dict[str, Reading]:
        """The readings that are no other ones as well."""
        return {name: taken for name, taken in self.otherwise.items() if name not in self.doubtful}


def first_sight(problem: Problem, seed: int = 0) -> FirstSight:
    """Return what is plainly otherwise than declared, by each record's own spectrum.

    Parameters
    ----------
    problem : Problem
        All records as declared. Looked at are those of which the torque leads, under a command.
    seed : int
        Of the points of the box.
    """
    sights = {t.name: sight_of(t) for t in problem.targets if is_looked_at(t)}
    own = problem.coordinates.of_records(problem.start)
    points = [np.concatenate([q, own]) for q in sample_box(problem.space, POINTS, seed)]
    scales = (1.0, *SCALES)
    cut_offs = () if problem.space.mechanism.plant.having(Role.CUT_OFF) else CUT_OFFS_HZ
    each = partial(_declared, problem, points, scales, cut_offs)
    of = dict(zip(sights, mapped(each, list(sights.values()), problem.workers), strict=True))
    failing = int(np.sum(np.any([~np.isfinite(distances[:, 0]) for distances in of.values()], axis=0)))
    of = {name: distances for name, distances in of.items() if np.isfinite(distances[:, 0]).any()}
    seen = _seen(problem, sights, points, of) if of else FirstSight()
    return replace(seen, failing=failing if failing > POINTS // 2 else 0)


def _seen(
    problem: Problem,
    sights: Mapping[str, RecordSight],
    points: Sequence[FloatArray],
    of: Mapping[str, FloatArray],
) -> FirstSight:
    """Return what distances say, those of each record as declared and in other units, (points, scales + cut-offs)."""
    scales = (1.0, *SCALES)
    coarse = {name: some for name, some in of.items() if sights[name].command.microsteps <= COARSE}
    low_passed = _behind_low_pass({name: np.min(some, axis=0) for name, some in coarse.items()}, len(scales))
    of = {name: some[:, : len(scales)] for name, some in of.items()}
    total = np.sum(np.sqrt(list(of.values())), axis=0)
    least = np.min(total, axis=0)
    common = int(np.argmin(least))
    if low_passed and len(low_passed) == len(coarse) > 1:
        return FirstSight(cut_off_hz=low_passed)
    if common and least[0] > COMMON * least[common]:
        return FirstSight(scales[common])
    best = np.argsort(total[:, 0], kind="stable")[:BEST]
    at = _Comparison(problem, [points[i] for i in best], {name: sights[name] for name in of})
    seen = at.otherwise({name: distances[best] for name, distances in of.items()})
    return replace(seen, cut_off_hz={name: hz for name, hz in low_passed.items() if name not in seen.otherwise})


def _behind_low_pass(least: Mapping[str, FloatArray], scales: int) -> dict[str, float]:
    """Return the records that are plainly nearer behind a low-pass than in any unit, each with its cut-off.

    `least` are the least distances of a record over the points, (scales + cut-offs,): of those in full or half steps,
    since microsteps leave the spectrum too empty to tell.
    """
    found = {}
    for name, some in least.items():
        plain, behind = some[:scales], some[scales:]
        if behind.size and plain.min() > LOW_PASS * behind.min():
            found[name] = CUT_OFFS_HZ[int(np.argmin(behind))]
    return found


def _declared(
    problem: Problem,
    points: Sequence[FloatArray],
    scales: Sequence[float],
    cut_offs: Sequence[float],
    sight: RecordSight,
) -> FloatArray:
    """Return how far off a record is as declared, in other units and behind low-passes, (points, scales + cut-offs)."""
    powers = (sight.modelled(problem, sight.target, q) for q in points)
    return np.array([[*sight.distances(one, scales), *sight.distances_behind(one, cut_offs)] for one in powers])


@dataclass(frozen=True)
class _Comparison:
    """Readings of the records beside their declarations, at points that fit all of them best as declared."""

    problem: Problem
    points: Sequence[FloatArray]
    sights: Mapping[str, RecordSight]

    def otherwise(self, distances: Mapping[str, FloatArray]) -> FirstSight:
        """Return the readings that are plainly nearer; two records swapped are one cause for both.

        `distances` are those as declared, (points, scales) by record.
        """
        declared = {name: float(some[:, 0].min()) for name, some in distances.items()}
        each = in_threads(
            lambda name: self._single(self.sights[name], distances[name]), list(distances), self.problem.workers
        )
        singles = dict(zip(distances, each, strict=True))
        swapped = self._swapped(declared, {name: off for name, (off, _) in singles.items()})
        otherwise = {**{name: taken for name, (_, taken) in singles.items() if taken != DECLARED}, **swapped}
        doubtful = {name for name, taken in otherwise.items() if self._is_doubtful(name, taken, distances[name])}
        partners = {name for name, taken in otherwise.items() if taken.swapped in doubtful}
        return FirstSight(1.0, otherwise, frozenset(doubtful | partners))

    def _is_doubtful(self, name: str, taken: Reading, distances: FloatArray) -> bool:
        """Tell whether another reading of the same kind is as good: another unit, or half or twice the rate."""
        if taken.scale == 1.0:
            return is_doubtful_rate(self.sights[name], taken)
        least = distances[:, 1:].min(axis=0)
        rivals = (k for k, scale in enumerate(SCALES) if scale != taken.scale and (scale > 1.0) == (taken.scale > 1.0))
        return any(least[k] < RIVAL * least[SCALES.index(taken.scale)] for k in rivals)

    def _distance(self, sight: RecordSight, taken: Reading, declared: float) -> float:
        """Return how far off a record is as read; at the first point alone where that is far from the declared one."""
        least, read = math.inf, sight.read_as(taken)
        for q in self.points:
            least = min(least, *sight.distances(sight.modelled(self.problem, read, q), [1.0]))
            if least > GIVEN_UP * declared:
                break
        return least

    def _swapped(self, declared: Mapping[str, float], singles: Mapping[str, float]) -> dict[str, Reading]:
        """Return the two records that are nearer by each other's command, the clearest such pair.

        None where each by itself is nearer still in another way, where its own lines are at another rate, or where no
        own line speaks against what is declared.
        """
        found: list[tuple[float, dict[str, Reading]]] = []
        spoken = {name for name in declared if contradicts(self.sights[name])}
        for pair in combinations(declared, 2):
            if spoken.isdisjoint(pair):
                continue
            taken = {name: _driven_as(self.sights[other].whole) for name, other in zip(pair, pair[::-1], strict=True)}
            if all(
                command_as_read(self.sights[name].command, taken[name]) == self.sights[name].command for name in pair
            ):
                continue
            off = sum(self._distance(self.sights[name], taken[name], declared[name]) for name in pair)
            before = sum(declared[name] for name in pair)
            if before > SWAP * off and off <= AS_WELL * sum(singles[name] for name in pair):
                found.append((before / off, taken))
        _, best = max(found, key=lambda one: one[0], default=(0.0, {}))
        agreed = all(is_driven_so(self.sights[name], taken, FULL_STEPS) for name, taken in best.items())
        return best if agreed else {}

    def _single(self, sight: RecordSight, distances: FloatArray) -> tuple[float, Reading]:
        """Return the likeliest reading of one record by itself, and how far off it is; the declared one mostly."""
        declared = float(distances[:, 0].min())
        units = [(float(distances[:, k].min()), UNIT, Reading(scale=scale)) for k, scale in enumerate(SCALES, 1)]
        others = _other_commands(sight)
        commands = [(self._distance(sight, taken, declared), limit, taken) for limit, taken in others]
        plain = [(off, taken) for off, limit, taken in (*units, *commands) if declared > limit * off]
        return min(plain, key=lambda one: one[0], default=(declared, DECLARED))


def _driven_as(other: Target) -> Reading:
    command = other.command
    return Reading(
        rate=command.rate,
        stepping=command.stepping,
        microsteps=command.microsteps,
        start_angle_deg=command.start_angle_deg,
        swapped=other.name,
    )


def _other_commands(sight: RecordSight) -> list[tuple[float, Reading]]:
    """Return what a record's command may be instead, each with how much nearer it has to be."""
    command, own = sight.command, sight.own
    full = own is not None and own.stepping == "full"
    steppings = []
    if command.microsteps <= COARSE and not full:
        steppings = [Reading(stepping="micro", microsteps=USUAL_MICROSTEPS)]
    elif command.microsteps > COARSE and full:
        steppings = [Reading(stepping="full", microsteps=1), Reading(stepping="half", microsteps=2)]
    return [
        *((STEPPING, taken) for taken in steppings),
        *((RATE, Reading(rate=rate)) for rate in own_rates(sight)),
    ]
