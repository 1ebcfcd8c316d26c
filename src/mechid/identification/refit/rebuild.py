"""Reconstruction of a finished fit's optimum from its campaign: the final problem of the search, at its values."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign import Campaign
from mechid.errors import FitError, InputFileError
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.identify import make_problem
from mechid.identification.output_error.digests import file_digests
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.result.finished_fit import campaign_as_fitted
from mechid.identification.result.fit import ESTIMATED_STATUSES, Fit, Optimum
from mechid.identification.result.grade import grade_words
from mechid.identification.result.record_result import masks_of
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.masks import apply_masks
from mechid.identification.search.solve import solve
from mechid.identification.stages.freeze import free_only
from mechid.identification.stages.user_stages import begin_stages
from mechid.identification.uncertainty.noise import reject_outliers, release_noise
from mechid.identification.uncertainty.noise_levels import restore_levels
from mechid.parameter import Status


def rebuild_optimum(fit: Fit, workers: int) -> Optimum:
    """Rebuild the optimum of a fit that holds its campaign; the weights of its records follow from the residuals.

    Raises
    ------
    UsageError
        If the fit does not hold its campaign.
    InputFileError
        If the files of the campaign are not those of the fit.
    FitError
        If the grade of the fit is C or failed, or its point cannot be simulated.
    """
    refuse_changed_files(fit)
    if not fit.grade.good:
        raise FitError(" ".join(["only a fit of grade A or B can be refitted; this one:", *grade_lines(fit)]))
    campaign = campaign_as_fitted(replace(fit.required_campaign, mechanism=fit.start_mechanism), fit)
    values = {name: p.value for name, p in fit.parameters.items() if p.status in (*ESTIMATED_STATUSES, Status.FROZEN)}
    # The order of these steps is that of the search: each one changes the residuals that set the next weights.
    with one_core_algebra():
        # Small priors hold added terms near their null value, if the fit ended with such priors.
        small = {name: p.prior.sigma for name, p in fit.parameters.items() if p.added and p.prior}
        problem = replace(make_problem(campaign, workers), shrinkage=small)
        problem = apply_masks(restore_levels(problem, fit.records), masks_of(fit.records))
        problem, q, windows = _first_point(campaign, problem, values)
        problem, q = _hold_as_fitted(problem, q, fit, values)
        problem = replace(problem, substeps=int(str(fit.provenance["substeps"])))
        options = replace(campaign.options, colour="none") if campaign.stages else campaign.options
        if options.spikes == "reject" and not campaign.stages:
            problem = reject_outliers(problem, q, windows)
        problem, _ = release_noise(problem, q, windows, options)
        if options.priors == "search":
            problem = replace(problem, priors={})
        solution = solve(problem, q, windows)
    if not np.all(np.isfinite(solution.triangle.jacobian)):
        raise FitError(f"{campaign.path}: the estimate cannot be simulated; identify anew")
    return Optimum(problem, solution.q, windows, solution.triangle, fit.parameters)


def _first_point(
    campaign: Campaign, problem: Problem, values: Mapping[str, float]
) -> tuple[Problem, FloatArray, Windows]:
    """Return the problem at the fit's values, with its windows; user-defined stages set them up if there are any."""
    if not campaign.stages:
        return problem, problem.coordinates.point(values), problem.whole_windows()
    state = begin_stages(
        SearchState(problem, problem.start, problem.whole_windows()), campaign, campaign.stages, values
    )
    return state.problem, state.q, state.windows


def _hold_as_fitted(
    problem: Problem, q: FloatArray, fit: Fit, values: Mapping[str, float]
) -> tuple[Problem, FloatArray]:
    """Hold the parameters that the fit held, and search detents at their limit in the coordinates that it used."""
    status = {n: p.status for n, p in fit.parameters.items()}
    moved = [p.name for p in problem.space.mechanism.free if status[p.name] in ESTIMATED_STATUSES]
    known = problem.space.mechanism.parameters
    held = {n: v for n, v in values.items() if status[n] == Status.FROZEN and n in known}
    problem, q = free_only(problem, q, moved, held)
    cosines = (c.name for c in problem.space.coordinates if c.kind == "cosine")
    at_limit = frozenset(name for name in cosines if status[name] == Status.AT_BOUND)
    return problem.to_polar(at_limit, q) if at_limit else (problem, q)


def grade_lines(fit: Fit) -> Iterable[str]:
    """Return the description of a fit's grade, and its first reason with the next step."""
    return [
        grade_words(fit.grade, fit.outcome),
        *(f"{reason.text} Next: {reason.next_command}" for reason in fit.reasons[:1]),
    ]


def refuse_changed_files(fit: Fit) -> None:
    """Raise InputFileError if files of the campaign have changed since the fit."""
    campaign = fit.required_campaign
    if other := changed_files(campaign, fit):
        raise InputFileError(f"{campaign.path}: {', '.join(other)} changed since the fit; identify anew")


def changed_files(campaign: Campaign, fit: Fit) -> tuple[str, ...]:
    """Return the names of the campaign's files that have changed since the fit."""
    found = fit.inputs_sha256
    return tuple(name for name, digest in file_digests(campaign).items() if found.get(name) != digest)
