"""The noise released: levels, colour and spikes from the residual, and the joint fit with them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from mechid.campaign.identify_options import IdentifyOptions
from mechid.identification.output_error.problem import Problem
from mechid.identification.result.search_state import SearchState
from mechid.identification.stages.joint_fit import joint_fit
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.watch import Watch
from mechid.identification.uncertainty.noise import reject_outliers, release_noise, whiten_again


def fit_with_noise_released(
    watch: Watch, state: SearchState, options: IdentifyOptions, names: tuple[str, ...]
) -> SearchState:
    """Fit with each record's residual as its noise, from where the search stands."""
    rejects = options.spikes == "reject"
    if rejects:
        state = watch.note(state.with_problem(reject_outliers(state.problem, state.q, state.windows)))
    state = with_noise_released(watch, state, options)
    if options.priors == "search":
        state = watch.note(without_priors(state))
    state = joint_fit(watch, state, "noise re-estimated", names)
    state = _fitted_again(watch, state, names, "whitened again", whiten_again)
    return _fitted_again(watch, state, names, "spikes rejected", reject_outliers) if rejects else state


def with_noise_released(watch: Watch, state: SearchState, options: IdentifyOptions) -> SearchState:
    """Return the state with each record's residual as its noise; what is a misfit is said."""
    problem, said = release_noise(state.problem, state.q, state.windows, options)
    return watch.note(state.with_problem(problem).with_warnings(*said))


def without_priors(state: SearchState) -> SearchState:
    """Return the state with the records alone to count."""
    return state.with_problem(replace(state.problem, priors={}))


def _fitted_again(
    watch: Watch, state: SearchState, names: tuple[str, ...], stage: str, seen_anew: Callable[..., Problem]
) -> SearchState:
    """Fit again with the noise as what the fit leaves shows it, until that stays the same."""
    for _ in range(STAGES.repetitions):
        problem = seen_anew(state.problem, state.q, state.windows)
        if problem is state.problem:
            break
        state = joint_fit(watch, watch.note(state.with_problem(problem)), stage, names)
    return state
