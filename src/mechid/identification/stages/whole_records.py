"""The effect that records which are followed to their ends still ask for."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from mechid.campaign import Campaign
from mechid.identification.effects.settings import DURING_FIT
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.gates import Growth
from mechid.identification.stages.compared_effects import look_at_whole_records
from mechid.identification.stages.families import Families
from mechid.identification.stages.first_look import refined_look
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.term_growth import Reached, settle
from mechid.identification.stages.watch import Watch

WHOLE_RECORDS = "the effect that whole records ask for"


def with_effect_asked_for(
    watch: Watch, state: SearchState, campaign: Campaign, names: tuple[str, ...], seed: int
) -> SearchState:
    """Return a state with the single effect that explains most of what whole records hold beyond noise.

    The state itself where none explains anything, or where the likeliest is one that it has already.

    Parameters
    ----------
    watch : Watch
    state : SearchState
        Of the mechanism as written, at its optimum, all records followed to their ends.
    campaign : Campaign
    names : tuple of str
        Disturbances that were found beside it.
    seed : int
    """
    families, whole = Families(state.problem, campaign), state.problem.whole_windows()
    looks = look_at_whole_records(families, state.q, partial(watch.tell, "whole records"), watch.journal)
    here = refined_look(families.bare, state.q, watch.journal, whole, STAGES.whole_steps)
    best = min(looks, key=lambda look: look.criterion, default=here)
    if here.criterion - best.criterion < DURING_FIT.least_chi_square or set(best.model.effects) <= set(names):
        return state
    growth = Growth(best.q, {name: stop for name, (_, stop) in whole.items()}, True, 0)
    settled = settle(watch, state, Reached(best.model, growth), seed)
    if settled is None or not (settled[0].added or settled[0].found):
        return state
    return replace(settled[0], path=(*state.path, WHOLE_RECORDS))
