"""Verdicts as plain numbers and words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from mechid.ink.digits import digits, plain
from mechid.specification.requirement import Requirement
from mechid.specification.verdict import Worst

VERDICT_WORDS: Mapping[str, str] = {
    "pass": "pass",
    "fail": "fail",
    "not_shown": "pass not shown",
    "not_decidable": "not decidable",
}
VERDICT_MEANING = (
    "Pass: the upper bound of every value is below its limit. Fail: a lower bound is above it. Pass not shown: the "
    "limit lies between the bounds. Not decidable: so it does, and the background itself is above the limit."
)


def requirement_numbers(requirement: Requirement) -> dict[str, Any]:
    """Return a requirement as it is declared, limits in its SI unit."""
    mask = requirement.mask
    return {
        "name": requirement.name,
        "direction": requirement.direction,
        "kind": requirement.kind,
        "unit": requirement.unit,
        "confidence": requirement.confidence,
        "margin_dB_required": requirement.margin_db,
        "exclude_mains": requirement.exclude_mains,
        "mask": [list(point) for point in zip(mask.frequencies_hz.tolist(), mask.limits.tolist(), strict=True)],
        "interpolation": "step" if mask.is_stepwise else "log-log",
    }


def worst_numbers(worst: Worst | None) -> dict[str, Any] | None:
    """Return the value that decides a verdict; None where there is none."""
    if worst is None:
        return None
    return {
        "record": worst.record,
        "rate": finite(worst.rate),
        "frequency_Hz": worst.frequency_hz,
        "value": worst.value,
        "sigma": worst.sigma,
        "limit": worst.limit,
        "lower": worst.lower,
        "upper": worst.upper,
        "background": worst.background,
        "margin_dB": finite(worst.margin_db),
    }


def worst_texts(worst: Worst | None) -> dict[str, str]:
    """Return the value that decides a verdict in words; empty texts where there is none."""
    if worst is None:
        return dict.fromkeys(("rate", "frequency", "value", "bounds", "limit", "margin", "background"), "")
    return {
        "rate": plain(finite(worst.rate), 5) if math.isfinite(worst.rate) else "",
        "frequency": plain(worst.frequency_hz, 5),
        "value": digits(worst.value, 3),
        "bounds": f"{digits(worst.lower, 3)} to {digits(worst.upper, 3)}",
        "limit": digits(worst.limit, 3),
        "margin": f"{worst.margin_db:+.1f}" if math.isfinite(worst.margin_db) else "",
        "background": digits(worst.background, 2),
    }


def finite(value: float) -> float | None:
    """Return a number as JSON can hold it: None where it is not finite."""
    return float(value) if math.isfinite(value) else None
