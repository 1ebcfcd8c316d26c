"""What all records together may be otherwise than declared: tried where none is followed, told and never taken.

The other sign of all torques stands for the other direction of all commands as well, and which it is no record
tells; the waveform is the drive's, and a trigger that is late in all may be the drive's or the recorder's: hypotheses
for the user to settle.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign.campaign import CAMPAIGN, TIME_OFFSET
from mechid.command import MeasuredCommand
from mechid.command.waveform import WAVEFORMS
from mechid.identification.computation.journal import Journal
from mechid.identification.contradiction.agreement import explaining_start, start_points
from mechid.identification.output_error.declaration import Reading, target_as_read
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target, time_offset_of
from mechid.identification.search.gates import Growth, grow_horizons
from mechid.parameter import Parameter
from mechid.simulation.simulator import excitation_over

FURTHER = 2.0
"""Times as much of the records has to be followed to be told of; a choice, not measured."""
LATE_S, LEAST_LATE_S = 0.02, 1e-3
"""How early or late a trigger is looked for, and from where on it is told of: a filter that the mechanism file lacks
delays all records by less, and is looked for as such. Choices, not measured."""
SIGN = (
    "the torque of all records of the other sign: write gain = -1.0 for their torque channels, or the other sign of "
    "all rates"
)


@dataclass(frozen=True)
class CommonReading:
    """What all records may be otherwise: a line on it, and whether it is followed to the ends of them all."""

    line: str
    complete: bool


def common_readings(problem: Problem, growth: Growth, seed: int, journal: Journal | None = None) -> list[CommonReading]:
    """Return what follows all records much further than their declaration did.

    The growths are noted in `journal`, where a run is to be resumed.
    """
    found: list[CommonReading] = []
    for tried in _readings(problem, seed):
        other = tried.problem
        start = explaining_start(other, tried.points)
        if start is None:
            continue
        grown = grow_horizons(other, start.q, np.random.default_rng((seed, 2, len(found))), journal=journal)
        before, after = growth.reached(problem), grown.reached(other)
        words = tried.words(grown.q)
        if not words:
            continue
        if after >= FURTHER * before or (grown.complete and not growth.complete):
            line = (
                f"all records: {100.0 * after:.3g} % of their samples are followed with {words} "
                f"({100.0 * before:.3g} % as declared); mechid does not change all records by itself: identify again "
                "with it"
            )
            found.append(CommonReading(line, grown.complete))
    return found


@dataclass(frozen=True)
class _Tried:
    """What all records are tried as, the points to begin from, and how a point of it is told, in no word if not."""

    problem: Problem
    points: list[FloatArray]
    words: Callable[[FloatArray], str]


def _readings(problem: Problem, seed: int) -> Iterator[_Tried]:
    signs = replace(problem, targets=tuple(target_as_read(t, Reading(polarity=-1)) for t in problem.targets))
    yield _Tried(signs, start_points(signs, seed), lambda q: SIGN)
    if any(isinstance(t.command, MeasuredCommand) for t in problem.targets):
        return
    waves = replace(problem, targets=tuple(map(_of_other_waveform, problem.targets)))
    names = sorted({t.command.waveform for t in waves.targets})
    yield _Tried(waves, start_points(waves, seed), lambda q: f'waveform = "{" or ".join(names)}" in the commands')
    if not any(t.time_offset.is_free or t.time_offset.value for t in problem.targets):
        yield _all_late(problem, seed)


def _all_late(problem: Problem, seed: int) -> _Tried:
    """Return the records with one time offset for all, which the starts have somewhere in its range."""
    offset = replace(time_offset_of("", 0.0, (-LATE_S, LATE_S)), name=f"{CAMPAIGN}.{TIME_OFFSET.key}")
    late = replace(problem, targets=tuple(_with_offset(t, offset) for t in problem.targets))
    own = late.coordinates
    points = start_points(problem, seed)
    offsets = np.random.default_rng((seed, 3)).uniform(-LATE_S, LATE_S, len(points))
    points = [
        np.concatenate([own.of_mechanism(point), own.records_point({offset.name: float(s)})])
        for point, s in zip(points, offsets, strict=True)
    ]

    def words(q: FloatArray) -> str:
        late_s = own.value(offset, q)
        if abs(late_s) < LEAST_LATE_S:
            return ""
        way = "later" if late_s > 0.0 else "earlier"
        return f"their commands {1e3 * abs(late_s):.3g} ms {way}: write time_offset_s = {late_s:.4g} for each of them"

    return _Tried(late, points, words)


def _with_offset(target: Target, offset: Parameter) -> Target:
    own = target.with_time_offset(offset)
    return replace(own, excitation=excitation_over(own.command, own.base, own.latest_s))


def _of_other_waveform(target: Target) -> Target:
    other = next(w for w in WAVEFORMS if w != target.command.waveform)
    command = replace(target.command, waveform=other)
    excitation = excitation_over(command, target.base, target.latest_s)
    return replace(target, command=command, excitation=excitation)
