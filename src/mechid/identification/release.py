"""The noise released: levels, colour and spikes from the residual, and the joint fit with them."""

from __future__ import annotations

from dataclasses import replace

from mechid.campaign.identify_options import IdentifyOptions
from mechid.identification.noise import released, whitened_again, without_outliers
from mechid.identification.solve import Solution
from mechid.identification.trail import Trail, joint_fit

REPETITIONS = 2


def fit_with_noise_released(trail: Trail, options: IdentifyOptions, names: tuple[str, ...]) -> Solution:
    """Fit with each record's residual as its noise, where the trail stands, and leave the trail there."""
    if options.spikes == "reject":
        trail.problem = without_outliers(trail.problem, trail.q, trail.windows)
    trail.problem = released(trail.problem, trail.q, trail.windows, options, trail.warnings)
    if options.priors == "search":
        trail.problem = replace(trail.problem, priors={})
    solution = joint_fit(trail, "noise released", names)
    solution = _whitened_again(trail, solution, names)
    return _without_outliers(trail, solution, names) if options.spikes == "reject" else solution


def _whitened_again(trail: Trail, solution: Solution, names: tuple[str, ...]) -> Solution:
    """Fit again with prefilters of what the whitened fit leaves, until they stay the same."""
    for _ in range(REPETITIONS):
        whiter = whitened_again(trail.problem, trail.q, trail.windows)
        if whiter is trail.problem:
            break
        trail.problem = whiter
        solution = joint_fit(trail, "whitened again", names)
    return solution


def _without_outliers(trail: Trail, solution: Solution, names: tuple[str, ...]) -> Solution:
    """Reject what the fit has shown to be far off, and fit again, until nothing more is."""
    for _ in range(REPETITIONS):
        kept = without_outliers(trail.problem, trail.q, trail.windows)
        if kept is trail.problem:
            break
        trail.problem = kept
        solution = joint_fit(trail, "spikes rejected", names)
    return solution
