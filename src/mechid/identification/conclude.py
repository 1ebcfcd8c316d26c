"""From the end of a search to a Fit: statuses, uncertainty, records, warnings, provenance."""

from __future__ import annotations

import hashlib
import math
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mechid.campaign import Campaign
from mechid.identification.doubts import indistinct
from mechid.identification.fit import Fit, FitOutcome, ParameterEstimate, StageReport
from mechid.identification.problem import Problem, Windows
from mechid.identification.record_fit import record_fit
from mechid.identification.reduction import Triangle
from mechid.identification.uncertainty import uncertainty
from mechid.identification.verdict import Verdict, judge
from mechid.parameter import Parameter, Status
from mechid.plant.mechanism import Mechanism

FloatArray = NDArray[np.float64]
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
    seed: int
    seconds: float


def conclude(campaign: Campaign, ending: Ending) -> Fit:
    """Return the fit of a search that has ended, whatever its outcome."""
    problem, windows = ending.problem, ending.windows
    with np.errstate(all="ignore"):  # a point that cannot be simulated has no sensitivities
        triangle = problem.joint(ending.q, windows)
    verdict = judge(campaign, problem, ending.q, windows, triangle)
    q = verdict.q
    names, robust, white = _covariances(ending, triangle, verdict)
    mechanism = _mechanism(campaign, problem, verdict)
    parameters = _estimates(campaign, problem, mechanism, verdict, names, robust, white)
    scale = np.sqrt(np.diag(robust))
    scale[scale == 0.0] = 1.0
    return Fit(
        mechanism=mechanism,
        parameters=parameters,
        correlation_names=names,
        correlation=robust / np.outer(scale, scale),
        covariance=robust,
        records={r.name: record_fit(r, problem, q, windows) for r in campaign.records if r.data is not None},
        stages=ending.stages,
        outcome=ending.outcome,
        warnings=(*campaign.warnings, *ending.warnings, *_warnings(problem, triangle, verdict, parameters)),
        notes=_notes(campaign),
        provenance=_provenance(campaign, ending),
    )


def _mechanism(campaign: Campaign, problem: Problem, verdict: Verdict) -> Mechanism:
    """Return the campaign's mechanism with what was found; what is not moved keeps its value to the bit."""
    found = problem.space.values(verdict.q[: problem.space.size])
    starts = {name: campaign.mechanism.value(name) for name in found}
    frozen = {name for name, (status, _) in verdict.reasons.items() if status is Status.FROZEN}
    back = {n: v for n, v in starts.items() if n in frozen and math.isclose(v, found[n], rel_tol=1e-9)}
    return campaign.mechanism.with_values({**found, **back})


def _covariances(
    ending: Ending, triangle: Triangle, verdict: Verdict
) -> tuple[tuple[str, ...], FloatArray, FloatArray]:
    """Return the names that carry uncertainty, and their covariances in the file's coordinates."""
    problem, q = ending.problem, verdict.q
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
    verdict: Verdict,
    names: Sequence[str],
    robust: FloatArray,
    white: FloatArray,
) -> dict[str, ParameterEstimate]:
    errors = {name: (float(np.sqrt(robust[i, i])), float(np.sqrt(white[i, i]))) for i, name in enumerate(names)}
    out = {}
    for name, before in campaign.mechanism.parameters.items():
        start = campaign.mechanism.value(name)
        out[name] = _estimate(before, mechanism.value(name), start, verdict, errors)
    for record in campaign.estimated:
        for p in record.parameters:
            if p.is_free and p.name.endswith("time_offset_s"):
                target = next(t for t in problem.targets if t.name == record.name)
                out[p.name] = _estimate(p, problem.time_offset(target, verdict.q), p.value, verdict, errors)
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


def _warnings(
    problem: Problem, triangle: Triangle, verdict: Verdict, parameters: Mapping[str, ParameterEstimate]
) -> list[str]:
    """Say which parameters have no uncertainty of their own, and which cannot be told from one another."""
    said = (Status.FROZEN, Status.AT_BOUND)
    lines = [f"{p.name}: {p.status.replace('_', ' ')} at {p.value:.6g} {p.unit}: {p.reason}"
             for p in parameters.values() if p.status in said]  # fmt: skip
    if not np.all(np.isfinite(triangle.jacobian)):
        return lines
    groups = indistinct(triangle, problem.names, verdict.counted)
    return lines + [
        f"{', '.join(group)}: the records tell only of a combination of them; give one as a known number"
        for group in groups
    ]


def _notes(campaign: Campaign) -> tuple[str, ...]:
    """Say what no record of this kind can tell."""
    if "stepper.peak_voltage" not in campaign.mechanism.parameters:
        return (_frame(campaign),) if "stepper.poles" in campaign.mechanism.parameters else ()
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
        period / mechanism.value(p.amplitude.replace("amplitude", "period_deg"))
        for p in mechanism.plant.polar_pairs
        if p.amplitude.startswith("stepper.detent.")
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
        "records": {r.name: r.data.provenance for r in campaign.records if r.data is not None},
        "seed": ending.seed,
        "substeps": ending.problem.substeps,
        "wall_time_s": ending.seconds,
        "plant": ending.problem.space.mechanism.plant.digest,
    }


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""
