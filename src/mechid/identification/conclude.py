"""From the end of a search to a Fit: statuses, uncertainty, records, warnings, provenance."""

from __future__ import annotations

import hashlib
import math
import platform
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mechid.campaign import Campaign, CampaignRecord
from mechid.identification.fit import Fit, FitOutcome, ParameterEstimate, RecordFit, StageReport
from mechid.identification.gates import horizon
from mechid.identification.problem import Problem, Target, Windows
from mechid.identification.reduction import Triangle
from mechid.identification.target import target_of
from mechid.identification.uncertainty import linear_part, uncertainty
from mechid.parameter import Parameter, Status
from mechid.plant.mechanism import Mechanism

FloatArray = NDArray[np.float64]
ON_BOUND = 1e-6
"""Share of its range within which a coordinate counts as on its bound."""
UNSEEN = 1e-3
"""What the whole range of a coordinate changes of all residuals together, in sigmas, and yet is nothing."""
PACKAGES = ("mechid", "numpy", "scipy", "numba", "sympy")


@dataclass(frozen=True)
class Ending:
    """Where a search ended: all that `conclude` needs of it."""

    problem: Problem
    q: FloatArray
    windows: Windows
    outcome: FitOutcome
    stages: tuple[StageReport, ...]
    warnings: tuple[str, ...]
    moved: NDArray[np.bool_]
    seed: int
    seconds: float


@dataclass(frozen=True)
class Verdict:
    """What became of the coordinates: which carry uncertainty, and why the others do not."""

    counted: NDArray[np.bool_]
    reasons: dict[str, tuple[Status, str]]


def conclude(campaign: Campaign, ending: Ending) -> Fit:
    """Return the fit of a search that has ended, whatever its outcome."""
    problem, q = ending.problem, ending.q.copy()
    with np.errstate(all="ignore"):  # a point that cannot be simulated has no sensitivities
        triangle = problem.joint(q, ending.windows)
    verdict = _judge(ending, np.linalg.norm(triangle.jacobian, axis=0))
    unseen = ~verdict.counted & ending.moved & ~_on_bound(problem, q)
    q[unseen] = problem.start[unseen]
    names, robust, white = _covariances(ending, q, triangle, verdict)
    held = [name for name, (status, _) in verdict.reasons.items() if status is Status.FROZEN]
    starts = {name: campaign.mechanism.value(name) for name in held if name in campaign.mechanism.parameters}
    mechanism = problem.space.at(q[: problem.space.size]).with_values(starts)
    parameters = _estimates(campaign, problem, mechanism, q, verdict, names, robust, white)
    records = {r.name: _record_fit(r, ending, q) for r in campaign.records if r.data is not None}
    scale = np.sqrt(np.diag(robust))
    scale[scale == 0.0] = 1.0
    warnings = (*campaign.warnings, *ending.warnings, *_parameter_warnings(parameters))
    return Fit(
        mechanism=mechanism,
        parameters=parameters,
        correlation_names=names,
        correlation=robust / np.outer(scale, scale),
        covariance=robust,
        records=records,
        stages=ending.stages,
        outcome=ending.outcome,
        warnings=warnings,
        notes=_notes(campaign),
        provenance=_provenance(campaign, ending),
    )


def _on_bound(problem: Problem, q: FloatArray) -> NDArray[np.bool_]:
    """Return which coordinates stand on a bound of the file; that of a detent's disc is its radius."""
    span = problem.upper - problem.lower
    on = (q - problem.lower < ON_BOUND * span) | (problem.upper - q < ON_BOUND * span)
    for j, c in enumerate(problem.space.coordinates):
        if c.kind == "excess":
            static = problem.space.mechanism.parameters[c.name]
            on[j] |= problem.space.values(q[: problem.space.size])[c.name] >= static.max * (1.0 - ON_BOUND)
        if c.kind == "cosine":
            on[j] = on[j + 1] = math.hypot(q[j], q[j + 1]) > (1.0 - ON_BOUND) * c.upper
        if problem.space.is_turning(c):
            on[j] = False
    return on


def _judge(ending: Ending, size: FloatArray) -> Verdict:
    """Decide which coordinates carry uncertainty; `size` is the norm of each column of the Jacobian."""
    problem = ending.problem
    on = _on_bound(problem, ending.q)
    reasons: dict[str, tuple[Status, str]] = {}
    counted = ending.moved & ~on & (size * (problem.upper - problem.lower) > UNSEEN)
    for j, name in enumerate(problem.names):
        if not ending.moved[j]:
            reasons[name] = (Status.FROZEN, "in no stage of the campaign file")
        elif on[j]:
            reasons[name] = (Status.AT_BOUND, "the optimum lies on or beyond the bound of the mechanism file")
        elif not counted[j]:
            reasons[name] = (
                Status.FROZEN,
                "no record sees it; add a record that does, or give it as a known number",
            )
    for c in problem.space.coordinates:
        if c.partner and c.name in reasons:
            reasons[c.partner] = reasons[c.name]
    return Verdict(counted, reasons)


def _covariances(
    ending: Ending,
    q: FloatArray,
    triangle: Triangle,
    verdict: Verdict,
) -> tuple[tuple[str, ...], FloatArray, FloatArray]:
    """Return the names that carry uncertainty, and their covariances in the file's coordinates."""
    problem = ending.problem
    space_names, slopes = problem.space.value_jacobian(q[: problem.space.size])
    delays = tuple(f"record.{name}.time_offset_s" for name in problem.delayed_targets)
    whole = np.zeros((len(space_names) + len(delays), problem.size))
    whole[: len(space_names), : problem.space.size] = slopes
    whole[len(space_names) :, problem.space.size :] = np.eye(len(delays))
    names = (*space_names, *delays)
    kept = [i for i, name in enumerate(names) if name not in verdict.reasons]
    if not verdict.counted.any() or not np.isfinite(triangle.norm):
        return (), np.zeros((0, 0)), np.zeros((0, 0))
    found = uncertainty(problem, q, ending.windows, triangle, verdict.counted)
    maps = whole[kept]
    return tuple(names[i] for i in kept), maps @ found.robust @ maps.T, maps @ found.white @ maps.T


def _estimates(
    campaign: Campaign,
    problem: Problem,
    mechanism: Mechanism,
    q: FloatArray,
    verdict: Verdict,
    names: Sequence[str],
    robust: FloatArray,
    white: FloatArray,
) -> dict[str, ParameterEstimate]:
    errors = {name: (float(np.sqrt(robust[i, i])), float(np.sqrt(white[i, i]))) for i, name in enumerate(names)}
    out = {}
    for name, before in campaign.mechanism.parameters.items():
        after = replace(mechanism.parameters[name], value=mechanism.value(name))
        start = campaign.mechanism.value(name)
        out[name] = _estimate(before, after.value, start, verdict, errors)
    for record in campaign.estimated:
        for p in record.parameters:
            if p.is_free and p.name.endswith("time_offset_s"):
                target = next(t for t in problem.targets if t.name == record.name)
                out[p.name] = _estimate(p, problem.time_offset(target, q), p.value, verdict, errors)
    return out


def _estimate(
    before: Parameter, value: float, start: float, verdict: Verdict, errors: dict[str, tuple[float, float]]
) -> ParameterEstimate:
    status, reason = before.status, before.reason
    if before.is_free:
        status, reason = verdict.reasons.get(before.name, (Status.FREE, ""))
    if before.tied_to:
        reason = f"follows {before.tied_to}"
    error, white = errors.get(before.name, (None, None)) if status is Status.FREE else (None, None)
    bounded = before.is_free and not before.is_periodic
    return ParameterEstimate(
        name=before.name,
        symbol=before.declaration.symbol,
        unit=before.declaration.unit,
        value=value,
        std_error=error,
        std_error_white=white,
        start=start,
        min=before.min if bounded else None,
        max=before.max if bounded else None,
        status=str(status),
        reason=reason,
    )


def _record_fit(record: CampaignRecord, ending: Ending, q: FloatArray) -> RecordFit:
    problem = ending.problem
    target = next((t for t in problem.targets if t.name == record.name), None) or target_of(record)
    floor = target_of(record).sigma
    first, stop = (
        ending.windows.get(record.name, (0, target.samples)) if record.use == "estimate" else (0, target.samples)
    )
    measured = target.measured[first:stop]
    model = problem.predict(target, q, stop)[first:]
    fitted, offset, slope = _linear(measured - model, target)
    residual = measured - model - fitted
    spread = float(np.linalg.norm(measured - fitted - np.mean(measured - fitted)))
    follows = horizon(problem, replace(target, sigma=floor), q, target.samples, 0)
    return RecordFit(
        name=record.name,
        use=record.use,
        samples=stop - first,
        fit_percent=100.0 * (1.0 - float(np.linalg.norm(residual)) / spread) if spread > 0.0 else math.nan,
        residual_rms=float(np.sqrt(np.mean(residual**2))),
        noise_sigma=floor,
        offset=None if offset is None else offset - (slope or 0.0) * first,
        drift=None if slope is None else slope * target.base.sample_rate_hz,
        horizon_s=follows / target.base.sample_rate_hz,
    )


def _linear(r: FloatArray, target: Target) -> tuple[FloatArray, float | None, float | None]:
    """Fit what is projected out; a failed prediction leaves everything undefined."""
    if not np.all(np.isfinite(r)):
        return np.full(r.size, math.nan), None, None
    return linear_part(r, target.linear)


def _parameter_warnings(parameters: dict[str, ParameterEstimate]) -> list[str]:
    said = (Status.FROZEN, Status.AT_BOUND)
    return [f"{p.name}: {p.status.replace('_', ' ')} at {p.value:.6g} {p.unit}: {p.reason}"
            for p in parameters.values() if p.status in said]  # fmt: skip


def _notes(campaign: Campaign) -> tuple[str, ...]:
    """Say what no record of this kind can tell."""
    voltage = (
        "stepper.peak_voltage is taken as known: without a current or voltage channel a relative error e of it "
        "enters the torque constant as e, coil resistance and inductance as 2 e, unseen."
    )
    return voltage, _frame(campaign)


def _frame(campaign: Campaign) -> str:
    """Say which turns, reversals and moves give the same records."""
    mechanism = campaign.mechanism
    period = 720.0 / mechanism.value("stepper.poles")
    orders = [
        period / mechanism.value(p.amplitude.replace("amplitude", "period_deg")) for p in mechanism.plant.polar_pairs
    ]
    turned = " and ".join(f"-{order:g} delta" for order in orders)
    phases = f" with the detent phases turned by {turned}" if orders else ""
    return (
        f"The start angle and direction of record {campaign.records[0].name} fix the frame: the same records come from "
        f"all start angles turned by delta{phases} (square waveform: delta in steps of 90 deg), from all signs "
        "reversed with those of the phases, and from a move by whole teeth."
    )


def _provenance(campaign: Campaign, ending: Ending) -> dict[str, object]:
    inputs = {str(p.name): _digest(p) for p in (campaign.path, campaign.mechanism_path)}
    inputs |= {r.data.path.name: r.data.digest for r in campaign.records if r.data is not None}
    return {
        "versions": {name: version(name) for name in PACKAGES} | {"python": platform.python_version()},
        "inputs_sha256": inputs,
        "seed": ending.seed,
        "substeps": ending.problem.substeps,
        "wall_time_s": ending.seconds,
        "plant": ending.problem.space.mechanism.plant.digest,
    }


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""
