"""What all records together may be otherwise than declared: tried where none is followed, told and never taken.

The other sign of all torques stands for the other direction of all commands as well, and which it is no record
tells; the waveform is the drive's, a hypothesis for the user to settle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mechid.command import MeasuredCommand
from mechid.command.waveform import WAVEFORMS
from mechid.identification.computation.journal import Journal
from mechid.identification.contradiction.agreement import explaining_start
from mechid.identification.output_error.declaration import Reading, target_as_read
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.search.gates import Growth, grow
from mechid.simulation.simulator import excitation_over

FURTHER = 2.0
"""Times as much of the records has to be followed to be told of; a choice, not measured."""
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
    for words, other in _readings(problem):
        start = explaining_start(other, seed)
        if start is None:
            continue
        grown = grow(other, start.q, np.random.default_rng((seed, 2, len(found))), journal=journal)
        before, after = growth.reached(problem), grown.reached(other)
        if after >= FURTHER * before or (grown.complete and not growth.complete):
            line = (
                f"all records: {100.0 * after:.3g} % of their samples are followed with {words} "
                f"({100.0 * before:.3g} % as declared); mechid does not change all records by itself: identify again "
                "with it"
            )
            found.append(CommonReading(line, grown.complete))
    return found


def _readings(problem: Problem) -> list[tuple[str, Problem]]:
    signs = replace(problem, targets=tuple(target_as_read(t, Reading(polarity=-1)) for t in problem.targets))
    if any(isinstance(t.command, MeasuredCommand) for t in problem.targets):
        return [(SIGN, signs)]
    waves = replace(problem, targets=tuple(map(_of_other_waveform, problem.targets)))
    names = sorted({t.command.waveform for t in waves.targets})
    return [(SIGN, signs), (f'waveform = "{" or ".join(names)}" in the commands', waves)]


def _of_other_waveform(target: Target) -> Target:
    other = next(w for w in WAVEFORMS if w != target.command.waveform)
    command = replace(target.command, waveform=other)
    excitation = excitation_over(command, target.base, target.latest_s)
    return replace(target, command=command, excitation=excitation)
