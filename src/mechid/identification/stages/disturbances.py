"""Disturbances that the records ask for, put in where a fit without them leaves more than noise, else nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mechid.campaign import Campaign
from mechid.identification.disturbance.disturbance import Disturbance, Found, carried, with_disturbances, without
from mechid.identification.disturbance.possible import possible
from mechid.identification.disturbance.scores import Score, scores, worth_of
from mechid.identification.output_error.target import Target
from mechid.identification.result.search_state import SearchState
from mechid.identification.stages.joint_fit import joint_fit
from mechid.identification.stages.release import fit_with_noise_released
from mechid.identification.stages.watch import Watch, residual_to_noise
from mechid.identification.uncertainty.model_error import deviations_from_null
from mechid.identification.uncertainty.settings import NOISE

LEAST = 30.0
"""Chi-square from which a disturbance counts, whatever its freedom: by chance, one in 2e7 of one degree."""
SHARE = 0.5
"""Of what records hold beyond their noise, that a disturbance has to explain: with less, the mechanism lacks
something that it imitates. Without it voltages were named for phases apart and temperatures for a torque
harmonic (docs/identification.md)."""
LEAST_DEVIATION = 4.0
"""Standard errors, widened by what the model lacks, by which one of its parameters has to be off none. Without it
voltages were named for hysteresis in the gear (the same page)."""
ROUGH = 1e-6
"""Relative fall of the cost at which a fit that shows whether a disturbance is there may stop; a choice, not
measured."""


def fit_with_disturbances(watch: Watch, state: SearchState, campaign: Campaign, names: tuple[str, ...]) -> SearchState:
    """Fit with the noise released, and with the disturbances that the records ask for.

    Where the residuals are white and within their noise none is looked for: such a fit is the same to the last bit.
    Else the score of each possible one is worked out at the optimum; the best are fitted, one at a time; and one that
    explains most of what is beyond noise stays. The noise is then released anew, from where it is known.
    """
    plain = fit_with_noise_released(watch, state, campaign.options, names)
    at = _with_all_asked_for(watch, state, plain, campaign, names)
    fitted = plain if at.found == state.found else fit_released_anew(watch, at, campaign, names)
    while doubted := [found for found in fitted.found if not _stands_out(fitted, found.disturbance)]:
        at = _fitted_without(watch, at, doubted[-1], names)
        fitted = plain if at.found == state.found else fit_released_anew(watch, at, campaign, names)
    return watch.note(fitted)


def _with_all_asked_for(
    watch: Watch, state: SearchState, plain: SearchState, campaign: Campaign, names: tuple[str, ...]
) -> SearchState:
    """Return the state, its noise as known, with the disturbances that explain what a fit without them leaves."""
    at = replace(with_noise_as_known(watch, state), q=plain.q)
    if not _asks(watch, plain):
        return at
    watch.tell("disturbances", "what records have beside the mechanism is looked for")
    some = possible(plain.problem, campaign, plain.q)
    while some:
        better = _with_one_more(watch, at, some, names)
        if better is None:
            break
        at = _each_needed(watch, better, names)
        some = tuple(one for one in some if not any(one.frees_as(found.disturbance) for found in at.found))
    return at


def fit_released_anew(watch: Watch, state: SearchState, campaign: Campaign, names: tuple[str, ...]) -> SearchState:
    """Fit with the noise released from where it is known, the disturbances found among what is free."""
    own = [p.name for found in state.found for p in found.disturbance.parameters]
    return fit_with_noise_released(watch, watch.note(state), campaign.options, tuple(dict.fromkeys((*names, *own))))


def _stands_out(state: SearchState, one: Disturbance) -> bool:
    """Tell whether a disturbance is beyond its own errors, those that hold where the model lacks something else."""
    if not one.parameters:
        return True
    return float(deviations_from_null(state.problem, state.q, state.windows, one).max(initial=0.0)) > LEAST_DEVIATION


def _asks(watch: Watch, state: SearchState) -> bool:
    """Tell whether a residual is coloured, or larger than its noise allows."""
    return any(c.prefilter for t in state.problem.targets for c in t.channels) or not _follows(watch, state)


def with_noise_as_known(watch: Watch, state: SearchState) -> SearchState:
    """Return the state with the noise of each channel as known before the search, unless growth has raised it."""

    def known(target: Target) -> Target:
        floors = {c.quantity: watch.noise.floors[target.name, c.quantity] for c in target.channels}
        return target.each(lambda c: c if c.raised else replace(c, sigma=floors[c.quantity], prefilter=None))

    return state.of(replace(state.problem, targets=tuple(map(known, state.problem.targets))))


def _with_one_more(
    watch: Watch, state: SearchState, some: tuple[Disturbance, ...], names: tuple[str, ...]
) -> SearchState | None:
    """Return the state fitted with the likeliest further disturbance; None where that explains too little."""
    found = scores(state.problem, state.q, state.windows, some)
    asked = [one for one in some if one.name in found and _counts(found[one.name])]
    if not asked:
        return None
    likeliest = max(asked, key=lambda one: found[one.name].over)
    tried = _fitted(watch, state, likeliest, names)
    gain = _gain(watch, state, tried, likeliest)
    return watch.note(replace(tried, found=(*state.found, gain))) if gain else None


def _counts(score: Score) -> bool:
    return score.chi_square > LEAST and score.over > 0.0


def _fitted(watch: Watch, state: SearchState, one: Disturbance, names: tuple[str, ...]) -> SearchState:
    problem = with_disturbances(state.problem, [one])
    begun = state.of(problem).at(carried(state.problem, state.q, problem))
    own = tuple(p.name for p in one.parameters)
    return joint_fit(watch, watch.note(begun), f"with {one.name}", (*names, *own), tolerance=ROUGH)


def _gain(watch: Watch, state: SearchState, tried: SearchState, one: Disturbance) -> Found | None:
    """Return what a disturbance explains in a fit with it; None where that is not enough to believe in it."""
    before, after = (_over_noise(watch, s) for s in (state, tried))
    samples = {t.name: t.samples for t in state.problem.targets}
    costs = [sum(ratios[name] ** 2 * n for name, n in samples.items()) for ratios in (before, after)]
    fall = costs[0] - costs[1]
    if not fall > 0.0:
        return None
    worth = worth_of(tried.problem, tried.q, tried.windows)
    score = Score(worth * fall / costs[1], one.dof, fall / costs[0], worth)
    share = fall / max(costs[0] - sum(samples.values()), fall)
    return Found(one, score.chi_square, share) if _counts(score) and share >= SHARE else None


def _follows(watch: Watch, state: SearchState) -> bool:
    """Tell whether no residual is more than its noise allows; of one that cannot be simulated nothing is asked."""
    ratios = _over_noise(watch, state).values()
    return max(ratios) <= NOISE.misfit or not np.all(np.isfinite(list(ratios)))


def _over_noise(watch: Watch, state: SearchState) -> dict[str, float]:
    """Return residual over noise, as known before the search, by record."""
    return residual_to_noise(state.problem, state.q, watch.noise.floors)


def _each_needed(watch: Watch, state: SearchState, names: tuple[str, ...]) -> SearchState:
    """Return the state without those of several disturbances that a fit does as well without."""
    for found in state.found[:-1]:
        less = _fitted_without(watch, state, found, names)
        if _gain(watch, less, state, found.disturbance) is None:
            state = less
    return watch.note(state)


def _fitted_without(watch: Watch, state: SearchState, found: Found, names: tuple[str, ...]) -> SearchState:
    one = found.disturbance
    problem, q = without(state.problem, state.q, [one])
    rest = tuple(other for other in state.found if other is not found)
    begun = watch.note(replace(state.of(problem).at(q), found=rest))
    return joint_fit(watch, begun, f"without {one.name}", names, tolerance=ROUGH)
