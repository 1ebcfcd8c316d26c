"""The noise released: levels, colour and spikes from the residual, and the joint fit with them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from mechid.campaign.identify_options import IdentifyOptions
from mechid.identification.output_error.problem import Problem
from mechid.identification.search.solve import Solution
from mechid.identification.stages.trail import Trail, joint_fit
from mechid.identification.uncertainty.noise import released, whitened_again, without_outliers

REPETITIONS = 2


def fit_with_noise_released(trail: Trail, options: IdentifyOptions, names: tuple[str, ...]) -> Solution:
    """Fit with each record's residual as its noise, where the trail stands, and leave the trail there."""
    rejects = options.spikes == "reject"
    if rejects:
        trail.problem = without_outliers(trail.problem, trail.q, trail.windows)
    trail.problem = released(trail.problem, trail.q, trail.windows, options, trail.warnings)
    if options.priors == "search":
        trail.problem = replace(trail.problem, priors={})
    solution = joint_fit(trail, "noise released", names)
    solution = _fitted_again(trail, solution, names, "whitened again", whitened_again)
    return _fitted_again(trail, solution, names, "spikes rejected", without_outliers) if rejects else solution


def _fitted_again(
    trail: Trail, solution: Solution, names: tuple[str, ...], stage: str, seen_anew: Callable[..., Problem]
) -> Solution:
    """Fit again with the noise as what the fit leaves shows it, until that stays the same."""
    for _ in range(REPETITIONS):
        problem = seen_anew(trail.problem, trail.q, trail.windows)
        if problem is trail.problem:
            break
        trail.problem = problem
        solution = joint_fit(trail, stage, names)
    return solution
