"""Which free parameters any record can see at all.

A parameter that changes no sample, at the start and at points around it, is one of which the campaign
tells nothing, and a search over it would only wander.
"""

from __future__ import annotations

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.campaign import Campaign, CampaignRecord
from mechid.campaign.prediction import simulate, time_base
from mechid.identification.identifiability.predictability import chaos_warnings
from mechid.identification.identifiability.settings import VERDICTS
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import Target, target_of
from mechid.identification.search.box import sample_box
from mechid.identification.search.first_moments import motion_begins
from mechid.simulation.trajectory import SimulationOutcome

REMEDY = "no record sees it; add a record that does, or give it as a known number"


def sensitivities(campaign: Campaign) -> int:
    """Return how many directions of the parameters a fit of this campaign asks for."""
    space = SearchSpace(campaign.mechanism)
    idle = {c.name for c in space.coordinates if space.stands_alone(c)}
    further = (
        sum(q.is_free and q.replaces not in idle for q in (*record.replaced, *record.start))
        for record in campaign.estimated
    )
    return space.size + max(further, default=0)


def start_warnings(campaign: Campaign) -> tuple[str, ...]:
    """Return what the mechanism as written does wrong, what no record sees, which motion is chaotic, one line each.

    While a record is planned, what the others do not see it may; what it would tell `mechid design` says.
    """
    lost = tuple(_lost(campaign, record) for record in campaign.records)
    planned = any(record.data is None for record in campaign.estimated)
    unseen = () if planned else tuple(f"{name}: {REMEDY}" for name in unseen_parameters(campaign))
    return (*filter(None, lost), *unseen, *chaos_warnings(campaign))


def _lost(campaign: Campaign, record: CampaignRecord) -> str:
    """Return what is to be said of a record that cannot be simulated at the values of the file."""
    duration_s = min(VERDICTS.look_s, time_base(record, campaign).duration_s)
    trajectory = simulate(campaign, record.name, duration_s=duration_s)
    if trajectory.outcome is SimulationOutcome.COMPLETE:
        return ""
    at = f'record "{record.name}" at {trajectory.lost_from_s:.9g} s'
    return f"{at}, at the values of the mechanism file: {trajectory.outcome.value}"


def unseen_parameters(campaign: Campaign) -> tuple[str, ...]:
    """Return the dotted names of the free parameters that no record of use "estimate" sees."""
    targets = tuple(target_of(record) for record in campaign.estimated if record.data is not None)
    if not campaign.mechanism.free or not targets:
        return ()
    problem = Problem(SearchSpace(campaign.mechanism), targets)
    seen = seen_coordinates(problem)
    visible = {name for name, is_seen in zip(problem.coordinates.names, seen, strict=True) if is_seen}
    visible |= {mean.of for mean in problem.coordinates.means if visible.issuperset(mean.own)}
    partners = {c.partner: c.name for c in problem.space.coordinates if c.partner}
    own = {q.name for record in campaign.estimated for q in record.parameters if q.is_free}
    asked = [q.name for q in campaign.free if q in campaign.mechanism.free or q.name in own]
    return tuple(name for name in asked if partners.get(name, name) not in visible)


def seen_coordinates(problem: Problem, *, seconds: float = VERDICTS.look_s, seed: int = 0) -> BoolArray:
    """Return for each search coordinate whether any record changes with it, (n,).

    Each record is simulated up to `seconds` after its first motion, at the values of the file and, for coordinates
    not seen there, at further points of the box in which the search starts.
    """
    seen = np.zeros(problem.size, dtype=bool)
    own = problem.coordinates.of_records(problem.start)
    for point in sample_box(problem.space, VERDICTS.points, seed):
        q = np.concatenate([point, own])
        for target in problem.targets:
            if seen.all():
                return seen
            seen |= _changes(problem, target, q, seconds)
    return seen


def _changes(problem: Problem, target: Target, q: FloatArray, seconds: float) -> BoolArray:
    """Return which coordinates change any sample that was simulated, (n,)."""
    span = problem.coordinates.span
    moves = motion_begins(target)
    rest = moves if moves < target.samples else 0
    stop = min(target.samples, rest + round(seconds * target.base.sample_rate_hz) + 1)
    moved = np.zeros(problem.size, dtype=bool)
    for block in problem.model.run(target, q, stop, jacobian=True).blocks():
        for channel in target.channels:
            j = problem.model.output(channel.quantity)
            finite = np.isfinite(block.y[:, j])
            J = problem.coordinates.block_slopes(target, j, block, block.stop - block.start)[finite]
            moved |= np.any(np.isfinite(J) & (np.abs(J) * (span / channel.sigma) > VERDICTS.rounding_change), axis=0)
    return moved
