"""Release of the noise: levels, colour and spikes determined from the residual, and the joint fit with them."""

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
    """Fit with each record's residual as its noise, starting from the state."""
    rejects = options.spikes == "reject"
    if rejects:
        # Spikes would raise the noise levels estimated next.
        state = watch.note(state.with_problem(reject_outliers(state.problem, state.q, state.windows)))
    state = use_released_noise(watch, state, options)
    if options.priors == "search":
        state = watch.note(drop_priors(state))
    state = joint_fit(watch, state, "noise re-estimated", names)
    state = _refit_until_settled(watch, state, names, "whitened again", whiten_again)
    return _refit_until_settled(watch, state, names, "spikes rejected", reject_outliers) if rejects else state


def use_released_noise(watch: Watch, state: SearchState, options: IdentifyOptions) -> SearchState:
    """Return the state with each record's residual as its noise; misfits are reported."""
    problem, said = release_noise(state.problem, state.q, state.windows, options)
    return watch.note(state.with_problem(problem).with_warnings(*said))


def drop_priors(state: SearchState) -> SearchState:
    """Return the state without priors, so that only the records count."""
    return state.with_problem(replace(state.problem, priors={}))


def _refit_until_settled(
    watch: Watch, state: SearchState, names: tuple[str, ...], stage: str, update_noise: Callable[..., Problem]
) -> SearchState:
    """Refit with the noise determined from the last fit's residual, until it no longer changes."""
    for _ in range(STAGES.repetitions):
        problem = update_noise(state.problem, state.q, state.windows)
        if problem is state.problem:
            break
        state = joint_fit(watch, watch.note(state.with_problem(problem)), stage, names)
    return state
