"""From bad starts to the records' ends: multi-start, growth, and what is done where the first start stops short."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import islice
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign import Campaign
from mechid.identification.computation.journal import digest
from mechid.identification.computation.parallel import is_lent
from mechid.identification.output_error.declaration import DECLARED
from mechid.identification.output_error.identity import identity
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.readings.agreement import (
    Agreement,
    agreement,
    agreement_without,
    disagreements,
    explains,
)
from mechid.identification.readings.all_records import common_readings
from mechid.identification.readings.file_values import wrong_values
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.first_moments import run_up
from mechid.identification.search.gates import Growth, grow_horizons
from mechid.identification.search.multistart import Candidate, candidates, multistart
from mechid.identification.search.settings import SEARCH
from mechid.identification.stages.departure import departure
from mechid.identification.stages.ladder import FIRST_MOMENTS, Climb, climb_ladder
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.term_growth import (
    accept_at_raised_noise,
    fit_with_terms,
    grow_from_fitted,
    grow_other_laws,
)
from mechid.identification.stages.watch import Watch
from mechid.identification.uncertainty.noise import with_levels_of_residuals
from mechid.identification.uncertainty.noise_levels import describe_raised_levels, raise_levels
from mechid.identification.uncertainty.visibility import apart_at_s, chaos_words


def searched(
    watch: Watch, state: SearchState, campaign: Campaign, names: tuple[str, ...], seed: int, *, patient: bool = True
) -> tuple[SearchState, Growth | None]:
    """Return the growth from the best starts, or None where none of them can be simulated.

    Without patience it is that from the best start of all, of the mechanism as written, or with added terms.
    """
    drawn: list[FloatArray] = []
    found = _candidates(watch, state, seed, drawn)
    best = next(found, None)
    state = state.at(best.q) if best else state
    state = watch.close(state, "multi-start", names, best.cost if best else math.inf, SEARCH.points)
    if best is None:
        return state, None
    growth = _grown_first(watch, state, best, seed)
    climb = Climb(watch, campaign, seed, state, best, tuple(drawn), growth, tried=("as written",))
    climb = climb_ladder(climb, FIRST_MOMENTS)
    if climb.growth is not None and climb.growth.complete:
        state, growth = replace(climb.state, path=climb.tried), climb.growth
    elif patient:
        state, growth = _grown(watch, state, campaign, best, found, growth, seed)
    state = state.at(growth.q, growth.horizons)
    followed = "all records followed to their ends" if growth.complete else "not all records followed"
    if state.before_raised:
        followed += ", noise level raised"
    return watch.close(state, "gated growth", names, math.nan, growth.rounds, followed), growth


def warm_start(state: SearchState, near: Mapping[str, float]) -> tuple[SearchState, Growth]:
    """Return values already near the optimum as a growth that has come to the records' ends.

    The values are trusted: what they leave of a record counts as its noise, also where that is coloured, in place of
    the high-frequency floor.
    """
    problem = state.problem
    q = run_up(problem, problem.coordinates.point(near), known=near)
    problem = replace(problem, targets=tuple(with_levels_of_residuals(problem, t, q) for t in problem.targets))
    return state.of(problem), Growth(q, {t.name: t.samples for t in problem.targets}, True, 0)


def _grown_first(watch: Watch, state: SearchState, best: Candidate, seed: int) -> Growth:
    """Grow the mechanism as written from the best start."""
    growth = _grow_best(watch, state, iter([best]), seed, escapes=STAGES.first_escapes)
    return growth if growth.complete else _grown_from_followed(watch, state, growth, seed)


def _grown(
    watch: Watch,
    state: SearchState,
    campaign: Campaign,
    best: Candidate,
    found: Iterator[Candidate],
    growth: Growth,
    seed: int,
) -> tuple[SearchState, Growth]:
    """Grow with other laws, at a raised noise level, from other starts; `growth` is that of the mechanism as written.

    A raised level is also where the terms begin from once more: it leads to the right branch, if not to the values.
    """
    laws_first = not explains(state.problem, best)  # then what is missing is no small thing
    wider = grow_other_laws(watch, state, campaign, seed) if laws_first else None
    if wider is not None:
        return wider
    at_raised = _grow_at_raised_noise(watch, state, growth, seed)
    otherwise = _raised_otherwise(watch, state, campaign, at_raised, seed)
    if otherwise is not None:
        return otherwise
    fitted = fit_with_terms(at_raised[0], campaign, at_raised[1].q) if at_raised[1].complete else None
    wider = grow_from_fitted(watch, state, fitted, seed) if fitted else None
    if wider is None and not laws_first:
        wider = grow_other_laws(watch, state, campaign, seed)
    if wider is not None:
        return wider
    readings = common_readings(state.problem, growth, seed, watch.journal) if fitted else []
    if not any(reading.is_confirmed for reading in readings):  # else it is no lack of the mechanism
        wider = accept_at_raised_noise(watch, *at_raised, fitted)
        if wider is not None:
            return wider
    return _grown_otherwise(watch, state, campaign, best, found, growth, at_raised, seed)


def _raised_otherwise(
    watch: Watch, state: SearchState, campaign: Campaign, at_raised: tuple[SearchState, Growth], seed: int
) -> tuple[SearchState, Growth] | None:
    """Return the growth with the few records whose noise level was raised read as the others' model follows them.

    None where these are half of them or more, where the others are not followed at their own noise, or where a record
    is followed in no reading: what the model lacks then stands in the way, not how a record was declared.
    """
    problem, (at, growth) = state.problem, at_raised
    raised = [t.name for t in at.problem.targets if any(c.raised for c in t.channels)]
    if not growth.complete or not 0 < 2 * len(raised) < len(problem.targets):
        return None
    on_progress = partial(watch.tell, "records compared")
    agreed = agreement_without(problem, raised, growth.q, seed, on_progress, watch.journal)
    if agreed is None or not agreed.judged or agreed.left_out or not agreed.growth.complete:
        return None
    return watch.note(_taking(state, campaign, agreed)), agreed.growth


def _grown_from_followed(watch: Watch, state: SearchState, growth: Growth, seed: int) -> Growth:
    """Fit the records that are followed to their ends by themselves, and grow all from there.

    What stops early pulls the values away from where the others have them, and often follows at once from there.
    """
    problem = state.problem
    names = [t.name for t in problem.targets if growth.horizons[t.name] == t.samples]
    if not names:
        return growth
    watch.tell("gated growth", f"records followed, by themselves: {', '.join(names)}")
    rng, own = np.random.default_rng((seed, 0, 8)), problem.only(names)
    begun = grow_horizons(own, own.point_from(problem, growth.q), rng, escapes=0, journal=watch.journal)
    on_progress = partial(_note_growth, watch, state, 1, growth)
    q = problem.point_from(own, begun.q)
    whole = grow_horizons(problem, q, rng, on_progress, escapes=STAGES.further_escapes, journal=watch.journal)
    return whole if whole.complete else growth


def _grown_otherwise(
    watch: Watch,
    state: SearchState,
    campaign: Campaign,
    best: Candidate,
    found: Iterator[Candidate],
    growth: Growth,
    at_raised: tuple[SearchState, Growth],
    seed: int,
) -> tuple[SearchState, Growth]:
    """See whether the records agree, and try the other starts; `at_raised` is what a raised noise level comes to."""
    problem, journal = state.problem, watch.journal
    explained = explains(problem, best)
    on_progress = partial(watch.tell, "records compared")
    agreed = agreement(problem, growth, seed, explained=explained, tell=on_progress, journal=journal)
    if agreed and agreed.judged:
        state = watch.note(_taking(state, campaign, agreed))
        return _grow_at_raised_noise(
            watch, state, _grow_best(watch, state, _candidates(watch, state, seed), seed, agreed.growth), seed
        )
    rest = agreed if agreed and agreed.growth.complete else None
    if rest and not rest.left_out:
        return state, rest.growth
    wrong = [] if explained or rest else wrong_values(problem, seed, partial(watch.tell, "file's values"), journal)
    if wrong:  # nothing else helps against a value that is wrong by a hundred
        return watch.note(replace(state, contradicted={one.parameter: one.text for one in wrong})), growth
    said = [] if explained else common_readings(problem, growth, seed, journal)
    if not said and (explained or not rest):  # leaving out for good what one start explained needs the others too
        growth = _grow_best(watch, state, found, seed, growth)
        said = common_readings(problem, growth, seed, journal) if explained and not growth.complete else []
    if rest and not said and not growth.complete:
        return watch.note(_taking(state, campaign, rest)), rest.growth
    if not any(reading.is_confirmed for reading in said):  # then it is no noise that stops the growth
        state, growth = at_raised if at_raised[0] is not state else (state, growth)
    return (state if growth.complete else state.saying(*(reading.line() for reading in said))), growth


def _grow_at_raised_noise(watch: Watch, state: SearchState, known: Growth, seed: int) -> tuple[SearchState, Growth]:
    """Raise the noise level of the channels that stop the growth, and grow again, until all records are followed.

    Where no level brings that about, they stay as they are known, unless the records are followed much further at
    another: then at the lowest of which none higher does much better.
    """
    kept, growth, at = (state, known), known, state
    before = {} if growth.complete else _left(state.problem, known)
    while not growth.complete:
        problem = raise_levels(at.problem, growth)
        if problem is at.problem:
            break
        at = watch.note(replace(at.of(problem), before_raised=before))
        watch.tell("noise level raised", describe_raised_levels(problem, growth))
        best = next(_candidates(watch, at, seed), None)
        if best is None:
            break
        growth = _grow_best(watch, at, iter([best]), seed)
        if growth.complete or growth.reached(problem) > STAGES.much_further * kept[1].reached(problem):
            kept = at, growth
    return kept


def _taking(state: SearchState, campaign: Campaign, agreed: Agreement) -> SearchState:
    """Return the state with records that are taken otherwise than declared, and what is said of that."""
    taken = {name: state.taken.get(name, DECLARED).beside(further) for name, further in agreed.taken.items()}
    state = replace(state.of(agreed.problem), taken={**state.taken, **taken}).at(
        agreed.growth.q, agreed.growth.horizons
    )
    return state.saying(*(finding.line(used=bool(finding.reading)) for finding in disagreements(campaign, agreed)))


def _candidates(
    watch: Watch, state: SearchState, seed: int, drawn: list[FloatArray] | None = None
) -> Iterator[Candidate]:
    """Yield refined candidates, the best of all starts first; `drawn` takes the starts as they were before."""
    whole, journal = state.problem, watch.journal
    problem = whole.anchored

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


def _grow_best(
    watch: Watch,
    state: SearchState,
    found: Iterator[Candidate],
    seed: int,
    best: Growth | None = None,
    escapes: float = math.inf,
) -> Growth:
    """Grow from one candidate after another until one follows all records; else return the furthest."""
    if best and best.complete:
        return best
    problem, begun = state.problem, 2 if best else 1
    numbered = enumerate(islice(found, STAGES.candidates + 1 - begun), begun)
    while some := list(islice(numbered, STAGES.together if is_lent() else 1)):
        for growth in _growths(watch, state, some, seed, best, escapes):
            if best is None or growth.reached(problem) > best.reached(problem):
                best = growth
            if best.complete:
                return best
    assert best is not None
    return best


def _growths(
    watch: Watch,
    state: SearchState,
    some: Sequence[tuple[int, Candidate]],
    seed: int,
    best: Growth | None,
    escapes: float,
) -> Iterator[Growth]:
    """Yield the growth from each of some candidates, by number, in their order; several are grown at once elsewhere."""
    on_progress = [partial(_note_growth, watch, state, number, best) for number, _ in some]
    problem, journal = state.problem, watch.journal
    if len(some) == 1:
        ((number, candidate),) = some
        rng = np.random.default_rng((seed, number))
        yield grow_horizons(
            problem, candidate.q, rng, on_progress[0], escapes=escapes, leaps=STAGES.plain_leaps, journal=journal
        )
        return
    own = digest(identity(problem))
    tasks = [(own, seed, number, candidate.q) for number, candidate in some]
    found = journal.mapped("candidate grown", partial(_grown_alone, problem, escapes), tasks, 1)
    for tell, one in zip(on_progress, found, strict=True):
        growth = Growth(**one)
        tell(growth.q, growth.horizons)
        yield growth


def _grown_alone(problem: Problem, escapes: float, task: tuple[str, int, int, FloatArray]) -> dict[str, Any]:
    """Return the growth from a candidate, by the seed and its number, as a journal can hold it."""
    _, seed, number, q = task
    return dict(vars(grow_horizons(problem, q, np.random.default_rng((seed, number)), escapes=escapes)))


def _note_growth(
    watch: Watch, state: SearchState, number: int, best: Growth | None, q: FloatArray, gates: Mapping[str, int]
) -> None:
    """Keep a point that follows the records further than all before, and tell of it."""
    here = sum(gates.values())
    if best is None or here > sum(best.horizons.values()):
        watch.note(state.at(q, gates))
    share = 100.0 * here / sum(t.samples for t in state.problem.targets)
    watch.tell("gated growth", f"start {number}: {share:.1f} % of all samples followed")


def horizon_warnings(problem: Problem, growth: Growth) -> list[str]:
    """Name the records that are not followed to their ends, what happens there, and whether any model could go on."""
    targets = {t.name: t for t in problem.targets}
    return [
        f"record {name}: {words}{_chaos(problem, targets[name], growth)}"
        for name, words in _left(problem, growth).items()
    ]


def _chaos(problem: Problem, target: Target, growth: Growth) -> str:
    """Say of a record that is not followed to its end that its motion is chaotic there, where it is."""
    apart_s = apart_at_s(problem, target, growth.q)
    return "" if apart_s is None else f"; its motion is chaotic there: {chaos_words(apart_s)}"


def _left(problem: Problem, growth: Growth) -> dict[str, str]:
    """Return how far the records are followed that are not followed to their ends, and what happens there."""
    return {
        t.name: f"the model follows it for {n / t.base.sample_rate_hz:.4g} s of "
        f"{(t.samples - 1) / t.base.sample_rate_hz:.4g} s; {departure(problem, growth.q, t, n)}"
        for t in problem.targets
        if (n := growth.horizons[t.name]) < t.samples
    }
