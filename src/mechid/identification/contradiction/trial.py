"""Short search over the first steps of some records, as declared or read otherwise.

A spectrum, a rest or a level may suggest what is wrong with a declaration, and a file that was misread suggests causes
that it does not have. The search tells them apart: with the right cause the first steps are explained to the noise, or
to what the model lacks; with a wrong one hardly more than by a model that does not move.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.computation.parallel import in_threads
from mechid.identification.contradiction.alternatives import first_moments
from mechid.identification.output_error.declaration import DECLARED, Reading, target_as_read
from mechid.identification.output_error.misfit import Window
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.target import Target
from mechid.identification.search.box import sample_box
from mechid.identification.search.first_moments import first_window, robust_cost
from mechid.identification.search.multistart import Candidate, capped_costs, first_energy, refine
from mechid.identification.search.settings import SEARCH
from mechid.kernel.batch.source import SETS

POINTS, STARTS, STEPS = 512, 6, 24
"""Points of the box, those of them that are refined, and robust steps of each. A trial of one record takes 0.4 s of
CPU; with four starts 1 of 12 right records stayed at 84 sigmas squared a sample."""
LONGEST_S = 1.0
"""Of a record that is searched over, s: it bounds the time of a trial at slow rates. A choice, not measured."""
STRONGEST = 3
"""Records that a trial of all records covers. A choice, not measured."""
SHARE = 0.25
"""Of the cost of a model that does not move, up to which a search follows a record. Right readings came to 0.20 at
most with models that lack the housing or all detents, misread files to 0.26 and more."""
GAIN = 1.5
"""Times the cost as declared over that of a remedy that helps. Right remedies came to 4.2 at least with a complete
model, and to 1.5 where it lacks a detent and steps are read as microsteps."""


@dataclass(frozen=True)
class Trial:
    """Result of a short search.

    Attributes
    ----------
    best : Candidate
        The best start, refined.
    cost : float
        Its robust cost a sample, sigmas squared.
    still : float
        That of a model that does not move.
    """

    best: Candidate
    cost: float
    still: float

    @property
    def explains(self) -> bool:
        """Whether the records are explained to their noise."""
        return self.cost <= SEARCH.good_cost

    @property
    def follows(self) -> bool:
        """Whether most of the records is explained."""
        return self.explains or self.cost <= SHARE * self.still

    def is_better_than(self, other: Trial) -> bool:
        """Tell whether it explains clearly more, and most of the records at all."""
        return self.follows and other.cost > GAIN * max(self.cost, 1.0)


def trials(problem: Problem, readings: Sequence[Mapping[str, Reading]]) -> list[Trial]:
    """Search for a start under each of several readings of the same records, all over the same samples.

    Parameters
    ----------
    problem : Problem
        All records as declared.
    readings : sequence of mapping of record to Reading
        Of one or more records; `DECLARED` is a reading too.
    """
    read = [[target_as_read(t, one[t.name]) for t in problem.targets if t.name in one] for one in readings]
    windows: dict[str, Window] = {}
    for target in (t for targets in read for t in targets):
        first, stop = steps_window(target)
        known = windows.get(target.name, (first, stop))
        windows[target.name] = min(first, known[0]), max(stop, known[1])
    return in_threads(lambda targets: search_start(problem, targets, windows), read, problem.workers)


def declared(names: Sequence[str]) -> dict[str, Reading]:
    """Return the reading of records as they are declared."""
    return dict.fromkeys(names, DECLARED)


def strongest(targets: Sequence[Target]) -> list[Target]:
    """Return the records whose first windows stand out of their noise most, three at most."""
    return sorted(targets, key=first_energy, reverse=True)[:STRONGEST]


def steps_window(target: Target) -> Window:
    """Return the samples that a trial covers: from the first window to 60 ms behind the second full step."""
    first, stop = first_window(target)
    most = first + round(LONGEST_S * target.base.sample_rate_hz)
    return first, min(max(stop, first_moments(target)), most, target.samples)


def search_start(
    problem: Problem, targets: Sequence[Target], windows: Windows, points: Sequence[FloatArray] = ()
) -> Trial:
    """Return the best start for some records over their windows, from points of the box or from given ones."""
    part = replace(problem, targets=tuple(targets), workers=1)
    tail = part.coordinates.of_records(part.start)
    drawn = points or [np.concatenate([row, tail]) for row in sample_box(part.space, POINTS, 0)]
    costs: list[float] = []
    for first in range(0, len(drawn), SETS):
        cap = sorted(costs)[STARTS - 1] if len(costs) >= STARTS else math.inf
        costs += capped_costs(part, drawn[first : first + SETS], targets=part.targets, cap=cap, windows=windows)
    order = [i for i in np.argsort(costs, kind="stable")[:STARTS] if math.isfinite(costs[i])]
    best, (still, samples) = Candidate(part.start, math.inf), _still_cost(part.targets, windows)
    for i in order:
        found = refine(part, Candidate(drawn[i], costs[i]), steps=STEPS, windows=windows)
        best = min(best, found, key=lambda one: one.cost)
        if best.cost <= SEARCH.good_cost * samples:
            break
    return Trial(best, best.cost / samples, still / samples)


def _still_cost(targets: Sequence[Target], windows: Windows) -> tuple[float, int]:
    """Return the robust cost of a model that does not move, and the samples of all channels."""
    cost, samples = 0.0, 0
    for target in targets:
        first, stop = windows[target.name]
        for channel in target.channels:
            off = np.array(channel.measured[first:stop]) / channel.sigma
            off -= np.median(off) if channel.linear else 0.0
            off[channel.rejected_within((first, stop))] = 0.0
            cost += robust_cost(off)
            samples += off.size
    return cost, max(samples, 1)
