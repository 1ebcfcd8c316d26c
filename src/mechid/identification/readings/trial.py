"""Short search over the first steps of some records, as declared or reinterpreted.

A spectrum, a rest or a level may suggest the error of a declaration, but a file that was misread suggests wrong causes.
The search separates them. With the right cause the first steps are explained down to the noise, or to the model error;
with a wrong one hardly better than by a model at rest.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.command.edges import steps_travelled
from mechid.identification.computation.parallel import in_threads
from mechid.identification.effects.effect import add_terms, share_kernel
from mechid.identification.output_error.declaration import DECLARED, Reading, reinterpret_target
from mechid.identification.output_error.misfit import Window
from mechid.identification.output_error.problem import Problem, Windows, transfer_values
from mechid.identification.output_error.target import Target
from mechid.identification.readings.rules import RULES
from mechid.identification.search.alignment import align_all_first_motions
from mechid.identification.search.box import sample_box
from mechid.identification.search.first_moments import first_window, robust_cost
from mechid.identification.search.multistart import Candidate, capped_costs, first_energy, refine
from mechid.identification.search.settings import SEARCH
from mechid.kernel.batch.source import SETS
from mechid.plant.superset import superset_of


@dataclass(frozen=True)
class Trial:
    """Result of a short search.

    Attributes
    ----------
    best : Candidate
        The best start, refined.
    cost : float
        Robust cost per sample at that start, sigmas squared.
    resting : float
        Robust cost per sample of a model at rest, sigmas squared.
    """

    best: Candidate
    cost: float
    resting: float

    @property
    def explains(self) -> bool:
        """Whether the model explains the records down to their noise."""
        return self.cost <= SEARCH.good_cost

    @property
    def follows(self) -> bool:
        """Whether the model explains most of the records' motion."""
        return self.explains or self.cost <= RULES.follows_share * self.resting

    def is_better_than(self, other: Trial) -> bool:
        """Tell whether it explains most of the records' motion, and clearly more than another trial."""
        return self.follows and other.cost > RULES.trial_gain * max(self.cost, 1.0)


def compare_readings(
    problem: Problem, readings: Sequence[Mapping[str, Reading]], *, with_terms: bool = False
) -> list[Trial]:
    """Search for a start under each of several readings of the same records, all over the same samples.

    Parameters
    ----------
    problem : Problem
        All records as declared.
    readings : sequence of mapping of record to Reading
        Readings of one or more records; `DECLARED` is a reading too.
    with_terms : bool
        Whether the best start is refined with all optional terms of the mechanism's blocks free, so that a missing term
        is not mistaken for a wrong declaration.
    """
    read = [[reinterpret_target(t, one[t.name]) for t in problem.targets if t.name in one] for one in readings]
    # One window a record for all readings, since their costs are compared.
    windows: dict[str, Window] = {}
    for target in (t for targets in read for t in targets):
        first, stop = steps_window(target)
        known = windows.get(target.name, (first, stop))
        windows[target.name] = min(first, known[0]), max(stop, known[1])

    def search(targets: Sequence[Target]) -> Trial:
        found = search_start(problem, targets, windows)
        return _refine_with_terms(problem, targets, windows, found) if with_terms else found

    return in_threads(search, read, problem.workers)


def declared_readings(names: Sequence[str]) -> dict[str, Reading]:
    """Return the declared reading of each record."""
    return dict.fromkeys(names, DECLARED)


def strongest_records(targets: Sequence[Target]) -> list[Target]:
    """Return the few records whose first windows have the highest energy relative to their noise."""
    return sorted(targets, key=first_energy, reverse=True)[: RULES.trial_records]


def samples_until(target: Target, steps: float) -> int:
    """Return the samples until the command has travelled `steps` full steps; all samples where it never does."""
    base = target.base

    def travel(k: int) -> float:
        time = base.start_s + np.array([k]) / base.sample_rate_hz - target.time_offset.value
        return float(steps_travelled(target.command.rate, time)[0])

    return bisect_left(range(base.samples), steps, key=travel)


def first_moments(target: Target) -> int:
    """Return the samples of a record's first moments: two full steps of travel and 60 ms after them."""
    after = round(SEARCH.first_window_s * target.base.sample_rate_hz)
    return min(samples_until(target, RULES.first_steps) + after, target.samples)


def steps_window(target: Target) -> Window:
    """Return the samples that a trial covers: from the first window to the end of the first moments."""
    first, stop = first_window(target)
    most = first + round(RULES.trial_s * target.base.sample_rate_hz)
    return first, min(max(stop, first_moments(target)), most, target.samples)


def search_start(
    problem: Problem, targets: Sequence[Target], windows: Windows, points: Sequence[FloatArray] = ()
) -> Trial:
    """Search for the best start of some records over their windows, from points of the box or from given ones."""
    part = replace(problem, targets=tuple(targets), workers=1)
    tail = part.coordinates.of_records(part.start)
    drawn = points or [np.concatenate([row, tail]) for row in sample_box(part.space, RULES.trial_points, 0)]
    align = not points  # given points come from a trial, whose records are aligned already
    costs: list[float] = []
    for first in range(0, len(drawn), SETS):
        # A point is abandoned as soon as its cost exceeds the worst of those that would be refined.
        cap = sorted(costs)[RULES.trial_starts - 1] if len(costs) >= RULES.trial_starts else math.inf
        some = drawn[first : first + SETS]
        costs += capped_costs(part, some, targets=part.targets, cap=cap, windows=windows, align=align)
    order = [i for i in np.argsort(costs, kind="stable")[: RULES.trial_starts] if math.isfinite(costs[i])]
    best, (still, samples) = Candidate(part.start, math.inf), _resting_cost(part.targets, windows)
    for i in order:
        at = align_all_first_motions(part, drawn[i]) if align else drawn[i]
        found = refine(part, Candidate(at, costs[i]), steps=RULES.trial_steps, windows=windows)
        best = min(best, found, key=lambda one: one.cost)
        if best.cost <= SEARCH.good_cost * samples:
            break
    return Trial(best, best.cost / samples, still / samples)


def _refine_with_terms(problem: Problem, targets: Sequence[Target], windows: Windows, found: Trial) -> Trial:
    """Refine the best start of a trial with all terms free, from their null values."""
    superset = superset_of(problem.space.mechanism, grown_only=True)
    if superset is None or not math.isfinite(found.cost):
        return found
    plain = replace(problem, targets=tuple(targets), workers=1)
    wide = share_kernel(add_terms(superset, [term.name for term in superset.terms]).problem(plain), superset)
    start = Candidate(transfer_values(plain, found.best.q, wide), found.best.cost)
    best = refine(wide, start, steps=RULES.trial_steps, windows=windows)
    # Written as "not <", so that the NaN of a wider model that cannot be simulated is refused too.
    if not best.cost < found.best.cost:
        return found
    # The samples are the same: the cost per sample scales with the cost.
    return replace(found, best=best, cost=best.cost * found.cost / found.best.cost)


def _resting_cost(targets: Sequence[Target], windows: Windows) -> tuple[float, int]:
    """Return the robust cost of a model at rest, and the samples of all channels."""
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
