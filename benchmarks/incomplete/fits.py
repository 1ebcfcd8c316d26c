"""What of a fit is kept: its values beside the truth, its errors, how consistent its parts are, what it cost."""

import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from mechid.campaign import Campaign, CampaignRecord
from mechid.identification.identify import identify
from mechid.identification.result.estimate_file import json_text
from mechid.identification.result.fit import Fit
from mechid.identification.result.parameter_estimate import ParameterEstimate
from mechid.writing import write_atomically

PARTS = ("whole", "first", "second", "reference")
"""All of the records; the first and the second half of the samples of each; all of them without the effect."""


def fitted(
    campaign: Campaign,
    truth: Mapping[str, float],
    near: Mapping[str, float] | None,
    workers: int | None = 1,
    keep: Path | None = None,
) -> dict[str, Any]:
    """Fit a campaign from values near its optimum, or by a search where there are none, and return what is kept of it.

    `concluding_s` is what comes after the search: identifiability, standard errors and their test by draws. The whole
    estimate is written to the file `keep`.
    """
    began, began_cpu = time.perf_counter(), time.process_time()
    fit = identify(campaign, workers=workers, near=near)
    wall, cpu = time.perf_counter() - began, time.process_time() - began_cpu
    if keep:
        keep.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(keep, json_text(fit.to_dict()))
    return {
        "outcome": fit.outcome.code,
        "grade": str(fit.grade),
        "reasons": [str(reason.cause) for reason in fit.reasons],
        "wall_s": wall,
        "cpu_s": cpu,
        "concluding_s": wall - fit.provenance["wall_time_s"],
        "parameters": {name: _parameter(fit.parameters[name], value) for name, value in truth.items()},
        "correlation": {"names": list(fit.correlation_names), "matrix": fit.correlation.tolist()},
        "consistency": fit.consistency.to_dict() if fit.consistency else None,
        "agrees": fit.consistency.agrees if fit.consistency else None,
        "records": _records(fit),
        "missing": [one.to_dict() for one in fit.missing],
        "warnings": list(fit.warnings),
    }


def _parameter(found: ParameterEstimate, truth: float) -> dict[str, Any]:
    keys = ("value", "unit", "std_error", "std_error_noise", "std_error_white", "dof", "status", "contradicted", "ci95")
    return {"truth": truth, **{key: getattr(found, key) for key in keys}}


def _records(fit: Fit) -> dict[str, Any]:
    keys = ("samples", "residual_rms", "noise_sigma", "fit_percent", "prefilter_order")
    followed = ("followed_percent", "worst", "worst_at_s")
    return {
        name: {key: getattr(record, key) for key in keys}
        | {key: getattr(channel, key) for channel in record.channels.values() for key in followed}
        for name, record in fit.records.items()
    }


def half(campaign: Campaign, part: str) -> Campaign:
    """Return a campaign of the first or the second half of each record's samples, its times as they were."""
    return replace(campaign, records=tuple(_half(record, part) for record in campaign.records))


def _half(record: CampaignRecord, part: str) -> CampaignRecord:
    data = record.data
    middle = data.samples // 2
    chosen = slice(middle) if part == "first" else slice(middle, None)
    channels = tuple(replace(channel, data=channel.data[chosen]) for channel in data.channels)
    start = data.time_start_s + (chosen.start or 0) / data.sample_rate_hz
    return replace(record, data=replace(data, time_start_s=start, channels=channels))
