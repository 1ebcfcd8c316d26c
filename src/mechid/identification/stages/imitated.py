"""Laws that disturbances imitate: a low-pass that the mechanism file lacks is followed by delays of the records.

What a filter does beyond its delay would go into the mechanism's values, and nothing in the records' own parts would
show it, since all records have the same. So where a disturbance is found that imitates a law, that law is fitted in
its place.
"""

from __future__ import annotations

import math
from dataclasses import replace

from mechid.campaign import Campaign
from mechid.identification.beside.beside import law_beside, lifted
from mechid.identification.disturbance.disturbance import Found, without
from mechid.identification.disturbance.scores import worth_of
from mechid.identification.effects.rules import DURING_FIT
from mechid.identification.result.search_state import SearchState
from mechid.identification.stages.disturbances import fit_released_anew, with_noise_as_known
from mechid.identification.stages.joint_fit import joint_fit
from mechid.identification.stages.watch import Watch
from mechid.plant.superset import Law, rivals_of


def without_imitations(watch: Watch, state: SearchState, campaign: Campaign, names: tuple[str, ...]) -> SearchState:
    """Return the state with a law in place of a disturbance that imitates it, where the Bayesian criterion wants it."""
    if state.beside is not None or not campaign.options.terms:
        return state
    for found in state.found:
        laws = (law for law in rivals_of(campaign.mechanism) if law.imitated_by == found.disturbance.name)
        better = [tried for law in laws if (tried := _in_place(watch, state, campaign, found, law, names))]
        if better:
            best = min(better, key=lambda tried: tried.solution.triangle.cost if tried.solution else math.inf)
            return fit_released_anew(watch, with_noise_as_known(watch, best), campaign, names)
    return state


def _in_place(
    watch: Watch, state: SearchState, campaign: Campaign, found: Found, law: Law, names: tuple[str, ...]
) -> SearchState | None:
    """Return the state fitted with a law in place of a disturbance; None where that is no better."""
    alone, q = without(state.problem, state.q, [found.disturbance])
    beside = law_beside(campaign.mechanism, law)
    problem = beside.problem(alone)
    rest = tuple(other for other in state.found if other is not found)
    begun = replace(state.of(problem).at(lifted(alone, q, problem)), found=rest, beside=beside)
    tried = joint_fit(
        watch,
        watch.note(begun),
        f"{law.name} in place of {found.disturbance.name}",
        (*names, *sorted(beside.new)),
        tolerance=DURING_FIT.tolerance,
    )
    assert tried.solution is not None
    cost = state.problem.total_norm(state.q, state.windows) ** 2
    fewer = found.disturbance.dof - len(beside.new)
    worth = max(worth_of(state.problem, state.q, state.windows), math.e)
    return tried if tried.solution.triangle.cost < cost + fewer * math.log(worth) else None
