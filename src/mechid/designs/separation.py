"""Separation of alternative explanations by further records.

If one alternative is true, the free parameters of the other one and all parameters of the mechanism adjust to the
existing and new records together. The remaining misfit is, to first order, the distance of the true one's prediction
from the span of the other one's derivatives on all records: the T-criterion of Atkinson and Fedorov (1975). Samples are
divided by their noise; offset, drift and per-record parameters are projected out.
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
from mechid.designs.alternatives import Group
from mechid.designs.planned_record import PlannedRecord
from mechid.designs.settings import DESIGN
from mechid.identification.computation.parallel import map_tasks
from mechid.identification.diagnosis.candidate import CandidateModel
from mechid.identification.effects.campaign_disturbances import possible_disturbances
from mechid.identification.effects.disturbance import with_disturbances
from mechid.identification.effects.settings import IN_DIAGNOSIS
from mechid.identification.output_error.problem import Problem, transfer_values
from mechid.identification.output_error.target import Target
from mechid.identification.search.solve import solve

CLEAR = (DESIGN.chance + math.sqrt(DESIGN.chance**2 + IN_DIAGNOSIS.least_chi_square)) ** 2
"""Expected chi-square from which a record separates alternatives: noise makes it scatter by twice its root;
`DESIGN.chance` standard deviations below, it still reaches the threshold of a diagnosis."""


@dataclass(frozen=True, eq=False)
class Pair:
    """Ordered pair of alternatives, the first one assumed true.

    Attributes
    ----------
    true, against : str
        Their names.
    now : float
        Chi-square of the other one above that of the true one on the existing records.
    known : (m, n)
        Derivatives of the other one on these records, in standard deviations of the noise.
    shown : tuple of (k, 1 + n)
        Residual of the present other one on each further record, and its derivatives, likewise; infinite if it cannot
        be simulated.
    """

    true: str
    against: str
    now: float
    known: FloatArray
    shown: tuple[FloatArray, ...]

    def expected_chi_square(self, records: Sequence[int]) -> float:
        """Return the chi-square of the other one above that of the true one after some further records."""
        return self.now + least_misfit(self.known, [self.shown[k] for k in records])


def least_misfit(known: FloatArray, shown: Sequence[FloatArray]) -> float:
    """Return the least sum of squares on further records that parameters leave while still fitting the known ones.

    Parameters
    ----------
    known : (m, n)
        Derivatives on the known records, at their optimum.
    shown : sequence of (k, 1 + n)
        Residual and derivatives on each further record.
    """
    rows = np.vstack([np.column_stack([np.zeros(len(known)), known]), *shown])
    # A record that cannot be simulated separates nothing.
    if not np.all(np.isfinite(rows)):
        return 0.0
    r, J = rows[:, 0], rows[:, 1:]
    # Columns of unit length: coordinates of different units share one rank tolerance.
    size = np.linalg.norm(J, axis=0)
    J = J / np.where(size > 0.0, size, 1.0)
    step = np.linalg.lstsq(J, -r, rcond=1e-12)[0]
    return float(np.sum((r + J @ step) ** 2))


def pairs_of(campaign: Campaign, group: Group, records: Sequence[PlannedRecord], workers: int = 1) -> list[Pair]:
    """Return every ordered pair of a group's alternatives, with the residuals that each record would show."""
    torques = [predicted_torque(campaign, model, records, workers) for model in group.models]
    pairs = []
    for true, model in enumerate(group.models):
        for other, against in enumerate(group.models):
            if other != true:
                shown = _rows_of_records(campaign, against, records, torques[true], workers)
                now = against.cost - model.cost
                pairs.append(Pair(group.names[true], group.names[other], now, _known_jacobian(against), tuple(shown)))
    return pairs


def _known_jacobian(model: CandidateModel) -> FloatArray:
    J = model.problem.joint(model.q, model.setting.windows).jacobian
    return np.asarray(J[:, _is_inside_bounds(model)])


def _is_inside_bounds(model: CandidateModel) -> BoolArray:
    return np.asarray(~model.problem.coordinates.on_bound(model.q))


def predicted_torque(
    campaign: Campaign, model: CandidateModel, records: Sequence[PlannedRecord], workers: int
) -> list[FloatArray]:
    """Return the torque of a model in each record, (samples,), NaN if it cannot be simulated."""
    return map_tasks(partial(_predict, campaign, model), records, workers)


def _predict(campaign: Campaign, model: CandidateModel, record: PlannedRecord) -> FloatArray:
    problem = with_records(campaign, model, [record])
    target = problem.targets[-1]
    (torque,) = problem.model.predict(target, transfer_values(model.problem, model.q, problem), target.samples)
    return torque


def _rows_of_records(
    campaign: Campaign,
    model: CandidateModel,
    records: Sequence[PlannedRecord],
    torques: Sequence[FloatArray],
    workers: int,
) -> list[FloatArray]:
    """Return the residual of a model on each record, and its derivatives with respect to the adjusted parameters."""
    return map_tasks(partial(_record_rows, campaign, model), list(zip(records, torques, strict=True)), workers)


def _record_rows(campaign: Campaign, model: CandidateModel, task: tuple[PlannedRecord, FloatArray]) -> FloatArray:
    record, torque = task
    problem = with_records(campaign, model, [record])
    there = with_measured(problem.targets[-1], torque)
    q = transfer_values(model.problem, model.q, problem)
    with np.errstate(all="ignore"):
        triangle = problem.triangle(there, q, (0, there.samples))
    rows = np.column_stack([triangle.fun, triangle.jacobian])
    return without_own(rows, problem, model, q)[:, np.concatenate([[True], _is_inside_bounds(model)])]


def with_records(campaign: Campaign, model: CandidateModel, records: Sequence[PlannedRecord]) -> Problem:
    """Return the problem of a model with further records, the last of its targets.

    They get the per-record parameters that the model's disturbances give every record, and a new name if a record of
    their name exists already.
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


def without_own(rows: FloatArray, problem: Problem, model: CandidateModel, q: FloatArray) -> FloatArray:
    """Return residual and derivatives, (k, 1 + n), for the model's coordinates, per-record parameters eliminated."""
    size, own = problem.space.size, list(problem.coordinates.record_parameter_names)
    kept = [*range(size), *(size + own.index(name) for name in model.problem.coordinates.record_parameter_names)]
    new = [j for j in range(problem.size) if j not in kept]
    if not np.all(np.isfinite(rows)):
        return np.full((1, 1 + len(kept)), np.nan)
    away, J = problem.coordinates.prior_rows(q)
    of_new = np.any(J[:, new] != 0.0, axis=1)
    # Priors of the new per-record parameters limit how much of a difference these can absorb.
    rows = np.vstack([rows, np.column_stack([away, J])[of_new]])
    across, _ = np.linalg.qr(rows[:, [1 + j for j in new]])
    rows = rows - across @ (across.T @ rows)
    return np.asarray(rows[:, [0, *(1 + j for j in kept)]])


def refit(
    campaign: Campaign, model: CandidateModel, records: Sequence[PlannedRecord], torques: Sequence[FloatArray]
) -> tuple[float, list[FloatArray]]:
    """Return the cost of a model fitted to the existing records and to further torques.

    Also return its residual on each of these, (samples,) in N m, with a linear trend removed.
    """
    problem = with_records(campaign, model, records)
    there = len(problem.targets) - len(records)
    new = [with_measured(t, torque) for t, torque in zip(problem.targets[there:], torques, strict=True)]
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


def with_measured(target: Target, torque: FloatArray) -> Target:
    """Return a target with a given measured torque, (samples,) in N m."""
    return replace(target, channels=(replace(target.leading, measured=torque),))
