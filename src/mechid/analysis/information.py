"""Fisher information of each record and channel on each parameter."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign import Campaign
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.reduction import channel_triangles
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import Target, target_of
from mechid.identification.result.finished_fit import record_as_fitted
from mechid.identification.result.fit import Fit
from mechid.identification.result.record_result import RecordFit
from mechid.parameter import Parameter, Status


@dataclass(frozen=True, kw_only=True, eq=False)
class Information:
    """Information of the fitted records on the free parameters, assuming white residuals.

    Attributes
    ----------
    parameters, records : tuple of str
        P and K names, respectively.
    share : (P, K)
        Share of each record in the Fisher information on a parameter, all others fixed; rows sum to 1.
    without : (P, K)
        Factor on the standard error if the record were missing; inf if the others cannot determine it.
    repeated : (P, K)
        Factor on the standard error if the record were present twice.
    channels : tuple of str
        C quantities, in the order of the plant.
    channel_share, without_channel : (P, C)
        The same for the quantities, each over all records: share of the information, and factor on the standard
        error if the quantity were not measured.
    """

    parameters: tuple[str, ...]
    records: tuple[str, ...]
    share: FloatArray
    without: FloatArray
    repeated: FloatArray
    channels: tuple[str, ...]
    channel_share: FloatArray
    without_channel: FloatArray


def record_information(campaign: Campaign, fit: Fit) -> Information | None:
    """Compute the information by record and by channel at an estimate, each record over its whole length.

    The Fisher matrix of a channel is J^T J / s^2 with the exact Jacobian J and the residual's RMS s; offset and
    drift are projected out. None if nothing is free, a simulation fails, or the records leave a direction
    undetermined.
    """
    problem = _problem(campaign, fit)
    if problem.size == 0:
        return None
    q = problem.start
    whole = problem.whole_windows()
    with np.errstate(all="ignore"):
        triangles = [channel_triangles(problem.model, t, q, whole[t.name]) for t in problem.targets]
    names, slopes = problem.coordinates.value_slopes(q)
    to_search = np.linalg.inv(slopes)
    parts = [
        ChannelJacobian(target.name, quantity, triangle.jacobian @ to_search)
        for target, own in zip(problem.targets, triangles, strict=True)
        for quantity, triangle in zip(target.quantities, own or (), strict=bool(own))
    ]
    if None in triangles or not all(np.all(np.isfinite(part.jacobian)) for part in parts):
        return None
    return _information(names, tuple(problem.space.mechanism.plant.outputs), parts)


@dataclass(frozen=True, eq=False)
class ChannelJacobian:
    """Jacobian of one channel of a record with respect to the values of the file, in sigmas, (n, P)."""

    record: str
    quantity: str
    jacobian: FloatArray


def _problem(campaign: Campaign, fit: Fit) -> Problem:
    """Rebuild the problem of the fit at its estimate, with the RMS of the residuals as noise levels.

    A mechanism parameter that every record overrides is not free: the records determine only their own values.
    """
    free = tuple(name for name, p in fit.parameters.items() if p.status == Status.FREE)
    mechanism = fit.mechanism
    targets = []
    taken = [r for record in campaign.records if record.data and (r := record_as_fitted(record, fit)).use == "estimate"]
    for record in taken:
        target = _with_residual_noise(target_of(record), fit.records[record.name])
        targets.append(replace(target, own=tuple(_at_estimate(q, fit) for q in target.own)))
    of_records = set.intersection(*({q.replaces for q in target.own} for target in targets)) if targets else set()
    mechanism = mechanism.with_free(tuple(name for name in free if name not in of_records))
    substeps = fit.provenance.get("substeps")
    return Problem(
        SearchSpace(mechanism),
        tuple(targets),
        substeps=substeps if isinstance(substeps, int) else 1,
        workers=os.cpu_count() or 1,
    )


def _at_estimate(parameter: Parameter, fit: Fit) -> Parameter:
    """Set a per-record parameter to its estimate, free if it is estimated."""
    own = fit.parameters.get(parameter.name)
    if own is None:
        return parameter
    return replace(parameter, value=own.value, status=Status.FREE if own.status == Status.FREE else Status.KNOWN)


def _with_residual_noise(target: Target, own: RecordFit) -> Target:
    """Set the noise levels of a target to the residual RMS of its channels."""
    return target.map_channels(lambda channel: replace(channel, sigma=own.residual_of(channel.quantity)))


def _information(names: tuple[str, ...], outputs: tuple[str, ...], parts: list[ChannelJacobian]) -> Information | None:
    # Scaled to a unit diagonal, so that the eigenvalues in `_variances` compare parameters of any unit.
    scale = np.sqrt(sum(np.sum(part.jacobian**2, axis=0) for part in parts))
    # A parameter without any sensitivity has no information in any record.
    if not np.all(scale > 0.0):
        return None
    each = [(part, (part.jacobian / scale).T @ (part.jacobian / scale)) for part in parts]
    records = tuple(dict.fromkeys(part.record for part in parts))
    channels = tuple(quantity for quantity in outputs if any(part.quantity == quantity for part in parts))
    by_record = [np.sum([F for part, F in each if part.record == record], axis=0) for record in records]
    by_channel = [np.sum([F for part, F in each if part.quantity == quantity], axis=0) for quantity in channels]
    total = np.sum(by_record, axis=0)
    variance = _variances(total)
    if not np.all(np.isfinite(variance)):
        return None

    def factors(fishers: list[FloatArray]) -> FloatArray:
        return np.sqrt(np.column_stack([_variances(F) for F in fishers]) / variance[:, None])

    return Information(
        parameters=names,
        records=records,
        share=np.column_stack([np.diag(F) for F in by_record]),
        without=factors([total - F for F in by_record]),
        repeated=factors([total + F for F in by_record]),
        channels=channels,
        channel_share=np.column_stack([np.diag(F) for F in by_channel]),
        without_channel=factors([total - F for F in by_channel]),
    )


def _variances(fisher: FloatArray) -> FloatArray:
    """Return the diagonal of the inverse; inf for parameters in undetermined directions."""
    values, vectors = np.linalg.eigh(fisher)
    # Relative to the largest eigenvalue, at the level of rounding; the least value guards a zero matrix.
    lost = values <= 1e-13 * max(float(values[-1]), 1e-300)
    inverse = np.where(lost, 0.0, 1.0 / np.where(lost, 1.0, values))
    diagonal = np.einsum("ij,j,ij->i", vectors, inverse, vectors)
    undetermined = np.sum(vectors[:, lost] ** 2, axis=1) > 1e-12
    return np.where(undetermined, np.inf, diagonal)
