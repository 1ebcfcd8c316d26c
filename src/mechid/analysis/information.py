"""Which record and which channel tells what: the information that each holds on each parameter."""

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
from mechid.identification.result.as_fitted import record_as_fitted
from mechid.identification.result.fit import Fit
from mechid.identification.result.record_result import RecordFit
from mechid.parameter import Parameter, Status


@dataclass(frozen=True, kw_only=True, eq=False)
class Information:
    """What the records that were estimated from tell of the free parameters, residuals taken as white.

    Attributes
    ----------
    parameters, records : tuple of str
        P and K names.
    share : (P, K)
        Part of the Fisher information on a parameter that a record holds, all others fixed; rows sum to 1.
    without : (P, K)
        Factor on the standard error if the record were missing; inf where the others cannot tell.
    repeated : (P, K)
        Factor on the standard error if the record were there twice.
    channels : tuple of str
        C quantities, in the order of the plant.
    channel_share, without_channel : (P, C)
        The same of the quantities, each over all records: part of the information, and factor on the standard error
        if it were not measured.
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
    """Return the information by record and by channel at an estimate, each record over its whole length.

    The Fisher matrix of a channel is J^T J / s^2 with the exact Jacobian J and the residual's RMS s; offset and
    drift are projected out. None where nothing is free, a simulation fails, or all records together leave a
    direction undetermined.
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
        Part(target.name, quantity, triangle.jacobian @ to_search)
        for target, own in zip(problem.targets, triangles, strict=True)
        for quantity, triangle in zip(target.quantities, own or (), strict=bool(own))
    ]
    if None in triangles or not all(np.all(np.isfinite(part.jacobian)) for part in parts):
        return None
    return _judged(names, tuple(problem.space.mechanism.plant.outputs), parts)


@dataclass(frozen=True, eq=False)
class Part:
    """What one channel of a record tells: its Jacobian to the file's values in sigmas, (n, P)."""

    record: str
    quantity: str
    jacobian: FloatArray


def _problem(campaign: Campaign, fit: Fit) -> Problem:
    """Return the fit's problem at its end: its values, its free parameters, residuals' RMS as noise.

    What every record has of its own is told by each of that one; the mechanism's, their mean, by none.
    """
    free = tuple(name for name, p in fit.parameters.items() if p.status == Status.FREE)
    mechanism = fit.mechanism
    targets = []
    taken = [r for record in campaign.records if record.data and (r := record_as_fitted(record, fit)).use == "estimate"]
    for record in taken:
        target = _as_left(target_of(record), fit.records[record.name])
        targets.append(replace(target, own=tuple(_as_found(q, fit) for q in target.own)))
    of_records = set.intersection(*({q.replaces for q in target.own} for target in targets)) if targets else set()
    mechanism = mechanism.with_free(tuple(name for name in free if name not in of_records))
    substeps = fit.provenance.get("substeps")
    return Problem(
        SearchSpace(mechanism),
        tuple(targets),
        substeps=substeps if isinstance(substeps, int) else 1,
        workers=os.cpu_count() or 1,
    )


def _as_found(parameter: Parameter, fit: Fit) -> Parameter:
    """Return a record's own parameter where the fit found it, free where it is estimated."""
    own = fit.parameters.get(parameter.name)
    if own is None:
        return parameter
    return replace(parameter, value=own.value, status=Status.FREE if own.status == Status.FREE else Status.KNOWN)


def _as_left(target: Target, own: RecordFit) -> Target:
    """Return a target whose noise is what the fit leaves of its channels."""
    return target.map_channels(lambda channel: replace(channel, sigma=own.residual_of(channel.quantity)))


def _judged(names: tuple[str, ...], outputs: tuple[str, ...], parts: list[Part]) -> Information | None:
    scale = np.sqrt(sum(np.sum(part.jacobian**2, axis=0) for part in parts))
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
    """Return the diagonal of the inverse; inf for every parameter in a direction that is not determined."""
    values, vectors = np.linalg.eigh(fisher)
    lost = values <= 1e-13 * max(float(values[-1]), 1e-300)
    inverse = np.where(lost, 0.0, 1.0 / np.where(lost, 1.0, values))
    diagonal = np.einsum("ij,j,ij->i", vectors, inverse, vectors)
    undetermined = np.sum(vectors[:, lost] ** 2, axis=1) > 1e-12
    return np.where(undetermined, np.inf, diagonal)
