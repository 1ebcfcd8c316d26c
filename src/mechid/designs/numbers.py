"""Results of a design as one plain dict, which all outputs share."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from mechid.designs.alternatives import Group
from mechid.designs.criterion import KINDS
from mechid.designs.design import Design
from mechid.designs.group_separation import GroupSeparation
from mechid.designs.loss_table import LossRow
from mechid.designs.planned_record import PlannedRecord
from mechid.designs.rate_limit import RateLimit
from mechid.designs.rate_map import RateMap
from mechid.designs.record_set import RecordSet
from mechid.designs.separation import CLEAR
from mechid.designs.settings import RATE
from mechid.designs.step_loss import Margins
from mechid.identification.result.estimate_file import provenance_of_fits

FORMAT = "mechid-design/1"
DETERMINED_DEG = 90.0
"""Standard error above which a phase is undetermined, deg."""


def design_numbers(design: Design) -> dict[str, Any]:
    """Return every result of a design that is shown."""
    options, limits = design.options, design.options.limits
    kind = options.criterion
    return {
        "format": FORMAT,
        "provenance": provenance_of_fits(*filter(None, [design.fit_digest])),
        "campaign": str(design.campaign.path),
        "after_fit": design.knowledge.known is not None,
        "synthetic": design.knowledge.known is not None and design.campaign.synthetic,
        "mechanisms": len(design.knowledge.points),
        "criterion": {"kind": kind, "over": options.over, "is_parameter": kind not in KINDS},
        "limits": {
            "total_s": design.total_s,
            "between_s": limits.between_s,
            "torque_Nm": limits.torque_Nm,
            "most_of_one": limits.most_of_one,
            "keep": list(limits.keep),
            "risk": limits.risk,
            "departing": limits.departing,
        },
        "planned": _set(design, design.planned),
        "chosen": _set(design, design.chosen),
        "gain_factor": math.exp(design.planned.criterion - design.chosen.criterion),
        "trail": list(design.trail),
        "parameters": _parameters(design),
        "candidates": [
            {
                **_record(design, r),
                "peak_torque_Nm": float(peak),
                "departing": float(share),
                "objection": objection,
                "tells_apart": _tells_apart(design, k),
            }
            for k, (r, peak, share, objection) in enumerate(
                zip(design.candidates, design.peaks, design.departing, design.objections, strict=True)
            )
        ],
        "torque_over_rate": [_map(m) for m in design.maps],
        "step_loss": [_loss(row) for row in design.losses],
        "step_loss_search": {
            "far_ratio": RATE.far,
            "near_ratio": RATE.near,
            "least_steps_per_s": RATE.least,
            "slow_ratio": RATE.slow_ratio,
            "end_share": RATE.resolution,
        },
        "margins": {name: _margins(m) for name, m in design.margins.items()},
        "warnings": list(design.warnings),
        "rivals": _rivals(design),
    }


def _tells_apart(design: Design, record: int) -> dict[str, float | None]:
    """Return the least expected chi-square between alternatives after a record, by the first of each group."""
    if design.separation is None:
        return {}
    return {one.group.names[0]: one.worst(record) for one in design.separation.groups}


def _rivals(design: Design) -> list[dict[str, Any]] | None:
    """Return one entry per group of alternative explanations; None without a diagnosis or without alternatives."""
    found = design.separation
    return None if found is None else [_group(design, one, found.chosen) for one in found.groups]


def _group(design: Design, one: GroupSeparation, chosen: Iterable[int]) -> dict[str, Any]:
    names = [design.candidates[k].name for k in chosen] if one.promises else []
    between_s = design.options.limits.between_s
    pairs = zip(one.pairs, one.promises or (None,) * len(one.pairs), strict=True)
    return {
        "names": list(one.group.names),
        "now": _now(one.group),
        "told_already": one.is_resolved,
        "needed": CLEAR,
        "clear": one.is_clear,
        "expected": one.expected_chi_square,
        "records": names,
        "seconds": sum(design.candidates[k].duration_s + between_s for k in chosen) if names else 0.0,
        "pairs": [
            {
                "if_true": pair.true,
                "against": pair.against,
                "now": pair.now,
                "first_order": promise.first_order if promise else None,
                "expected": promise.by_refit if promise else None,
                "record": promise.record if promise else None,
                "differ_rms_Nm": promise.rms_Nm if promise else None,
                "differ_most_hz": promise.frequency_hz if promise else None,
            }
            for pair, promise in pairs
        ],
        "farthest": {"records": [design.candidates[k].name for k in one.far], "expected": one.reach},
    }


def _now(group: Group) -> dict[str, float]:
    """Return the chi-square of each alternative above that of the best one, on the existing records."""
    best = min(model.cost for model in group.models)
    return {name: model.cost - best for name, model in zip(group.names, group.models, strict=True)}


def _set(design: Design, records: RecordSet) -> dict[str, Any]:
    return {
        "records": [_record(design, r) for r in records.records],
        "seconds": records.seconds,
        "criterion": records.criterion,
        "std_error": {name: records.errors.std_error(name) for name in records.errors.names},
        "reasons": dict(records.errors.reasons),
        "correlation": {"names": list(records.errors.names), "matrix": records.errors.correlation.tolist()},
    }


def _parameters(design: Design) -> list[dict[str, Any]]:
    """Return one row per parameter: assumed value, standard errors with the planned and with the chosen records."""
    rows = []
    for q in design.mechanism.free:
        sets = {"planned": design.planned, "chosen": design.chosen}
        row: dict[str, Any] = {
            "name": q.name,
            "symbol": q.declaration.symbol,
            "unit": q.declaration.unit,
            "value": q.value,
            "size": _size(design, q.name),
        }
        for key, records in sets.items():
            row[key] = _knowable(records.errors.std_error(q.name), q.declaration.unit)
            row[f"{key}_reason"] = records.errors.reasons.get(q.name, "")
            row[f"{key}_spread"] = [_knowable(v, q.declaration.unit) for v in records.spread[q.name]]
        row["by_record"] = [_knowable(v, q.declaration.unit) for v in design.errors_by_record[q.name]]
        rows.append(row)
    return rows


def _size(design: Design, name: str) -> float:
    """Return the root mean square of a parameter over the possible mechanisms."""
    space = design.knowledge.space
    values = [space.values(q)[name] for q in design.knowledge.points]
    return math.sqrt(sum(v**2 for v in values) / len(values))


def _knowable(sigma: float | None, unit: str) -> float | None:
    return None if sigma is not None and unit == "deg" and sigma > DETERMINED_DEG else sigma


def _record(design: Design, record: PlannedRecord) -> dict[str, Any]:
    command = record.command
    return {
        "name": record.name,
        "stepping": command.stepping,
        "microsteps": command.steps_per_full_step,
        "rate_profile": [list(p) for p in zip(command.rate.times_s, command.rate.rates, strict=True)],
        "start_angle_deg": command.start_angle_deg,
        "waveform": command.waveform_name,
        "duration_s": record.duration_s,
        "sample_rate_hz": record.sample_rate_hz,
        "noise_Nm": record.sigma,
        "planned": record.name in {r.name for r in design.campaign.records},
    }


def _map(found: RateMap) -> dict[str, Any]:
    return {
        "stepping": found.stepping,
        "rate": found.rates.tolist(),
        "amplitude_Nm": found.amplitude.tolist(),
        "mechanisms": found.mechanisms,
        "low_Nm": found.spread[0].tolist(),
        "high_Nm": found.spread[1].tolist(),
        "peaks": [{"rate": rate, "amplitude_Nm": amplitude} for rate, amplitude in found.peaks],
    }


def _loss(row: LossRow) -> dict[str, Any]:
    return {
        "stepping": row.stepping,
        "changed": row.changed,
        "to": row.to,
        "pull_in": _limit(row.pull_in),
        "pull_out": _limit(row.pull_out),
    }


def _limit(limit: RateLimit) -> dict[str, Any]:
    return {
        "rate": limit.rate,
        "holds_again": limit.holds_again,
        "ranges": [list(r) for r in limit.ranges],
        "holes": [list(r) for r in limit.holes],
        "limit": limit.limit,
        "searched": list(limit.searched),
        "brought_from": limit.brought_from,
    }


def _margins(found: Margins) -> dict[str, Any]:
    return {
        "lost": found.lost,
        "voltage": found.voltage,
        "torque_Nm": found.torque_Nm,
        "inertia_factor": found.inertia_factor,
    }


def rate_rows(data: Mapping[str, Any]) -> Iterable[str]:
    """Yield the lines of the torque over the rate as CSV."""
    maps = data["torque_over_rate"]
    yield (
        "rate_steps_per_s,"
        + ",".join(f"{m['stepping']}_Nm,{m['stepping']}_low_Nm,{m['stepping']}_high_Nm" for m in maps)
        + "\n"
    )
    for k, rate in enumerate(maps[0]["rate"]):
        cells = (f"{m[key][k]:.6g}" for m in maps for key in ("amplitude_Nm", "low_Nm", "high_Nm"))
        yield f"{rate:.6g}," + ",".join(cells) + "\n"
