"""Growth of the mechanism as written from the starts of a multi-start."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import islice
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.computation.journal import digest
from mechid.identification.computation.parallel import is_external
from mechid.identification.output_error.digests import identity
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.gates import Growth, grow_horizons
from mechid.identification.search.multistart import Candidate, candidates, multistart
from mechid.identification.search.settings import SEARCH
from mechid.identification.stages.departure import departure
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.watch import Watch
from mechid.identification.uncertainty.noise_levels import describe_raised_levels, raise_levels
from mechid.identification.uncertainty.visibility import describe_chaos, divergence_time_s


def refine_starts(
    watch: Watch, state: SearchState, seed: int, drawn: list[FloatArray] | None = None
) -> Iterator[Candidate]:
    """Yield refined candidates, the best of all starts first; `drawn` receives the starts before refinement."""
    whole, journal = state.problem, watch.journal
    problem = whole.rest_problem

    def on_progress(done: int, total: int) -> None:
        watch.tell("multi-start", f"{done} of {total} starts")

    starts = multistart(problem, seed, problem.workers, on_progress, journal)
    if drawn is not None:
        drawn += [whole.point_from(problem, each.q, whole.start) for each in starts]
    for number, found in enumerate(candidates(problem, starts, problem.workers, journal), 1):
        candidate = replace(found, q=whole.point_from(problem, found.q))
        if number == 1:
            watch.note(state.at(candidate.q))
            watch.tell("multi-start", f"{len(starts)} starts to be refined", candidate.cost)
        yield candidate


def refine_more_starts(watch: Watch, state: SearchState, seed: int) -> Candidate | None:
    """Return the best refined start behind the usual ones; None if none can be simulated."""
    return _refine_best(watch, state.problem, seed, SEARCH.starts, SEARCH.more_starts)


def refine_best_start(watch: Watch, problem: Problem, seed: int) -> Candidate | None:
    """Return the best refined start of a problem other than the search's; None if none can be simulated."""
    return _refine_best(watch, problem, seed, 0, SEARCH.starts)


def _refine_best(watch: Watch, whole: Problem, seed: int, first: int, stop: int) -> Candidate | None:
    """Return the best refined one of the starts from `first` to `stop` in the order of their cost."""
    problem = whole.rest_problem
    ranked = multistart(problem, seed, problem.workers, journal=watch.journal, starts=stop)
    watch.tell("multi-start", f"{len(ranked) - first} more starts to be refined")
    found = next(candidates(problem, ranked[first:], problem.workers, watch.journal), None)
    return found and replace(found, q=whole.point_from(problem, found.q))


def grow_starts(
    watch: Watch,
    state: SearchState,
    found: Iterator[Candidate],
    seed: int,
    best: Growth | None = None,
    escapes: float = math.inf,
) -> Growth:
    """Grow from one candidate after another until one follows all records; otherwise return the furthest growth."""
    if best and best.complete:
        return best
    problem, initial = state.problem, 2 if best else 1
    numbered = enumerate(islice(found, STAGES.candidates + 1 - initial), initial)
    while some := list(islice(numbered, STAGES.together if is_external() else 1)):
        for growth in _grow_candidates(watch, state, some, seed, best, escapes):
            if best is None or growth.followed_share(problem) > best.followed_share(problem):
                best = growth
            if best.complete:
                return best
    assert best is not None
    return best


def grow_at_raised_noise(watch: Watch, state: SearchState, known: Growth, seed: int) -> tuple[SearchState, Growth]:
    """Raise the noise level of the channels that stop the growth, and grow again, until all records are followed.

    If no level achieves that, the known levels are kept, unless the records are followed much further at a raised one:
    then the lowest level is used that no higher one exceeds much.
    """
    kept, growth, at = (state, known), known, state
    before = {} if growth.complete else describe_unfollowed(state.problem, known)
    while not growth.complete:
        problem = raise_levels(at.problem, growth)
        if problem is at.problem:
            break
        at = watch.note(replace(at.with_problem(problem), before_raised=before))
        watch.tell("noise level raised", describe_raised_levels(problem, growth))
        best = next(refine_starts(watch, at, seed), None)
        if best is None:
            break
        growth = grow_starts(watch, at, iter([best]), seed)
        if growth.complete or growth.followed_share(problem) > STAGES.much_further * kept[1].followed_share(problem):
            kept = at, growth
    return kept


def grow_from_followed(watch: Watch, state: SearchState, growth: Growth, seed: int) -> Growth:
    """Fit only the records that are followed to their ends, and grow all records from there.

    A record that is left early pulls the values away from those of the others, and is often followed at once from
    there.
    """
    problem = state.problem
    names = [t.name for t in problem.targets if growth.horizons[t.name] == t.samples]
    if not names:
        return growth
    watch.tell("gated growth", f"records followed, by themselves: {', '.join(names)}")
    rng, own = np.random.default_rng((seed, 0, 8)), problem.restrict_to(names)
    initial = grow_horizons(own, own.point_from(problem, growth.q), rng, escapes=0, journal=watch.journal)
    on_progress = partial(note_growth, watch, state, 1, growth)
    q = problem.point_from(own, initial.q)
    whole = grow_horizons(problem, q, rng, on_progress, escapes=STAGES.further_escapes, journal=watch.journal)
    return whole if whole.complete else growth


def _grow_candidates(
    watch: Watch,
    state: SearchState,
    some: Sequence[tuple[int, Candidate]],
    seed: int,
    best: Growth | None,
    escapes: float,
) -> Iterator[Growth]:
    """Yield the growth from each numbered candidate in order; external workers grow several at once."""
    on_progress = [partial(note_growth, watch, state, number, best) for number, _ in some]
    problem, journal = state.problem, watch.journal
    if len(some) == 1:
        ((number, candidate),) = some
        # Seeded by the candidate's number, so that serial and external growth give equal results.
        rng = np.random.default_rng((seed, number))
        yield grow_horizons(
            problem, candidate.q, rng, on_progress[0], escapes=escapes, leaps=STAGES.plain_leaps, journal=journal
        )
        return
    own = digest(identity(problem))
    tasks = [(own, seed, number, candidate.q) for number, candidate in some]
    found = journal.map_tasks("candidate grown", partial(_grow_candidate, problem, escapes), tasks, 1)
    for tell, one in zip(on_progress, found, strict=True):
        growth = Growth(**one)
        tell(growth.q, growth.horizons)
        yield growth


def _grow_candidate(problem: Problem, escapes: float, task: tuple[str, int, int, FloatArray]) -> dict[str, Any]:
    """Return the growth from a candidate, seeded by its number, in a form for the journal."""
    _, seed, number, q = task
    return dict(vars(grow_horizons(problem, q, np.random.default_rng((seed, number)), escapes=escapes)))


def note_growth(
    watch: Watch, state: SearchState, number: int, best: Growth | None, q: FloatArray, gates: Mapping[str, int]
) -> None:
    """Keep a point that follows the records further than all before, and report it."""
    here = sum(gates.values())
    if best is None or here > sum(best.horizons.values()):
        watch.note(state.at(q, gates))
    share = 100.0 * here / sum(t.samples for t in state.problem.targets)
    watch.tell("gated growth", f"start {number}: {share:.1f} % of all samples followed")


def warn_of_short_horizons(problem: Problem, growth: Growth) -> list[str]:
    """Return a warning for each record that is not followed to its end.

    It describes the event there, and tells whether any model could go on.
    """
    targets = {t.name: t for t in problem.targets}
    return [
        f"record {name}: {words}{_chaos_clause(problem, targets[name], growth)}"
        for name, words in describe_unfollowed(problem, growth).items()
    ]


def _chaos_clause(problem: Problem, target: Target, growth: Growth) -> str:
    """Return a clause about chaotic motion where a record is no longer followed; empty without chaos."""
    apart_s = divergence_time_s(problem, target, growth.q)
    return "" if apart_s is None else f"; its motion is chaotic there: {describe_chaos(apart_s)}"


def describe_unfollowed(problem: Problem, growth: Growth) -> dict[str, str]:
    """Return, for each record not followed to its end, how far it is followed and the event there."""
    return {
        t.name: f"the model follows it for {n / t.base.sample_rate_hz:.4g} s of "
        f"{(t.samples - 1) / t.base.sample_rate_hz:.4g} s; {departure(problem, growth.q, t, n)}"
        for t in problem.targets
        if (n := growth.horizons[t.name]) < t.samples
    }
