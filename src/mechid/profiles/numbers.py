"""Numbers of profiles in one dict, and their files."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from mechid.identification.refit.profile import Point, Profile
from mechid.identification.result.estimate_file import json_text, provenance_of_fits
from mechid.ink.digits import like, with_sigma

FORMAT = "mechid-profile/1"
FILE_NAME, POINTS_NAME = "profile.json", "profile.csv"
# 97.5 % quantile of the normal distribution: both tails together hold 5 %.
LOCAL = 1.959964
REPORTED_DROP = 0.1
"""Decrease of the cost by a refit, in squared sigmas, above which a warning is given."""


def profile_numbers(profiles: Sequence[Profile], *, synthetic: bool = False, fit_digest: str = "") -> dict[str, Any]:
    """Return the numbers shown for profiles, with formatted texts."""
    return {
        "format": FORMAT,
        "synthetic": synthetic,
        "profiles": {p.name: _profile(p) for p in profiles},
        "warnings": [line for p in profiles for line in _warnings(p)],
        "provenance": provenance_of_fits(fit_digest),
    }


def profile_texts(data: Mapping[str, Any]) -> dict[str, str]:
    """Return profile.json, and profile.csv with one line per point."""
    rows = ["parameter,unit,value,cost_rise_sigma2,note"]
    for name, p in data["profiles"].items():
        # `repr` is the shortest text that reads back as the same double.
        rows += [f"{name},{p['unit']},{q['value']!r},{q['rise']!r},{q['note']}" for q in p["points"]]
    return {FILE_NAME: json_text(data), POINTS_NAME: "\n".join(rows) + "\n"}


def _profile(p: Profile) -> dict[str, Any]:
    local = (p.value - LOCAL * p.std_error, p.value + LOCAL * p.std_error) if p.std_error else (None, None)
    limits = {"local": local, "profile": p.interval, "coloured": p.interval_coloured}
    texts = {
        f"{key}_{side}": _text(p, x)
        for key, pair in limits.items()
        for side, x in zip(("low", "high"), pair, strict=True)
    }
    return {
        "unit": p.unit,
        "value": p.value,
        "std_error": p.std_error,
        "std_error_white": p.std_error_white,
        "ci95_local": list(local),
        "level": p.level,
        "ci95": list(p.interval),
        "level_coloured": p.level_coloured,
        "ci95_coloured": list(p.interval_coloured),
        "ends": [{"code": end.name.lower(), "message": end.value} for end in p.ends],
        "cliffs": [{"between": [c.below, c.above], "jump": c.jump} for c in p.cliffs],
        "points": [_point(point) for point in p.points],
        "text": {
            **texts,
            "low": texts["profile_low"],
            "high": texts["profile_high"],
            "estimate": with_sigma(p.value, p.std_error)[0],
            "unit": "" if p.unit == "1" else p.unit,
        },
    }


def _point(point: Point) -> dict[str, Any]:
    return {"value": point.value, "rise": point.rise, "note": point.note}


def _text(p: Profile, value: float | None) -> str:
    return "" if value is None else like(value, p.std_error)


def _warnings(p: Profile) -> list[str]:
    """Describe deviations of a profile from a smooth rise."""
    lines = [
        f"{p.name}: at {0.5 * (c.below + c.above):.9g} {p.unit} the cost jumps by {abs(c.jump):.3g}: a stick/slip "
        "falls the other way there"
        for c in p.cliffs
    ]
    sides = zip(("below", "above"), p.interval, p.ends, strict=True)
    lines += [
        f"{p.name}: no end of the interval {side} the estimate: {end.value}" for side, x, end in sides if x is None
    ]
    if p.gain > REPORTED_DROP:
        best = min(p.points, key=lambda point: point.rise)
        lines.append(
            f"{p.name}: a refit at {best.value:.9g} {p.unit} costs less by {p.gain:.3g}; identify again from there"
        )
    unsettled = sum(bool(point.note) for point in p.points if math.isfinite(point.rise))
    if unsettled:
        lines.append(f"{p.name}: {unsettled} of {len(p.points)} refits stopped at a threshold or before they converged")
    return lines
