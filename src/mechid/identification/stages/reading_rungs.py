"""Rungs of the ladder for records that are not as declared, or that no mechanism follows at their noise level.

They come last: what a mechanism lacks is found without them, and a level that is raised hides it.
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
from mechid.identification.stages.start_growth import grow_at_raised_noise, grow_starts, refined_starts
from mechid.identification.stages.term_growth import accept_at_raised_noise, fit_with_terms


def _raise(climb: Climb) -> Climb:
    """Grow again at a raised noise level; other rungs begin from where that leads."""
    assert climb.growth is not None
    raised = climb.raised or grow_at_raised_noise(climb.watch, climb.state, climb.growth, climb.seed)
    return replace(climb, raised=raised)


def _read_raised_otherwise(climb: Climb) -> Climb:
    """Read the few records whose noise level was raised as the others' model follows them.

    Nothing is changed where these are half of them or more, where the others are not followed at their own noise, or
    where a record is followed in no reading: what the model lacks then stands in the way, not how it was declared.
    """
    problem, (at, growth) = climb.state.problem, climb.at_raised
    raised = [t.name for t in at.problem.targets if any(c.raised for c in t.channels)]
    if not growth.complete or not 0 < 2 * len(raised) < len(problem.targets):
        return climb
    tell = partial(climb.watch.tell, "records compared")
    agreed = agreement_of_others(problem, raised, growth.q, climb.seed, tell, climb.watch.journal)
    if agreed is None or not agreed.judged or agreed.left_out or not agreed.growth.complete:
        return climb
    return replace(climb, state=climb.watch.note(_taking(climb.state, climb.campaign, agreed)), growth=agreed.growth)


def _keep_raised(climb: Climb) -> Climb:
    """Keep the raised level, with the terms that the records need there, where it leaves little of any record.

    Not where another reading of all records is confirmed: then it is no lack of the mechanism.
    """
    at, growth = climb.at_raised
    fitted = fit_with_terms(at, climb.campaign, growth.q) if growth.complete else None
    if fitted is None or _is_read_otherwise(climb):
        return climb
    found = accept_at_raised_noise(climb.watch, at, growth, fitted)
    return climb if found is None else replace(climb, state=found[0], growth=found[1])


def _is_read_otherwise(climb: Climb) -> bool:
    assert climb.growth is not None
    said = common_readings(climb.state.problem, climb.growth, climb.seed, climb.watch.journal)
    return any(reading.is_confirmed for reading in said)


def _compare_records(climb: Climb) -> Climb:
    """See whether some records contradict the others, and the file's values all of them; else try the other starts."""
    assert climb.growth is not None
    state, growth, at_raised = climb.state, climb.growth, climb.at_raised
    watch, seed = climb.watch, climb.seed
    problem, journal = state.problem, watch.journal
    explained = explains(problem, climb.best)
    tell = partial(watch.tell, "records compared")
    agreed = agreement(problem, growth, seed, explained=explained, tell=tell, journal=journal)
    if agreed and agreed.judged:
        state = watch.note(_taking(state, climb.campaign, agreed))
        growth = grow_starts(watch, state, refined_starts(watch, state, seed), seed, agreed.growth)
        return _with(climb, *grow_at_raised_noise(watch, state, growth, seed))
    rest = agreed if agreed and agreed.growth.complete else None
    if rest and not rest.left_out:
        return _with(climb, state, rest.growth)
    wrong = [] if explained or rest else find_wrong_values(problem, seed, partial(watch.tell, "file's values"), journal)
    if wrong:  # nothing else helps against a value that is wrong by a hundred
        return _with(climb, watch.note(replace(state, contradicted={one.parameter: one.text for one in wrong})), growth)
    said = [] if explained else common_readings(problem, growth, seed, journal)
    if not said and (explained or not rest):  # leaving out for good what one start explained needs the others too
        growth = grow_starts(watch, state, climb.found, seed, growth)
        said = common_readings(problem, growth, seed, journal) if explained and not growth.complete else []
    if rest and not said and not growth.complete:
        return _with(climb, watch.note(_taking(state, climb.campaign, rest)), rest.growth)
    if not any(reading.is_confirmed for reading in said):  # then it is no noise that stops the growth
        state, growth = at_raised if at_raised[0] is not state else (state, growth)
    return _with(
        climb, state if growth.complete else state.with_warnings(*(reading.line() for reading in said)), growth
    )


def _with(climb: Climb, state: SearchState, growth: Growth) -> Climb:
    return replace(climb, state=state, growth=growth)


def _taking(state: SearchState, campaign: Campaign, agreed: Agreement) -> SearchState:
    """Return the state with records that are taken otherwise than declared, and what is said of that."""
    taken = {name: state.readings.get(name, DECLARED).beside(further) for name, further in agreed.readings.items()}
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
    Rung("records at a raised noise level read otherwise", _always, _read_raised_otherwise, ladder_budget),
    Rung("raised noise level kept", _always, _keep_raised, ladder_budget),
    Rung("records compared, other starts", _always, _compare_records, ladder_budget),
)
"""Rungs for records that are not as declared, or not followed at their noise level."""
