"""Suspicions from spectra before any search: wrong rate, stepping or unit, a low-pass, two swapped records.

A record's spectrum shows the stepping of its motor, whatever the mechanism's values: full steps fill it with lines,
microsteps leave it nearly empty, and all lines are multiples of the step rate. So the model is simulated under the
declared command at a few points of the box in which the search starts, and under alternative commands at the points
that fit all records best. Spectra are compared on a logarithmic scale: values wrong by factors of two or three count
little, a unit wrong by a hundred or a thousand counts most, and phases and start angles do not count.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import combinations

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.computation.parallel import in_threads, map_tasks
from mechid.identification.output_error.declaration import DECLARED, Reading, reinterpret_command
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.readings.rules import RULES
from mechid.identification.readings.spectrum import (
    RecordSpectrum,
    contradicts_declaration,
    fits_declared_rate_too,
    has_lines_of,
    own_rates,
)
from mechid.identification.search.box import sample_box
from mechid.parameter import Role

SCALES = (1.0, *RULES.torque_scales)
"""Scales of the torque that are compared, the declared one first."""


@dataclass(frozen=True)
class Suspicions:
    """Declarations that the spectra contradict; no trial has confirmed them yet.

    Attributes
    ----------
    common_scale : float
        Factor by which the torque of all records seems to be wrong; 1 without suspicion.
    readings : mapping of record to Reading
        Likelier readings of single records.
    doubtful : frozenset of str
        Swapped records whose lines fit the declared rate as well.
    cut_off_hz : mapping of record to float
        Approximate cut-off frequencies of records that seem low-passed, where the mechanism has no such filter.
    failing : int
        Number of points of the box at which a record cannot be simulated, where these are most of them; else 0.
    """

    common_scale: float = 1.0
    readings: Mapping[str, Reading] = field(default_factory=dict)
    doubtful: frozenset[str] = frozenset()
    cut_off_hz: Mapping[str, float] = field(default_factory=dict)
    failing: int = 0


def suspect(problem: Problem, spectra: Mapping[str, RecordSpectrum], seed: int = 0) -> Suspicions:
    """Return the declarations that the spectra of records contradict.

    Parameters
    ----------
    problem : Problem
        All records as declared.
    spectra : mapping of record to RecordSpectrum
    seed : int
        Seed of the points of the box.
    """
    own = problem.coordinates.of_records(problem.start)
    points = [np.concatenate([q, own]) for q in sample_box(problem.space, RULES.box_points, seed)]
    cut_offs = () if problem.space.mechanism.plant.names_with_role(Role.CUT_OFF) else RULES.cut_offs_hz
    measure = partial(_distances, problem, points, cut_offs)
    found = dict(zip(spectra, map_tasks(measure, list(spectra.values()), problem.workers), strict=True))
    failing = int(np.sum(np.any([~np.isfinite(distances[:, 0]) for distances in found.values()], axis=0)))
    found = {name: distances for name, distances in found.items() if np.isfinite(distances[:, 0]).any()}
    seen = _suspect(problem, spectra, points, found) if found else Suspicions()
    return replace(seen, failing=failing if failing > RULES.box_points // 2 else 0)


def _suspect(
    problem: Problem,
    spectra: Mapping[str, RecordSpectrum],
    points: Sequence[FloatArray],
    distances: Mapping[str, FloatArray],
) -> Suspicions:
    """Return the suspicions from each record's distances, (points, scales + cut-offs)."""
    coarse = [name for name in distances if spectra[name].command.microsteps <= RULES.coarse_microsteps]
    low_passed = _find_low_passes({name: np.min(distances[name], axis=0) for name in coarse})
    distances = {name: some[:, : len(SCALES)] for name, some in distances.items()}
    total = np.sum(np.sqrt(list(distances.values())), axis=0)
    least = np.min(total, axis=0)
    common = int(np.argmin(least))
    # One filter or one unit for all records is a simpler cause than one for each: it is decided first.
    if low_passed and len(low_passed) == len(coarse) > 1:
        return Suspicions(cut_off_hz=low_passed)
    if common and least[0] > RULES.nearer_ratio * least[common]:
        return Suspicions(SCALES[common])
    best = np.argsort(total[:, 0], kind="stable")[: RULES.best_points]
    comparison = _Comparison(problem, [points[i] for i in best], {name: spectra[name] for name in distances})
    seen = comparison.suspect({name: some[best] for name, some in distances.items()})
    return replace(seen, cut_off_hz={name: hz for name, hz in low_passed.items() if name not in seen.readings})


def _find_low_passes(least: Mapping[str, FloatArray]) -> dict[str, float]:
    """Return the cut-off frequency of each record that a low-pass explains much better than any unit.

    `least` holds the least distances of records in full or half steps, (scales + cut-offs,): the nearly empty spectrum
    of microsteps does not show a low-pass.
    """
    found = {}
    for name, some in least.items():
        in_units, behind = some[: len(SCALES)], some[len(SCALES) :]
        if behind.size and in_units.min() > RULES.much_nearer_ratio * behind.min():
            found[name] = RULES.cut_offs_hz[int(np.argmin(behind))]
    return found


def _distances(
    problem: Problem, points: Sequence[FloatArray], cut_offs: Sequence[float], spectrum: RecordSpectrum
) -> FloatArray:
    """Return a record's distances as declared, in other units and behind low-passes, (points, scales + cut-offs)."""
    powers = (spectrum.simulated_power(problem, spectrum.target, q) for q in points)
    return np.array([[*spectrum.distances(p, SCALES), *spectrum.low_passed_distances(p, cut_offs)] for p in powers])


@dataclass(frozen=True)
class _Comparison:
    """Comparison of readings with the declarations, at the points that fit all declarations best."""

    problem: Problem
    points: Sequence[FloatArray]
    spectra: Mapping[str, RecordSpectrum]

    def suspect(self, distances: Mapping[str, FloatArray]) -> Suspicions:
        """Return the readings that are clearly nearer; a swap of two records is one cause for both.

        `distances` holds the distances of the declared readings, (points, scales), by record.
        """
        declared = {name: float(some[:, 0].min()) for name, some in distances.items()}
        each = in_threads(
            lambda name: self._likeliest_reading(self.spectra[name], distances[name]),
            list(distances),
            self.problem.workers,
        )
        singles = dict(zip(distances, each, strict=True))
        swapped = self._find_swap(declared, {name: distance for name, (distance, _) in singles.items()})
        readings = {**{name: one for name, (_, one) in singles.items() if one != DECLARED}, **swapped}
        doubtful = {name for name, one in swapped.items() if fits_declared_rate_too(self.spectra[name], one)}
        partners = {name for name, one in swapped.items() if one.swapped in doubtful}
        return Suspicions(1.0, readings, frozenset(doubtful | partners))

    def _distance(self, spectrum: RecordSpectrum, reading: Reading, declared: float) -> float:
        """Return a record's distance in a reading, the least over the points."""
        # A reading that is far off at the first point is not simulated at the others.
        least, read = math.inf, spectrum.read_as(reading)
        for q in self.points:
            least = min(least, *spectrum.distances(spectrum.simulated_power(self.problem, read, q), [1.0]))
            if least > RULES.much_nearer_ratio * declared:
                break
        return least

    def _find_swap(self, declared: Mapping[str, float], singles: Mapping[str, float]) -> dict[str, Reading]:
        """Return the readings of the two records that most clearly fit each other's command.

        Empty where single readings fit better still, where a record's own lines are at another rate, or where no line
        contradicts a declaration.
        """
        found: list[tuple[float, dict[str, Reading]]] = []
        contradicting = {name for name in declared if contradicts_declaration(self.spectra[name])}
        for pair in combinations(declared, 2):
            spectra = [self.spectra[name] for name in pair]
            # A reading holds rate and stepping of another command, but not its table.
            if any(spectrum.command.table for spectrum in spectra):
                continue
            commands = [_command_of(spectrum.whole) for spectrum in spectra[::-1]]
            if contradicting.isdisjoint(pair) or all(
                reinterpret_command(spectrum.command, one) == spectrum.command
                for spectrum, one in zip(spectra, commands, strict=True)
            ):
                continue
            readings = dict(zip(pair, commands, strict=True))
            distance = sum(self._distance(self.spectra[name], readings[name], declared[name]) for name in pair)
            before = sum(declared[name] for name in pair)
            alone = sum(singles[name] for name in pair)
            if before > RULES.nearer_ratio * distance and distance <= RULES.stepping_ratio * alone:
                found.append((before / distance, readings))
        _, best = max(found, key=lambda one: one[0], default=(0.0, {}))
        agreed = all(has_lines_of(self.spectra[name], one, RULES.full_step_lines) for name, one in best.items())
        return best if agreed else {}

    def _likeliest_reading(self, spectrum: RecordSpectrum, distances: FloatArray) -> tuple[float, Reading]:
        """Return the distance and the likeliest reading of a single record, in most cases the declared one."""
        declared = float(distances[:, 0].min())
        units = [
            (float(distances[:, k].min()), RULES.much_nearer_ratio, Reading(scale=scale))
            for k, scale in enumerate(SCALES[1:], 1)
        ]
        others = [(self._distance(spectrum, one, declared), least, one) for least, one in _other_commands(spectrum)]
        nearer = [(distance, one) for distance, least, one in (*units, *others) if declared > least * distance]
        return min(nearer, key=lambda one: one[0], default=(declared, DECLARED))


def _command_of(other: Target) -> Reading:
    command = other.command
    return Reading(
        rate=command.rate,
        stepping=command.stepping,
        microsteps=command.microsteps,
        start_angle_deg=command.start_angle_deg,
        swapped=other.name,
    )


def _other_commands(spectrum: RecordSpectrum) -> list[tuple[float, Reading]]:
    """Return alternative commands of a record, each with the ratio of distances that it has to reach."""
    command, own = spectrum.command, spectrum.suggested_rate
    full = own is not None and own.stepping == "full"
    steppings = []
    if command.microsteps <= RULES.coarse_microsteps and not full:
        steppings = [Reading(stepping="micro", microsteps=RULES.tried_microsteps)]
    elif command.microsteps > RULES.coarse_microsteps and full:
        steppings = [Reading(stepping="full", microsteps=1), Reading(stepping="half", microsteps=2)]
    return [
        *((RULES.stepping_ratio, one) for one in steppings),
        *((RULES.nearer_ratio, Reading(rate=rate)) for rate in own_rates(spectrum)),
    ]
