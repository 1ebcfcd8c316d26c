"""Stages of the campaign file: each moves only the parameters it names, on its records and windows."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from mechid.campaign import Campaign, Stage
from mechid.campaign.campaign import is_of_start
from mechid.identification.output_error.misfit import Window
from mechid.identification.output_error.problem import enough_substeps
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import Target
from mechid.identification.result.grade import FitOutcome
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.first_moments import run_up
from mechid.identification.stages.joint_fit import joint_fit, warn_of_thresholds
from mechid.identification.stages.release import drop_priors, use_released_noise
from mechid.identification.stages.watch import Watch
from mechid.parameter import Status


def follow_stages(watch: Watch, state: SearchState, campaign: Campaign) -> SearchState:
    """Run the user's stages in order; each starts where the one before ended.

    The search ends, even if interrupted, with all parameters free that a stage has moved, and with all records and
    windows that were used.
    """
    initial: list[Stage] = []
    values: dict[str, float] = {}
    try:
        for stage in campaign.stages:
            initial.append(stage)
            state = _fit_stage(watch, state, campaign, initial, values)
            if not math.isfinite(state.stages[-1].cost):
                break
            values |= state.values
        else:
            state = watch.note(state.with_outcome(_final_outcome(state)))
    finally:
        # Runs after an interruption too, which must leave a usable state.
        found = watch.latest
        state = watch.note(begin_stages(found, campaign, initial, values | found.values))
    if not state.outcome.has_optimum:
        return state
    # No fit follows, so a coloured noise model would not be used.
    return use_released_noise(watch, state, replace(campaign.options, colour="none"))


def _final_outcome(state: SearchState) -> FitOutcome:
    """Return the outcome of the last stage."""
    if not state.has_converged:
        return FitOutcome.NOT_CONVERGED
    return FitOutcome.CLIFF if warn_of_thresholds("", state) else FitOutcome.STAGES_DONE


def _fit_stage(
    watch: Watch, state: SearchState, campaign: Campaign, initial: Sequence[Stage], values: Mapping[str, float]
) -> SearchState:
    """Fit the last of the started stages, from the values of those before."""
    name, stage = f"stage {len(initial)}", initial[-1]
    if len(initial) == len(campaign.stages) and campaign.options.priors == "search":
        state = watch.note(drop_priors(state))
    state = watch.note(begin_stages(state, campaign, [stage], values))
    substeps = enough_substeps(state.problem, state.q, state.windows)
    state = watch.note(state.with_problem(replace(state.problem, substeps=substeps)))
    state = joint_fit(watch, state, name, stage.free)
    said = warn_of_thresholds(name, state)
    if not state.has_converged:
        said.append(f"{name} did not converge: {state.stages[-1].note}")
    return watch.note(state.with_warnings(*said))


def begin_stages(
    state: SearchState, campaign: Campaign, stages: Sequence[Stage], values: Mapping[str, float]
) -> SearchState:
    """Return the state with the parameters, records and windows of some stages, at values found before."""
    names = tuple(name for stage in stages for name in stage.free)
    mechanism = campaign.mechanism
    mechanism = mechanism.with_values({n: v for n, v in values.items() if n in mechanism.parameters})
    targets = tuple(_target(t, campaign, names, values) for t in state.problem.targets)
    problem = replace(state.problem, space=SearchSpace(mechanism.with_free(names)), targets=targets)
    windows = {}
    for target in targets:
        own = [_window(target, stage) for stage in stages if target.name in stage.records]
        if own:
            windows[target.name] = min(w[0] for w in own), max(w[1] for w in own)
    return replace(state, problem=problem, q=run_up(problem, problem.start, known=values), windows=windows)


def _target(target: Target, campaign: Campaign, names: Sequence[str], values: Mapping[str, float]) -> Target:
    """Return a target with only the named record parameters and its start states free."""
    own = tuple(
        replace(
            q,
            value=values.get(q.name, q.value),
            status=q.status if q.name in names or is_of_start(q) else Status.KNOWN,
        )
        for q in campaign.record(target.name).parameters
    )
    return replace(target, own=own)


def _window(target: Target, stage: Stage) -> Window:
    if stage.window_s is None:
        return 0, target.samples
    first, last = ((s - target.base.start_s) * target.base.sample_rate_hz for s in stage.window_s)
    # Decimal seconds are rounded in binary, which must not cost a sample at either end.
    return max(0, math.ceil(first - 1e-6)), min(target.samples, math.floor(last + 1e-6) + 1)
