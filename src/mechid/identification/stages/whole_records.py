"""Additional effect for records that are followed to their ends, if their data still support one."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from mechid.campaign import Campaign
from mechid.identification.effects.disturbance import remove_disturbances
from mechid.identification.effects.effect import AddedTerms
from mechid.identification.effects.settings import DURING_FIT
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.gates import Growth
from mechid.identification.search.solve import solve
from mechid.identification.stages.compared_effects import look_at_whole_records
from mechid.identification.stages.families import Families
from mechid.identification.stages.first_look import fit_look
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.term_growth import GrownModel, settle
from mechid.identification.stages.watch import Watch
from mechid.plant.mechanism import Mechanism

WHOLE_RECORDS = "the effect that whole records ask for"


def add_needed_effect(
    watch: Watch, state: SearchState, campaign: Campaign, names: tuple[str, ...], seed: int
) -> SearchState:
    """Return a state with the single effect that explains most of the misfit of whole records beyond noise.

    The state itself is returned if no effect explains anything, or if it already has the likeliest one.

    Parameters
    ----------
    watch : Watch
    state : SearchState
        State of the mechanism as written, at its optimum, with all records followed to their ends.
    campaign : Campaign
    names : tuple of str
        Disturbances that were found in addition.
    seed : int
    """
    families, whole = Families(state.problem, campaign), state.problem.whole_windows()
    looks = look_at_whole_records(families, state.q, partial(watch.tell, "whole records"), watch.journal)
    here = fit_look(families.bare, state.q, watch.journal, whole, STAGES.whole_steps)
    best = min(looks, key=lambda look: look.criterion, default=here)
    if here.criterion - best.criterion < DURING_FIT.least_chi_square or set(best.model.effects) <= set(names):
        return state
    growth = Growth(best.q, {name: stop for name, (_, stop) in whole.items()}, True, 0)
    settled = settle(watch, state, GrownModel(best.model, growth), seed)
    if settled is None or not (settled[0].added or settled[0].found):
        return state
    return replace(settled[0], path=(*state.path, WHOLE_RECORDS))


def remove_effects(state: SearchState, written: Mechanism) -> SearchState:
    """Return the optimum of the mechanism as written over whole records, from a state with added effects.

    Parameters
    ----------
    state : SearchState
        With terms, a law or record values added.
    written : Mechanism
        Mechanism as written.
    """
    bare, _ = remove_disturbances(state.problem, state.q, [one.disturbance for one in state.found])
    plain = AddedTerms(written).problem(bare)
    q = plain.coordinates.clip(plain.coordinates.point(state.problem.coordinates.values(state.q)))
    q = solve(plain, q, plain.whole_windows(), steps=STAGES.joint_steps, tolerance=STAGES.rough_tolerance).q
    whole = {name: stop for name, (_, stop) in plain.whole_windows().items()}
    return replace(state.with_problem(plain).at(q, whole), added=None, found=())
