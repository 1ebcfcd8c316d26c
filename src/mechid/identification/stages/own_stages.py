"""The user's own stages: each moves only the parameters it names, on its records and windows."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from mechid.campaign import Campaign, Stage
from mechid.identification.output_error.accuracy import enough_substeps
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import Target
from mechid.identification.result.fit import FitOutcome
from mechid.identification.stages.trail import Trail, cliff_warnings, joint_fit
from mechid.identification.uncertainty.noise import released
from mechid.parameter import Status

Window = tuple[int, int]


def follow_stages(trail: Trail, campaign: Campaign) -> None:
    """Work through the user's stages in order; each starts where the one before ended.

    The trail ends, also when interrupted, with all parameters free that a stage has moved, and with all
    records and windows that were used.
    """
    begun: list[Stage] = []
    values: dict[str, float] = {}
    try:
        for number, stage in enumerate(campaign.stages, 1):
            begun.append(stage)
            if number == len(campaign.stages) and campaign.options.priors == "search":
                trail.problem = replace(trail.problem, priors={})
            begin(trail, campaign, [stage], values)
            trail.problem = replace(trail.problem, substeps=enough_substeps(trail.problem, trail.q, trail.windows))
            solution = joint_fit(trail, f"stage {number}", stage.free)
            trail.warnings += cliff_warnings(f"stage {number}", trail.problem, solution)
            if not solution.converged:
                trail.warnings.append(f"stage {number} did not converge: {trail.stages[-1].note}")
            if not math.isfinite(trail.stages[-1].cost):
                return
            values |= trail.values
        trail.outcome = FitOutcome.STAGES_DONE
    finally:
        begin(trail, campaign, begun, values | trail.values)
    options = replace(campaign.options, colour="none")  # no fit follows
    trail.problem = released(trail.problem, trail.q, trail.windows, options, trail.warnings)


def begin(trail: Trail, campaign: Campaign, stages: Sequence[Stage], values: Mapping[str, float]) -> None:
    """Set the trail to the parameters, records and windows of some stages, and to values found before."""
    names = tuple(name for stage in stages for name in stage.free)
    mechanism = campaign.mechanism
    mechanism = mechanism.with_values({n: v for n, v in values.items() if n in mechanism.parameters})
    targets = tuple(_target(t, campaign, names, values) for t in trail.problem.targets)
    trail.problem = replace(trail.problem, space=SearchSpace(mechanism.with_free(names)), targets=targets)
    trail.q = trail.problem.start
    trail.windows = {}
    for target in targets:
        windows = [_window(target, stage) for stage in stages if target.name in stage.records]
        if windows:
            trail.windows[target.name] = min(w[0] for w in windows), max(w[1] for w in windows)


def _target(target: Target, campaign: Campaign, names: Sequence[str], values: Mapping[str, float]) -> Target:
    """Return a target of whose own parameters those named alone are free."""
    own = tuple(
        replace(q, value=values.get(q.name, q.value), status=q.status if q.name in names else Status.KNOWN)
        for q in campaign.record(target.name).parameters
    )
    return replace(target, own=own)


def _window(target: Target, stage: Stage) -> Window:
    if stage.window_s is None:
        return 0, target.samples
    first, last = ((s - target.base.start_s) * target.base.sample_rate_hz for s in stage.window_s)
    return max(0, math.ceil(first - 1e-6)), min(target.samples, math.floor(last + 1e-6) + 1)
