"""Complete content of a report: the numbers of the terminal, the details, and the verdict."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from mechid.analysis.information import record_information
from mechid.campaign import Campaign
from mechid.identification.result.fit import Fit
from mechid.ink.digits import plain
from mechid.ink.quantities import has_only_torque
from mechid.reports.details import correlation_data, driven_data, information_data, meaning_data, resonance_data
from mechid.reports.noise import compare_with_noise, level_words, raised_words
from mechid.reports.use import use_word
from mechid.reports.verdict import summary_data
from mechid.simulation.resonances import resonances


def report_contents(data: Mapping[str, Any], campaign: Campaign, fit: Fit) -> dict[str, Any]:
    """Return the dict of `report_data` with the details and the verdict of the report.

    Parameters
    ----------
    data : mapping
        As `report_data` makes it, with the validation of all records.
    campaign : Campaign
        The one that was identified, its records read.
    fit : Fit
    """
    more = {
        **data,
        "title": campaign.path.resolve().parent.name or campaign.path.name,
        "parameters": [{**row, **_places(row)} for row in data["parameters"]],
        "correlation": correlation_data(fit),
        "information": information_data(record_information(campaign, fit), fit, campaign),
        "resonances": resonance_data(resonances(fit.mechanism)),
        "driven": driven_data(campaign, fit),
        "meanings": meaning_data(campaign, fit),
        "record_table": _record_table(data),
        "origin": _origin(data["provenance"]),
    }
    # The verdict reads the correlation and the information, so it is added last.
    return {**more, "summary": summary_data(more)}


def _places(row: Mapping[str, Any]) -> dict[str, float | None]:
    """Return the positions of estimate and nominal value between the bounds in percent; None without bounds."""
    low, high = row["min"], row["max"]
    # An interval without both ends has no scale on which a position could be drawn.
    if low is None or high is None or not math.isfinite(high - low) or not high > low:
        return {"place": None, "nominal_place": None}
    share = {key: 100.0 * (row[source] - low) / (high - low) for key, source in PLACES.items()}
    return {key: min(max(round(value, 1), 0.0), 100.0) for key, value in share.items()}


PLACES = {"place": "estimate", "nominal_place": "nominal"}


def _record_table(data: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return a row for each channel of each record: its numbers as label and text."""
    plainly = has_only_torque(data["validation"])
    fits = {(row["name"], row["quantity"]): row for row in data["channels"]}
    fits = fits or {(row["name"], "torque"): row for row in data["records"]}
    return [_record_row(data, row, fits[row["name"], row["quantity"]], plainly) for row in data["validation"]]


def _record_row(
    data: Mapping[str, Any], row: Mapping[str, Any], fit: Mapping[str, Any], plainly: bool
) -> dict[str, Any]:
    residual = compare_with_noise(data, row)
    ratio = residual.ratio
    texts = row["text"]
    unit, rate = (", N m", ", N m/s") if plainly else ("", " a second")
    cells = [
        *([] if plainly else [("channel", texts["quantity"]), ("unit", texts["unit"])]),
        ("samples", str(row["samples"])),
        ("fit, %", texts["fit_percent"]),
        ("followed, %", fit["text"]["followed_percent"]),
        (f"residual{unit}", texts["residual_rms"]),
        (f"noise{unit}", fit["text"]["noise_known"]),
        ("residual / noise", f"{ratio:.2f}" if math.isfinite(ratio) else "-"),
        ("Ljung-Box p", texts["p_value"]),
        ("largest ρ", texts["largest"]),
        (f"offset{unit}", fit["text"]["offset"]),
        (f"drift{rate}", fit["text"]["drift"]),
    ]
    use = use_word(row["use"], left_out=row["left_out"])
    words = " ".join(filter(None, (level_words(residual, complete=data["grade"] == "A"), raised_words(fit))))
    own = {"noise_ratio": ratio, "words": words, "cells": cells}
    return {"name": row["name"], "use": use, "quantity": row["quantity"], **own}


def _origin(provenance: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return versions, seed and run time of the estimate as pairs of label and text."""
    versions = provenance.get("versions", {})
    lines = [
        ("versions", ", ".join(f"{name} {version}" for name, version in versions.items())),
        ("seed of the search", provenance.get("seed")),
        ("integration steps a sample", provenance.get("substeps")),
        ("wall time", f"{plain(provenance.get('wall_time_s'), 3)} s"),
        ("plant", provenance.get("plant")),
    ]
    return [(label, str(value)) for label, value in lines if value is not None]
