"""Detection and reinterpretation of records that contradict the others.

One record of the other polarity, run backwards, or started elsewhere stops the search of all: no start explains it
together with the others. So where the first start does not grow to the ends of all records, the search is repeated
without one or more of them, and the model of the rest judges those left out. None of this runs where the records
agree; records that all differ from their declaration in the same way agree too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain, combinations

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign import Campaign, CampaignRecord
from mechid.identification.computation.journal import Journal
from mechid.identification.computation.parallel import map_tasks
from mechid.identification.output_error.declaration import DECLARED, Reading, reinterpret_problem, reinterpret_target
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import target_of
from mechid.identification.readings.alternatives import ReadingScore, describe_saturation, judge
from mechid.identification.readings.finding import Confidence, Finding, reading_words
from mechid.identification.readings.rules import RULES
from mechid.identification.readings.trial import first_moments
from mechid.identification.search.box import sample_box
from mechid.identification.search.first_moments import first_residuals, first_samples, robust_costs
from mechid.identification.search.gates import Growth, grow_horizons
from mechid.identification.search.multistart import Candidate, refine
from mechid.identification.search.settings import SEARCH
from mechid.kernel.batch.source import SETS
from mechid.units import unit_words

Tell = Callable[[str], None]


@dataclass(frozen=True)
class Agreement:
    """A problem with reinterpreted records, its growth, and the decision on each record.

    Attributes
    ----------
    problem : Problem
    growth : Growth
    scores : mapping of record name to (declared, taken)
        Scores of the records that are read otherwise than declared.
    left_out : mapping of record name to str
        Records that the others' model follows in no reading, each with a clause on its misfit, which may be empty.
    """

    problem: Problem
    growth: Growth
    scores: Mapping[str, tuple[ReadingScore, ReadingScore]] = field(default_factory=dict)
    left_out: Mapping[str, str] = field(default_factory=dict)

    @property
    def readings(self) -> dict[str, Reading]:
        """Readings of the records that are not read as declared."""
        own = {name: after.reading for name, (_, after) in self.scores.items()}
        return {**own, **{name: Reading(left_out=True) for name in self.left_out}}


@dataclass(frozen=True)
class _AgreeingRecords:
    """Records that agree, their common growth, and the names of the other records."""

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
    """Return the agreement of most records where some contradict the others; None where none does.

    Parameters
    ----------
    problem : Problem
        All records as declared.
    growth : Growth
        Growth from the best start, not complete.
    seed : int
    explained : bool
        Whether that start explains the first 60 ms of all records: then only records that it does not follow through
        their first moments are suspects.
    tell : callable
        Called with a line on each attempt.
    journal : Journal or None
        Stores the growths, so that a run can be resumed.
    """
    looks = {t.name: first_moments(t) for t in problem.targets}
    suspects = [name for name, look in looks.items() if not explained or growth.horizons[name] < look]
    if len(looks) < 2 or not suspects:
        return None
    rest = _find_agreeing(problem, suspects, looks, seed, tell, journal)
    return _judge_others(problem, rest, looks, seed, tell, journal) if rest else None


def agreement_of_others(
    problem: Problem,
    names: Sequence[str],
    q: FloatArray,
    seed: int,
    tell: Tell = lambda line: None,
    journal: Journal | None = None,
) -> Agreement | None:
    """Return the agreement of all records but some, from a point near by; None where the others do not agree.

    Parameters
    ----------
    problem : Problem
        All records as declared.
    names : sequence of str
        Records that may contradict the others. Their first moments may be followed nevertheless, so they are judged
        over the whole record.
    q : (n,)
        Point at which the others are nearly followed.
    seed : int
    tell, journal
        As in `agreement`.
    """
    looks = {t.name: min(t.samples, RULES.judged_samples) for t in problem.targets}
    others = problem.restrict_to([name for name in looks if name not in names])
    start = others.point_from(problem, q)
    grown = grow_horizons(others, start, np.random.default_rng((seed, 1, 1)), journal=journal)
    rest = _AgreeingRecords(others, grown, tuple(names))
    return _judge_others(problem, rest, looks, seed, tell, journal) if grown.complete else None


def _judge_others(
    problem: Problem, rest: _AgreeingRecords, looks: Mapping[str, int], seed: int, tell: Tell, journal: Journal | None
) -> Agreement:
    """Return the agreement in which the model of the rest has judged the other records."""
    scores: dict[str, tuple[ReadingScore, ReadingScore]] = {}
    lost: dict[str, str] = {}
    for name in rest.others:
        tell(f"record {name} against the others")
        declared, found = _choose_reading(problem, rest, name, looks[name], seed, journal)
        if found is None:
            target = next(t for t in problem.targets if t.name == name)
            lost[name] = describe_saturation(rest.problem, rest.growth.q, target.truncate(looks[name]))
        elif found.reading != DECLARED:
            scores[name] = declared, found
    made = Agreement(problem, rest.growth, scores, lost)
    # All records are grown again as they are now read: a reading is judged over its first moments only.
    whole = reinterpret_problem(problem, made.readings)
    grown = grow_horizons(
        whole, whole.point_from(rest.problem, rest.growth.q), np.random.default_rng((seed, 1, 0)), journal=journal
    )
    return replace(made, problem=whole, growth=grown)


def explains(problem: Problem, start: Candidate) -> bool:
    """Tell whether a refined start explains the first window of all records."""
    firsts = (first_samples(t) * len(t.channels) for t in problem.targets)
    return start.cost <= SEARCH.good_cost * sum(firsts)


def _find_agreeing(
    problem: Problem, suspects: list[str], looks: Mapping[str, int], seed: int, tell: Tell, journal: Journal | None
) -> _AgreeingRecords | None:
    """Find the largest set of agreeing records by leaving out one suspect, then two, up to fewer than half of all.

    Of two records that contradict each other, the first one counts: it fixes the reference.
    """
    points = start_points(problem, seed)
    costs = _first_look(problem, points)
    furthest: _AgreeingRecords | None = None
    for others in _sets_to_leave_out(suspects, list(looks), costs):
        rest = problem.restrict_to([name for name in looks if name not in others])
        tell(f"without {', '.join(others)}")
        start = _find_start(problem, rest, points, costs)
        if start is None:
            continue
        grown = grow_horizons(rest, start.q, np.random.default_rng((seed, 1, 1)), journal=journal)
        if grown.complete:
            return _AgreeingRecords(rest, grown, others)
        # Later than the first moments, a missing effect may stop the growth; the records agree all the same.
        if furthest is None and all(n >= looks[name] for name, n in grown.horizons.items()):
            furthest = _AgreeingRecords(rest, grown, others)
    return furthest


def _sets_to_leave_out(suspects: list[str], names: list[str], costs: FloatArray) -> list[tuple[str, ...]]:
    """Return the sets of records to leave out: fewest first, then those whose rest contradicts itself least."""
    # Of two records the later one is left out first: the first record fixes the reference.
    if len(names) == 2:
        return [(name,) for name in suspects[::-1]]

    def discord(others: tuple[str, ...]) -> tuple[int, float]:
        own = costs[:, [name not in others for name in names]]
        return len(others), float(own.sum(axis=1).min() - own.min(axis=0).sum())

    most = (len(names) - 1) // 2
    return sorted(chain.from_iterable(combinations(suspects, size) for size in range(1, most + 1)), key=discord)


def find_explaining_start(problem: Problem, points: list[FloatArray]) -> Candidate | None:
    """Return a refined start from some points that explains the first window of all records, or None."""
    return _find_start(problem, problem, points, _first_look(problem, points))


def start_points(problem: Problem, seed: int) -> list[FloatArray]:
    """Return the points of the multi-start, all with the records' own parameters at their start."""
    tail = problem.coordinates.of_records(problem.start)
    return [np.concatenate([row, tail]) for row in sample_box(problem.space, SEARCH.points, seed)]


def _first_look(problem: Problem, points: list[FloatArray]) -> FloatArray:
    """Return the cost of each record's first window at each point, (points, records)."""
    tasks = [points[k : k + SETS] for k in range(0, len(points), SETS)]
    return np.concatenate(map_tasks(partial(_first_window_costs, problem), tasks, problem.workers))


def _first_window_costs(problem: Problem, points: list[FloatArray]) -> FloatArray:
    """Return the robust cost of each record's first window at each point, (points, records)."""
    return np.stack([robust_costs(first_residuals(problem.model, t, points)) for t in problem.targets], axis=1)


def _find_start(problem: Problem, rest: Problem, points: list[FloatArray], costs: FloatArray) -> Candidate | None:
    """Return a refined start that explains the first window of the records of `rest`, or None."""
    names = [t.name for t in problem.targets]
    own = costs[:, [names.index(t.name) for t in rest.targets]].sum(axis=1)
    order = [i for i in np.argsort(own, kind="stable")[: RULES.start_batches * SEARCH.batch] if np.isfinite(own[i])]
    for first in range(0, len(order), SEARCH.batch):
        batch = order[first : first + SEARCH.batch]
        starts = [Candidate(rest.point_from(problem, points[i]), own[i]) for i in batch]
        refined = map_tasks(partial(refine, rest, steps=SEARCH.robust_steps), starts, rest.workers)
        best = min(refined, key=lambda c: c.cost)
        if explains(rest, best):
            return best
    return None


def _choose_reading(
    problem: Problem, rest: _AgreeingRecords, name: str, look: int, seed: int, journal: Journal | None
) -> tuple[ReadingScore, ReadingScore | None]:
    """Return the declared reading of a record, and the one to be used; None where none is followed.

    In most cases the others' model follows one reading at once. Where it does not, the others may not determine every
    parameter that this record depends on. The likeliest readings are then grown together with them, the declared first.
    """
    target = next(t for t in problem.targets if t.name == name)
    declared, *others = judge(rest.problem, rest.growth.q, target, look)
    for found in (declared, *others[:1]):
        if found.follows:
            return declared, found
    for number, option in enumerate((declared, *others[: RULES.grown_readings]), 2):
        own = target if option.reading == DECLARED else reinterpret_target(target, option.reading)
        more = replace(rest.problem, targets=(*rest.problem.targets, own))
        start = more.point_from(rest.problem, rest.growth.q)
        if grow_horizons(more, start, np.random.default_rng((seed, 1, number)), journal=journal).horizons[name] >= look:
            return declared, option
    return declared, None


def disagreements(campaign: Campaign, agreed: Agreement) -> Iterator[Finding]:
    """Yield a finding for each record that is read otherwise, then for each that is left out."""
    for name, (declared, found) in agreed.scores.items():
        yield _reading_finding(campaign.record(name), declared, found)
    for name, clause in agreed.left_out.items():
        why = clause or "no other sign, direction, start angle, time offset, gain or steps make their model follow it"
        yield Finding(
            (name,),
            "left out",
            f"left out of the fit: it contradicts the others, and {why}",
            'look at how it was recorded, or give it use = "validate"',
        )


def _reading_finding(record: CampaignRecord, declared: ReadingScore, found: ReadingScore) -> Finding:
    """Report a reading; the costs are over the record's first moments, under the others' model."""
    target = target_of(record)
    seconds = (found.samples - 1) / target.base.sample_rate_hz
    words, remedy = reading_words(record, found.reading)
    counted = found.samples * len(target.channels)
    before, after = (target.leading.sigma * math.sqrt(score.cost / counted) for score in (declared, found))
    return Finding(
        (record.name,),
        "contradicts the others",
        f"not followed as declared, but with {words}: under the model of the other records the residual of its first "
        f"{seconds:.3g} s is {before:.3g} {unit_words(record.leading)} RMS as declared and {after:.3g} as read here, "
        f"the log-likelihood higher by {0.5 * (declared.cost - found.cost):.3g}",
        f"if that is right, write {remedy} for it in the campaign file",
        Confidence.CONFIRMED,
        {record.name: found.reading},
    )
