"""Rungs of the ladder for records that differ from their declaration or stay above their noise level.

They come last: missing effects are found without them, and a raised level hides such effects.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from mechid.campaign import Campaign
from mechid.identification.output_error.declaration import DECLARED
from mechid.identification.readings.agreement import (
    Agreement,
    agreement,
    agreement_of_others,
    disagreements,
    explains,
)
from mechid.identification.readings.all_records import common_readings
from mechid.identification.readings.file_values import find_wrong_values
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.gates import Growth
from mechid.identification.stages.budget import ladder_budget
from mechid.identification.stages.ladder import Climb, Rung
from mechid.identification.stages.start_growth import grow_at_raised_noise, grow_starts, refine_starts
from mechid.identification.stages.term_growth import accept_at_raised_noise, fit_with_terms


def _raise(climb: Climb) -> Climb:
    """Grow again at a raised noise level, from which other rungs start."""
    assert climb.growth is not None
    raised = climb.raised or grow_at_raised_noise(climb.watch, climb.state, climb.growth, climb.seed)
    return replace(climb, raised=raised)


def _reinterpret_raised(climb: Climb) -> Climb:
    """Reinterpret the few records whose noise level was raised so that the others' model follows them.

    Nothing changes if these are half of the records or more, if the others are not followed at their own noise, or if
    no reinterpretation of a record is followed: then the model is incomplete, not the declaration wrong.
    """
    problem, (at, growth) = climb.state.problem, climb.state_at_raised_noise
    raised = [t.name for t in at.problem.targets if any(c.raised for c in t.channels)]
    if not growth.complete or not 0 < 2 * len(raised) < len(problem.targets):
        return climb
    tell = partial(climb.watch.tell, "records compared")
    agreed = agreement_of_others(problem, raised, growth.q, climb.seed, tell, climb.watch.journal)
    if agreed is None or not agreed.scores or agreed.left_out or not agreed.growth.complete:
        return climb
    return replace(
        climb, state=climb.watch.note(_apply_agreement(climb.state, climb.campaign, agreed)), growth=agreed.growth
    )


def _keep_raised(climb: Climb) -> Climb:
    """Keep the raised level, with the terms that the records need there, if it leaves little of any record unexplained.

    It is not kept if a reinterpretation of all records is confirmed: then the mechanism is complete.
    """
    at, growth = climb.state_at_raised_noise
    fitted = fit_with_terms(at, climb.campaign, growth.q) if growth.complete else None
    if fitted is None or _has_confirmed_reading(climb):
        return climb
    found = accept_at_raised_noise(climb.watch, at, growth, fitted)
    return climb if found is None else replace(climb, state=found[0], growth=found[1])


def _has_confirmed_reading(climb: Climb) -> bool:
    assert climb.growth is not None
    said = common_readings(climb.state.problem, climb.growth, climb.seed, climb.watch.journal)
    return any(reading.is_confirmed for reading in said)


def _compare_records(climb: Climb) -> Climb:
    """Check whether records contradict each other, or the file's values all of them; else try the other starts."""
    assert climb.growth is not None
    state, growth, raised = climb.state, climb.growth, climb.state_at_raised_noise
    watch, seed = climb.watch, climb.seed
    problem, journal = state.problem, watch.journal
    explained = explains(problem, climb.best)
    tell = partial(watch.tell, "records compared")
    agreed = agreement(problem, growth, seed, explained=explained, tell=tell, journal=journal)
    if agreed and agreed.scores:
        state = watch.note(_apply_agreement(state, climb.campaign, agreed))
        growth = grow_starts(watch, state, refine_starts(watch, state, seed), seed, agreed.growth)
        return _update(climb, *grow_at_raised_noise(watch, state, growth, seed))
    rest = agreed if agreed and agreed.growth.complete else None
    if rest and not rest.left_out:
        return _update(climb, state, rest.growth)
    wrong = [] if explained or rest else find_wrong_values(problem, seed, partial(watch.tell, "file's values"), journal)
    # Nothing else helps against a value that is off by a factor of a hundred.
    if wrong:
        return _update(
            climb, watch.note(replace(state, contradicted={one.parameter: one.text for one in wrong})), growth
        )
    said = [] if explained else common_readings(problem, growth, seed, journal)
    # A record explained by one start may be left out only after the other starts have been tried too.
    if not said and (explained or not rest):
        growth = grow_starts(watch, state, climb.found, seed, growth)
        said = common_readings(problem, growth, seed, journal) if explained and not growth.complete else []
    if rest and not said and not growth.complete:
        return _update(climb, watch.note(_apply_agreement(state, climb.campaign, rest)), rest.growth)
    # A confirmed reading shows that noise is not what stops the growth, so the raised level is dropped.
    if not any(reading.is_confirmed for reading in said):
        state, growth = raised if raised[0] is not state else (state, growth)
    return _update(
        climb, state if growth.complete else state.with_warnings(*(reading.line() for reading in said)), growth
    )


def _update(climb: Climb, state: SearchState, growth: Growth) -> Climb:
    return replace(climb, state=state, growth=growth)


def _apply_agreement(state: SearchState, campaign: Campaign, agreed: Agreement) -> SearchState:
    """Return the state with reinterpreted records, and messages about them."""
    taken = {name: state.readings.get(name, DECLARED).combine(further) for name, further in agreed.readings.items()}
    state = replace(state.with_problem(agreed.problem), readings={**state.readings, **taken}).at(
        agreed.growth.q, agreed.growth.horizons
    )
    return state.with_warnings(
        *(finding.line(used=bool(finding.reading)) for finding in disagreements(campaign, agreed))
    )


def _always(climb: Climb) -> bool:
    return climb.growth is not None


READINGS = (
    Rung("noise level raised", _always, _raise, ladder_budget),
    Rung("records at a raised noise level read otherwise", _always, _reinterpret_raised, ladder_budget),
    Rung("raised noise level kept", _always, _keep_raised, ladder_budget),
    Rung("records compared, other starts", _always, _compare_records, ladder_budget),
)
"""Rungs for records that differ from their declaration, or are not followed at their noise level."""
