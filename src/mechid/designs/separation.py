"""Separation of rival explanations by further records.

Where one rival is true, the other one's free parameters, and all the mechanism's own, adjust to what was measured
before and to the new records together. What they leave is, to first order, the distance of what the true one makes
from the span of the other one's derivatives on all records: the T-criterion of Atkinson and Fedorov (1975), each
sample over its noise, offset, drift and what a record has of its own projected out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.signal import detrend

from mechid.arrays import BoolArray, FloatArray
from mechid.campaign import Campaign
from mechid.designs.planned import PlannedRecord
from mechid.designs.rivals import Group
from mechid.designs.settings import DESIGN
from mechid.identification.computation.parallel import map_tasks
from mechid.identification.diagnosis.candidate import Model
from mechid.identification.effects.campaign_disturbances import possible_disturbances
from mechid.identification.effects.disturbance import with_disturbances
from mechid.identification.effects.settings import IN_DIAGNOSIS
from mechid.identification.output_error.problem import Problem, transfer_values
from mechid.identification.output_error.target import Target
from mechid.identification.search.solve import solve

CLEAR = (DESIGN.chance + math.sqrt(DESIGN.chance**2 + IN_DIAGNOSIS.least_chi_square)) ** 2
"""Expected chi-square from which a record separates rivals: noise makes it scatter by twice its root;
`DESIGN.chance` standard deviations below, it is still what a diagnosis asks for."""


@dataclass(frozen=True, eq=False)
class Pair:
    """Two rivals, one taken for the truth.

    Attributes
    ----------
    true, against : str
        Their names.
    now : float
        By how much the other one's chi-square is above that of the true one on the records that there are.
    known : (m, n)
        Derivatives of the other one on these, in sigmas.
    shown : tuple of (k, 1 + n)
        What each further record would leave of the other one as it is now, and its derivatives, likewise; infinite
        where it cannot be simulated.
    """

    true: str
    against: str
    now: float
    known: FloatArray
    shown: tuple[FloatArray, ...]

    def expected(self, records: Sequence[int]) -> float:
        """Return by how much the other one's chi-square is above that of the true one after some further records."""
        return self.now + least_misfit(self.known, [self.shown[k] for k in records])


def least_misfit(known: FloatArray, shown: Sequence[FloatArray]) -> float:
    """Return the least sum of squares that parameters leave of further records without losing the ones known.

    Parameters
    ----------
    known : (m, n)
        Derivatives on the records known, at their optimum.
    shown : sequence of (k, 1 + n)
        Residual and derivatives on each further record.
    """
    rows = np.vstack([np.column_stack([np.zeros(len(known)), known]), *shown])
    if not np.all(np.isfinite(rows)):
        return 0.0
    r, J = rows[:, 0], rows[:, 1:]
    size = np.linalg.norm(J, axis=0)
    J = J / np.where(size > 0.0, size, 1.0)
    step = np.linalg.lstsq(J, -r, rcond=1e-12)[0]
    return float(np.sum((r + J @ step) ** 2))


def pairs_of(campaign: Campaign, group: Group, records: Sequence[PlannedRecord], workers: int = 1) -> list[Pair]:
    """Return every two rivals of a group, each one once for the truth, and what each record would show of them."""
    torques = [predicted_torque(campaign, model, records, workers) for model in group.models]
    pairs = []
    for true, model in enumerate(group.models):
        for other, against in enumerate(group.models):
            if other != true:
                shown = _shown(campaign, against, records, torques[true], workers)
                now = against.cost - model.cost
                pairs.append(Pair(group.names[true], group.names[other], now, _known(against), tuple(shown)))
    return pairs


def _known(model: Model) -> FloatArray:
    J = model.problem.joint(model.q, model.setting.windows).jacobian
    return np.asarray(J[:, _moved(model)])


def _moved(model: Model) -> BoolArray:
    return np.asarray(~model.problem.coordinates.on_bound(model.q))


def predicted_torque(
    campaign: Campaign, model: Model, records: Sequence[PlannedRecord], workers: int
) -> list[FloatArray]:
    """Return the torque of a model in each record, (samples,), NaN where it cannot be simulated."""
    return map_tasks(partial(_predicted, campaign, model), records, workers)


def _predicted(campaign: Campaign, model: Model, record: PlannedRecord) -> FloatArray:
    problem = with_records(campaign, model, [record])
    target = problem.targets[-1]
    (torque,) = problem.model.predict(target, transfer_values(model.problem, model.q, problem), target.samples)
    return torque


def _shown(
    campaign: Campaign, model: Model, records: Sequence[PlannedRecord], torques: Sequence[FloatArray], workers: int
) -> list[FloatArray]:
    """Return what a model leaves of each record, and its derivatives to what it moves already."""
    return map_tasks(partial(_shown_of, campaign, model), list(zip(records, torques, strict=True)), workers)


def _shown_of(campaign: Campaign, model: Model, task: tuple[PlannedRecord, FloatArray]) -> FloatArray:
    record, torque = task
    problem = with_records(campaign, model, [record])
    there = measuring(problem.targets[-1], torque)
    q = transfer_values(model.problem, model.q, problem)
    with np.errstate(all="ignore"):
        triangle = problem.triangle(there, q, (0, there.samples))
    rows = np.column_stack([triangle.fun, triangle.jacobian])
    return without_own(rows, problem, model, q)[:, np.concatenate([[True], _moved(model)])]


def with_records(campaign: Campaign, model: Model, records: Sequence[PlannedRecord]) -> Problem:
    """Return the problem of a model with further records, the last of its targets.

    They have of their own what the model's disturbances give every record, and count as others where a record of
    their name is there already.
    """
    plain = model.setting.problem
    names = {t.name for t in plain.targets}
    new = [replace(r, name=f"{r.name} again" if r.name in names else r.name).target() for r in records]
    some = []
    if model.disturbances:
        for one in possible_disturbances(replace(plain, targets=(*plain.targets, *new)), campaign):
            if one.name in model.disturbances:
                some.append(replace(one, own={t.name: one.own[t.name] for t in new if t.name in one.own}))
    problem = with_disturbances(replace(model.problem, targets=tuple(new)), some)
    return replace(problem, targets=(*model.problem.targets, *problem.targets))


def without_own(rows: FloatArray, problem: Problem, model: Model, q: FloatArray) -> FloatArray:
    """Return residual and derivatives, (k, 1 + n), to the model's coordinates, those of the record's own eliminated."""
    size, own = problem.space.size, list(problem.coordinates.own_names)
    kept = [*range(size), *(size + own.index(name) for name in model.problem.coordinates.own_names)]
    new = [j for j in range(problem.size) if j not in kept]
    if not np.all(np.isfinite(rows)):
        return np.full((1, 1 + len(kept)), np.nan)
    away, J = problem.coordinates.prior_rows(q)
    of_new = np.any(J[:, new] != 0.0, axis=1)
    rows = np.vstack([rows, np.column_stack([away, J])[of_new]])
    across, _ = np.linalg.qr(rows[:, [1 + j for j in new]])
    rows = rows - across @ (across.T @ rows)
    return np.asarray(rows[:, [0, *(1 + j for j in kept)]])


def refitted(
    campaign: Campaign, model: Model, records: Sequence[PlannedRecord], torques: Sequence[FloatArray]
) -> tuple[float, list[FloatArray]]:
    """Return the cost of a model fitted to the records that there are and to further torques.

    Also what it leaves of each of these, (samples,) in N m, a line taken off.
    """
    problem = with_records(campaign, model, records)
    there = len(problem.targets) - len(records)
    new = [measuring(t, torque) for t, torque in zip(problem.targets[there:], torques, strict=True)]
    problem = replace(problem, targets=(*problem.targets[:there], *new))
    windows = problem.whole_windows() | dict(model.setting.windows)
    q = solve(
        problem,
        transfer_values(model.problem, model.q, problem),
        windows,
        steps=IN_DIAGNOSIS.steps,
        tolerance=IN_DIAGNOSIS.tolerance,
    ).q
    left = [t.leading.measured[:] - problem.model.predict(t, q, t.samples)[0] for t in new]
    return problem.total_norm(q, windows) ** 2, [np.asarray(detrend(e), dtype=np.float64) for e in left]


def measuring(target: Target, torque: FloatArray) -> Target:
    """Return a target that has measured a torque, (samples,) in N m."""
    return replace(target, channels=(replace(target.leading, measured=torque),))
