"""Records that contradict the others: found by leaving them out, and taken for what the others' model follows.

One record of the other polarity, run backwards, or started elsewhere stops the search of all: no start explains it
together with the others. So where the first start does not grow to the ends of all records, the records are tried
without one or more of them. What the rest agrees on then judges those left out. Nothing of this runs where the
records agree, and records that differ from their declaration all alike agree.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain, combinations

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.computation.journal import Journal
from mechid.identification.computation.parallel import mapped
from mechid.identification.contradiction.alternatives import LONG, ReadingScore, first_moments, judge
from mechid.identification.contradiction.bent_sensor import bend_words
from mechid.identification.output_error.declaration import DECLARED, Reading, problem_as_read, target_as_read
from mechid.identification.output_error.problem import Problem
from mechid.identification.search.box import sample_box
from mechid.identification.search.first_moments import first_residual, first_samples, robust_cost
from mechid.identification.search.gates import Growth, grow_horizons
from mechid.identification.search.multistart import Candidate, refine
from mechid.identification.search.settings import SEARCH

Tell = Callable[[str], None]
BATCHES = 4
"""Batches of starts refined before some records are believed not to agree either; a choice, not measured."""
TRIED = 3
"""Readings of a record, besides the declared one, that are grown together with the others; a choice, not measured."""


@dataclass(frozen=True)
class Agreement:
    """The problem with its records as they were taken, how far it is followed, and what was decided.

    Attributes
    ----------
    problem : Problem
    growth : Growth
    judged : mapping of record name to (declared, taken)
        Of the records that are taken otherwise than declared.
    left_out : mapping of record name to str
        Records that the others' model follows in no reading; what they look like beside it, a clause or nothing.
    """

    problem: Problem
    growth: Growth
    judged: Mapping[str, tuple[ReadingScore, ReadingScore]] = field(default_factory=dict)
    left_out: Mapping[str, str] = field(default_factory=dict)

    @property
    def taken(self) -> dict[str, Reading]:
        """How the records were taken, those that are not as declared."""
        own = {name: after.taken for name, (_, after) in self.judged.items()}
        return {**own, **{name: Reading(left_out=True) for name in self.left_out}}


@dataclass(frozen=True)
class _Rest:
    """Records that agree, how far they are followed together, and the names of the others."""

    problem: Problem
    growth: Growth
    others: tuple[str, ...]


def agreement(
    problem: Problem,
    growth: Growth,
    seed: int,
    *,
    explained: bool,
    tell: Tell = lambda line: None,
    journal: Journal | None = None,
) -> Agreement | None:
    """Return what the records agree on where some of them contradict the others, or None where none does.

    Parameters
    ----------
    problem : Problem
        All records as declared.
    growth : Growth
        From the best start, not complete.
    seed : int
    explained : bool
        Whether that start explains the first 60 ms of all records: then only those may contradict that it does not
        follow through their first moments.
    tell : callable
        Called with a line on what is tried.
    journal : Journal or None
        Of the growths, where a run is to be resumed.
    """
    looks = {t.name: first_moments(t) for t in problem.targets}
    suspects = [name for name, look in looks.items() if not explained or growth.horizons[name] < look]
    if len(looks) < 2 or not suspects:
        return None
    rest = _rest(problem, suspects, looks, seed, tell, journal)
    return _agreed(problem, rest, looks, seed, tell, journal) if rest else None


def agreement_without(
    problem: Problem,
    names: Sequence[str],
    q: FloatArray,
    seed: int,
    tell: Tell = lambda line: None,
    journal: Journal | None = None,
) -> Agreement | None:
    """Return what the records agree on but for some of them, from a point near by; None where they do not agree.

    Parameters
    ----------
    problem : Problem
        All records as declared.
    names : sequence of str
        Those that may contradict the others. Their first moments may be followed all the same: they are judged over all
        of a record.
    q : (n,)
        Where the others are nearly followed.
    seed : int
    tell, journal
        As of `agreement`.
    """
    looks = {t.name: min(t.samples, LONG) for t in problem.targets}
    others = problem.only([name for name in looks if name not in names])
    grown = grow_horizons(others, carried(problem, q, others), np.random.default_rng((seed, 1, 1)), journal=journal)
    rest = _Rest(others, grown, tuple(names))
    return _agreed(problem, rest, looks, seed, tell, journal) if grown.complete else None


def _agreed(
    problem: Problem, rest: _Rest, looks: Mapping[str, int], seed: int, tell: Tell, journal: Journal | None
) -> Agreement:
    """Return all records with those that contradict the rest as these tell that they were."""
    judged: dict[str, tuple[ReadingScore, ReadingScore]] = {}
    lost: dict[str, str] = {}
    for name in rest.others:
        tell(f"record {name} against the others")
        declared, found = _reading(problem, rest, name, looks[name], seed, journal)
        if found is None:
            target = next(t for t in problem.targets if t.name == name)
            lost[name] = bend_words(rest.problem, rest.growth.q, target.beginning(looks[name]))
        elif found.taken != DECLARED:
            judged[name] = declared, found
    made = Agreement(problem, rest.growth, judged, lost)
    whole = problem_as_read(problem, made.taken)
    grown = grow_horizons(
        whole, carried(rest.problem, rest.growth.q, whole), np.random.default_rng((seed, 1, 0)), journal=journal
    )
    return replace(made, problem=whole, growth=grown)


def explains(problem: Problem, start: Candidate) -> bool:
    """Tell whether a refined start explains the first window of all records."""
    firsts = (first_samples(t) * len(t.channels) for t in problem.targets)
    return start.cost <= SEARCH.good_cost * sum(firsts)


def carried(problem: Problem, q: FloatArray, to: Problem) -> FloatArray:
    """Return the point of another problem with the same mechanism, what is new of its records at its start."""
    at = problem.coordinates
    known = dict(zip(at.own_names, at.of_records(q).tolist(), strict=True))
    return np.concatenate([at.of_mechanism(q), to.coordinates.records_point(known)])


def _rest(
    problem: Problem, suspects: list[str], looks: Mapping[str, int], seed: int, tell: Tell, journal: Journal | None
) -> _Rest | None:
    """Return the most records that agree, found by leaving out one suspect, then two, fewer than half of all.

    Of two records that contradict each other the first is believed: it fixes the frame.
    """
    points = start_points(problem, seed)
    costs = _first_look(problem, points)
    furthest: _Rest | None = None
    for others in _left_out(suspects, list(looks), costs):
        rest = problem.only([name for name in looks if name not in others])
        tell(f"without {', '.join(others)}")
        start = _explaining(problem, rest, points, costs)
        if start is None:
            continue
        grown = grow_horizons(rest, start.q, np.random.default_rng((seed, 1, 1)), journal=journal)
        if grown.complete:
            return _Rest(rest, grown, others)
        if furthest is None and all(n >= looks[name] for name, n in grown.horizons.items()):
            furthest = _Rest(rest, grown, others)
    return furthest


def _left_out(suspects: list[str], names: list[str], costs: FloatArray) -> list[tuple[str, ...]]:
    """Return which records to leave out: fewest first, then those whose others contradict each other least."""
    if len(names) == 2:
        return [(name,) for name in suspects[::-1]]

    def discord(others: tuple[str, ...]) -> tuple[int, float]:
        own = costs[:, [name not in others for name in names]]
        return len(others), float(own.sum(axis=1).min() - own.min(axis=0).sum())

    most = (len(names) - 1) // 2
    return sorted(chain.from_iterable(combinations(suspects, size) for size in range(1, most + 1)), key=discord)


def explaining_start(problem: Problem, points: list[FloatArray]) -> Candidate | None:
    """Return a start, refined, of points that explains the first window of all records, or None."""
    return _explaining(problem, problem, points, _first_look(problem, points))


def start_points(problem: Problem, seed: int) -> list[FloatArray]:
    """Return the points of the multi-start, all with the records' own parameters at their start."""
    tail = problem.coordinates.of_records(problem.start)
    return [np.concatenate([row, tail]) for row in sample_box(problem.space, SEARCH.points, seed)]


def _first_look(problem: Problem, points: list[FloatArray]) -> FloatArray:
    """Return what the first window of each record costs at each point, (points, records)."""
    return np.array(mapped(partial(_first_costs, problem), points, problem.workers))


def _first_costs(problem: Problem, q: FloatArray) -> list[float]:
    """Return the robust cost of each record's first window."""
    return [robust_cost(first_residual(problem, t, q)) for t in problem.targets]


def _explaining(problem: Problem, rest: Problem, points: list[FloatArray], costs: FloatArray) -> Candidate | None:
    """Return a start, refined, that explains the first window of the records of `rest`, or None."""
    names = [t.name for t in problem.targets]
    own = costs[:, [names.index(t.name) for t in rest.targets]].sum(axis=1)
    order = [i for i in np.argsort(own, kind="stable")[: BATCHES * SEARCH.batch] if np.isfinite(own[i])]
    for first in range(0, len(order), SEARCH.batch):
        starts = [Candidate(carried(problem, points[i], rest), own[i]) for i in order[first : first + SEARCH.batch]]
        refined = mapped(partial(refine, rest, steps=SEARCH.robust_steps), starts, rest.workers)
        best = min(refined, key=lambda c: c.cost)
        if explains(rest, best):
            return best
    return None


def _reading(
    problem: Problem, rest: _Rest, name: str, look: int, seed: int, journal: Journal | None
) -> tuple[ReadingScore, ReadingScore | None]:
    """Return the declared reading of a record, and the one to be taken; None where none is followed.

    Mostly the others' model follows one reading at once. Where it does not, the others may not tell all that this
    record shows: then the likeliest are grown together with them, the declared one first.
    """
    target = next(t for t in problem.targets if t.name == name)
    declared, *others = judge(rest.problem, rest.growth.q, target, look)
    for found in (declared, *others[:1]):
        if found.follows:
            return declared, found
    for number, option in enumerate((declared, *others[:TRIED]), 2):
        own = target if option.taken == DECLARED else target_as_read(target, option.taken)
        more = replace(rest.problem, targets=(*rest.problem.targets, own))
        start = carried(rest.problem, rest.growth.q, more)
        if grow_horizons(more, start, np.random.default_rng((seed, 1, number)), journal=journal).horizons[name] >= look:
            return declared, option
    return declared, None
