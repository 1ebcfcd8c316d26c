"""Identification of a campaign by the standard plan, by user-defined stages, or from given values."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign import Campaign
from mechid.campaign.identify_options import ONE_CLOCK
from mechid.errors import FitError
from mechid.identification.computation.journal import Journal
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.computation.progress import Listener, Progress, silent
from mechid.identification.conclude import GoOn, conclude
from mechid.identification.effects.disturbance import Disturbance, lines_of, with_disturbances
from mechid.identification.effects.mains import mains, redetermine_hum
from mechid.identification.output_error.problem import Problem, enough_substeps
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import target_of
from mechid.identification.readings.detectors import apply_findings
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import FitOutcome
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.first_moments import run_up
from mechid.identification.search.gates import grow_horizons
from mechid.identification.search.rest import rest_window
from mechid.identification.stages.disturbances import fit_with_disturbances, needs_more_effects, replace_imitations
from mechid.identification.stages.freeze import freeze_dependent
from mechid.identification.stages.growth import search_growth, warm_start
from mechid.identification.stages.joint_fit import (
    confirm_optimum,
    fit_past_cliffs,
    is_on_file_bound,
    joint_fit,
    warn_of_thresholds,
)
from mechid.identification.stages.kernel_precompilation import LINE, KernelsAhead
from mechid.identification.stages.masked_growth import fit_followed_again
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.start_growth import warn_of_short_horizons
from mechid.identification.stages.user_stages import follow_stages
from mechid.identification.stages.watch import Watch
from mechid.identification.stages.whole_records import add_needed_effect, remove_effects
from mechid.identification.uncertainty.draws import LowerPoint
from mechid.identification.uncertainty.noise import reject_spikes, rejection_warnings
from mechid.identification.uncertainty.visibility import chaos_warnings, refuse_unidentifiable

RELEASED = "noise re-estimated"
"""Name of the last fit's stage in warnings about a threshold."""


def identify(
    campaign: Campaign,
    *,
    seed: int = 0,
    workers: int | None = None,
    listener: Listener = silent,
    journal: Journal | None = None,
    near: Mapping[str, float] | None = None,
    patient: bool = True,
    keep: Callable[[Fit], object] | None = None,
) -> Fit:
    """Identify the free parameters of a campaign's mechanism from its records.

    Parameters
    ----------
    campaign : Campaign
    seed : int
        Seed of the search; equal seeds give equal results.
    workers : int or None
        Number of threads; None uses one per core.
    listener : callable
        Called with each report of progress.
    journal : Journal or None
        Store of finished steps; steps that it holds already are not repeated.
    near : mapping of str to float or None
        Warm start: values by name, in the file's units, so close to the optimum that their residuals are noise. Search
        and confirmation are skipped. No effect where the file has stages.
    patient : bool
        False ends the search if the mechanism, as written or with added terms, does not follow the records from its
        best start. A diagnosis then looks for missing effects there. No effect where the file has stages.
    keep : callable or None
        Called with an interim fit, marked as interrupted, after the first joint fit and at the end of the search. The
        steps after either may take long, and a process that is ended then may have no time for a conclusion.

    Returns
    -------
    Fit
        The fit with its campaign, also if it did not succeed or was interrupted; see its `outcome`.

    Raises
    ------
    FitError
        If no parameter is free, or no record has use "estimate".
    WorkersError
        If the executor's workers are lost, or cannot do the work.
    """
    given = campaign
    problem = make_problem(campaign, workers or os.cpu_count() or 1)
    state = SearchState(problem, problem.start, problem.whole_windows())
    with one_core_algebra(), KernelsAhead(problem, campaign) as ahead:
        begun = near is None and not campaign.stages and ahead.start_if_new()
        if near is None:
            campaign, state = apply_findings(campaign, state, seed)
        watch = Watch(state, listener, len(campaign.stages) or 4, journal)

        def keep_so_far(at: SearchState) -> None:
            if keep is not None and at.outcome is not FitOutcome.FAILED:
                so_far = conclude(campaign, at.with_outcome(FitOutcome.INTERRUPTED), seed, watch.seconds)
                keep(replace(so_far, campaign=given))

        watch.keep, watch.compile_ahead = keep_so_far, ahead.start_if_missing
        if begun:
            watch.tell("kernels", LINE)
        try:
            if near is None:
                state = watch.note(state.with_warnings(*_report_chaos(watch, campaign)))
            if campaign.stages:
                state = follow_stages(watch, state, campaign)
            else:
                state = _follow_plan(watch, state, campaign, seed, near, patient=patient)
            if state.outcome.has_optimum:
                held = freeze_dependent(watch, state, add_terms_to_campaign(campaign, state))
                again = held.frozen != state.frozen and not campaign.stages
                state = _pass_cliffs_again(watch, state, held, seed) if again else held
            watch.keep(state)
            state = replace(state, searched=True)
        except KeyboardInterrupt:
            state = watch.latest.with_outcome(FitOutcome.INTERRUPTED)
        state = state.with_warnings(*rejection_warnings(state.problem))
        try:
            fit = conclude(campaign, state, seed, watch.seconds, _continue_from_draws(watch))
        # An interrupted conclusion keeps the values found, without the test by draws.
        except KeyboardInterrupt:
            fit = conclude(campaign, state.with_outcome(FitOutcome.INTERRUPTED), seed, watch.seconds)
    return replace(fit, campaign=given)


def _report_chaos(watch: Watch, campaign: Campaign) -> tuple[str, ...]:
    """Report and return the warnings on records whose chaotic motion limits how far they can be followed."""
    lines = chaos_warnings(campaign, points=1)
    for line in lines:
        watch.tell("before the search", line)
    return lines


def add_terms_to_campaign(campaign: Campaign, state: SearchState) -> Campaign:
    """Return the campaign with the terms that the search added to its mechanism."""
    return replace(campaign, mechanism=state.added.mechanism) if state.added else campaign


def make_problem(campaign: Campaign, workers: int) -> Problem:
    """Return the output-error problem of the records with use "estimate"."""
    if not campaign.mechanism.free:
        raise FitError(
            f"{campaign.mechanism_path}: no parameter to estimate: every parameter is a bare number; "
            "write those to be estimated as { value, min, max }"
        )
    refuse_unidentifiable(campaign)
    targets = tuple(target_of(r) for r in campaign.estimated)
    if campaign.options.spikes == "reject":
        targets = tuple(map(reject_spikes, targets))
    if not targets:
        raise FitError(f'{campaign.path}: no record has use = "estimate"; set it for at least one record')
    longest = max(t.base.interval_s for t in targets)
    # The small offset keeps an interval that equals the longest step, but for rounding, at one substep.
    substeps = max(1, math.ceil(longest / STAGES.longest_step_s - 1e-6))
    priors = {q.name: (q.value, q.sigma) for q in campaign.free if q.sigma}
    if campaign.options.priors == "none":
        priors = {}
    problem = Problem(SearchSpace(campaign.mechanism), targets, priors, substeps=substeps, workers=workers)
    if not campaign.options.mains:
        return problem
    rests = {t.name: rest_window(t) for t in targets}
    hum = mains(problem, declared_hz=campaign.options.mains, rests=rests)
    return with_disturbances(problem, [hum]) if hum else problem


def _follow_plan(
    watch: Watch, state: SearchState, campaign: Campaign, seed: int, near: Mapping[str, float] | None, *, patient: bool
) -> SearchState:
    """Run the standard plan: multi-start on the first moments, gated growth, joint fit, noise from the residuals."""
    names = (*(p.name for p in campaign.mechanism.free), *state.problem.coordinates.record_parameter_names)
    written = state.problem.space.mechanism
    if near is None:
        state, growth = search_growth(watch, state, campaign, names, seed, patient=patient)
    else:
        state, growth = warm_start(state, near, seed)
    if growth is None:
        return state
    added = (*(state.added.new if state.added else ()), *state.problem.coordinates.record_parameter_names)
    names = (*names, *(n for n in added if n not in names))
    left_out = any(t.left_out for t in state.readings.values())
    whole = growth.complete and not left_out
    state = state.at(growth.q, growth.horizons).with_outcome(FitOutcome.CONVERGED if whole else FitOutcome.HORIZON)
    state = watch.note(state.with_warnings(*warn_of_short_horizons(state.problem, growth)))
    substeps = enough_substeps(state.problem, state.q, state.windows)
    state = watch.note(state.with_problem(replace(state.problem, substeps=substeps)))
    state = joint_fit(watch, state, "joint fit", names, tolerance=STAGES.rough_tolerance)
    state = fit_followed_again(watch, state, names)
    watch.keep(state)
    if campaign.options.mains and lines_of(state.problem):
        state = watch.note(state.with_problem(redetermine_hum(state.problem, state.q, campaign.options.mains)))
    before = state
    # Before the comparison over whole records, which takes longer: a filter in place of delays takes seconds.
    state = replace_imitations(watch, fit_with_disturbances(watch, state, campaign, names), campaign, names)
    # A bound explains a residual beyond noise: it is no sign of a missing effect.
    is_held = is_on_file_bound(state.problem, state.q)
    found = tuple(one.disturbance.name for one in state.found)
    imitates = not before.found and any(_may_imitate(one.disturbance) for one in state.found)
    if growth.complete and (imitates or (needs_more_effects(watch, state) and not is_held)):
        # An effect added past a stall that leaves more than noise may imitate one that whole records tell.
        plain = remove_effects(before, written) if before.added else before
        wider = add_needed_effect(watch, plain, campaign, found, seed)
        if wider is not plain:
            more = tuple(dict.fromkeys((*names, *wider.problem.coordinates.names)))
            wider = joint_fit(watch, wider, "joint fit", more, tolerance=STAGES.rough_tolerance)
            wider = replace_imitations(watch, fit_with_disturbances(watch, wider, campaign, more), campaign, more)
            # An effect that leaves more than white noise may be an imitation.
            if needs_more_effects(watch, wider):
                watch.note(state)
            else:
                state, names = wider, more
    if growth.complete and near is None:
        state = confirm_optimum(watch, state, names, seed)
    return watch.note(_set_final_outcome(fit_past_cliffs(watch, state, names, seed)))


def _may_imitate(one: Disturbance) -> bool:
    """Tell whether a disturbance may stand for a missing effect of the mechanism although only noise is left.

    Values of single records may. A rate of the clock for all records, and hum in several records, leave misfit
    beyond noise in the others where they are wrong.
    """
    return one.name != ONE_CLOCK and (one.mains_hz is None or sum(map(bool, one.lines_hz.values())) < 2)


def _pass_cliffs_again(watch: Watch, before: SearchState, state: SearchState, seed: int) -> SearchState:
    """Continue along a threshold at which the fit stopped after a parameter was held.

    Warnings about the threshold from before that are removed.
    """
    stale = warn_of_thresholds(RELEASED, before)
    state = replace(state, warnings=tuple(line for line in state.warnings if line not in stale))
    state = state.with_outcome(FitOutcome.CONVERGED) if state.outcome is FitOutcome.CLIFF else state
    return watch.note(_set_final_outcome(fit_past_cliffs(watch, state, _names(state), seed)))


def _names(state: SearchState) -> tuple[str, ...]:
    """Return the names of all free parameters of a state's problem."""
    return tuple(dict.fromkeys(state.problem.coordinates.names))


def _continue_from_draws(watch: Watch) -> GoOn:
    """Return a function that continues a search from a draw of lower cost than its optimum, a few times."""
    # A continued search may find another lower draw: without a limit a rough cost could keep it going.
    left = STAGES.most_from_draws

    def go_on(state: SearchState, lower: LowerPoint) -> SearchState | None:
        nonlocal left
        if left == 0:
            return None
        left -= 1
        return watch.note(_set_final_outcome(joint_fit(watch, state.at(lower.q), "from a lower draw", _names(state))))

    return go_on


def _set_final_outcome(state: SearchState) -> SearchState:
    """Set the outcome and the warnings of the state at the end of the plan, by its last joint fit."""
    said = warn_of_thresholds(RELEASED, state)
    state = state.with_warnings(*said)
    if state.outcome.has_optimum and said:
        return state.with_outcome(FitOutcome.CLIFF)
    if state.outcome.has_optimum and not state.has_converged:
        return state.with_outcome(FitOutcome.NOT_CONVERGED)
    return state


def identify_from(
    campaign: Campaign,
    values: Mapping[str, float],
    *,
    seed: int = 0,
    workers: int | None = None,
    listener: Listener = silent,
) -> Fit:
    """Identify from a start: horizons grow from it to the records' ends, then all free parameters are fitted jointly.

    Parameters
    ----------
    campaign : Campaign
        Its stages are ignored.
    values : mapping of str to float
        Start values by dotted name; other parameters start at the file's values.
    seed, workers, listener
        As in `identify`.

    Returns
    -------
    Fit
        Also if the fit did not succeed; see its `outcome`.

    Raises
    ------
    FitError
        If no parameter is free, or no record has use "estimate".
    """
    planned = replace(campaign, stages=())
    problem = make_problem(planned, workers or os.cpu_count() or 1)
    point = run_up(problem, problem.coordinates.point(values), known=values)
    state = SearchState(problem, point, problem.whole_windows())
    watch = Watch(state, listener, 3)
    total = sum(t.samples for t in problem.targets)

    def tell(line: str) -> None:
        watch.tell("gated growth", line, problem.total_norm(watch.latest.q, state.windows) ** 2)

    def on_growth(q: FloatArray, gates: Mapping[str, int]) -> None:
        watch.note(state.at(q))
        tell(f"{100.0 * sum(gates.values()) / total:.1f} % of all samples followed")

    tell("begins")
    grown = state.at(grow_horizons(problem, state.q, np.random.default_rng(seed), on_growth).q)
    spent = watch.seconds

    def report_rest(progress: Progress) -> None:
        # Growth and search report as one run of three stages.
        number = min(progress.number + 1, 3)
        listener(replace(progress, number=number, total=3, elapsed_s=spent + progress.elapsed_s))

    return identify(planned, seed=seed, workers=workers, listener=report_rest, near=grown.values)
