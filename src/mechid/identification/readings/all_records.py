"""Common reinterpretations of all records, tried where no start follows them; they are reported, never used.

Reversing the sign of all torques is equivalent to reversing all commands. The waveform belongs to the drive. A trigger
that is late in all records may be the drive's or the recorder's. No record distinguishes these, so the user decides.
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
from mechid.identification.output_error.declaration import Reading, reinterpret_target
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target, time_offset_of
from mechid.identification.readings.agreement import find_explaining_start, start_points
from mechid.identification.readings.finding import Confidence, Finding
from mechid.identification.readings.rules import RULES
from mechid.identification.search.gates import Growth, grow_horizons
from mechid.parameter import Parameter
from mechid.simulation.simulator import excitation_over

SIGN = (
    "the torque of all records of the other sign: write gain = -1.0 for their torque channels, or the other sign of "
    "all rates"
)


def common_readings(problem: Problem, growth: Growth, seed: int, journal: Journal | None = None) -> list[Finding]:
    """Return the readings with which all records are followed much further than as declared.

    A reading is confirmed where all records are followed to their ends. The growths are stored in `journal`, so that a
    run can be resumed.
    """
    found: list[Finding] = []
    for tried in _common_candidates(problem, seed):
        other = tried.problem
        start = find_explaining_start(other, tried.points)
        if start is None:
            continue
        grown = grow_horizons(other, start.q, np.random.default_rng((seed, 2, len(found))), journal=journal)
        before, after, words = growth.followed_share(problem), grown.followed_share(other), tried.words(grown.q)
        if words and (after >= RULES.further_ratio * before or (grown.complete and not growth.complete)):
            text = (
                f"{100.0 * after:.3g} % of their samples are followed with {words} ({100.0 * before:.3g} % as declared)"
            )
            remedy = "mechid does not change all records by itself: identify again with it"
            confidence = Confidence.CONFIRMED if grown.complete else Confidence.OBSERVED
            found.append(Finding((), "common reading", text, remedy, confidence))
    return found


@dataclass(frozen=True)
class _CommonReading:
    """A reading of all records, its starting points, and its description at a point; empty where nothing differs."""

    problem: Problem
    points: list[FloatArray]
    words: Callable[[FloatArray], str]


def _common_candidates(problem: Problem, seed: int) -> Iterator[_CommonReading]:
    signs = replace(problem, targets=tuple(reinterpret_target(t, Reading(polarity=-1)) for t in problem.targets))
    yield _CommonReading(signs, start_points(signs, seed), lambda q: SIGN)
    # A measured input has neither a waveform nor a trigger of the drive.
    if any(isinstance(t.command, MeasuredCommand) for t in problem.targets):
        return
    waves = replace(problem, targets=tuple(map(_change_waveform, problem.targets)))
    names = sorted({t.command.waveform for t in waves.targets})
    yield _CommonReading(
        waves, start_points(waves, seed), lambda q: f'waveform = "{" or ".join(names)}" in the commands'
    )
    if not any(t.time_offset.is_free or t.time_offset.value for t in problem.targets):
        yield _delay_commands(problem, seed)


def _delay_commands(problem: Problem, seed: int) -> _CommonReading:
    """Return the records with a common time offset; its starting values are spread over its range."""
    offset = replace(time_offset_of("", 0.0, (-RULES.late_s, RULES.late_s)), name=f"{CAMPAIGN}.{TIME_OFFSET.key}")
    late = replace(problem, targets=tuple(_set_common_offset(t, offset) for t in problem.targets))
    own = late.coordinates
    points = start_points(problem, seed)
    offsets = np.random.default_rng((seed, 3)).uniform(-RULES.late_s, RULES.late_s, len(points))
    points = [
        np.concatenate([own.of_mechanism(point), own.records_point({offset.name: float(s)})])
        for point, s in zip(points, offsets, strict=True)
    ]

    def words(q: FloatArray) -> str:
        late_s = own.value(offset, q)
        if abs(late_s) < RULES.least_late_s:
            return ""
        way = "later" if late_s > 0.0 else "earlier"
        return f"their commands {1e3 * abs(late_s):.3g} ms {way}: write time_offset_s = {late_s:.4g} for each of them"

    return _CommonReading(late, points, words)


def _set_common_offset(target: Target, offset: Parameter) -> Target:
    own = target.with_time_offset(offset)
    return replace(own, excitation=excitation_over(own.command, own.base, own.latest_s))


def _change_waveform(target: Target) -> Target:
    other = next(w for w in WAVEFORMS if target.command.table or w != target.command.waveform)
    command = replace(target.command, waveform=other, table=())
    excitation = excitation_over(command, target.base, target.latest_s)
    return replace(target, command=command, excitation=excitation)
