"""Formatted texts of a fleet's numbers for its tables."""

from __future__ import annotations

import math
from typing import Any

from mechid.ink.data import Data
from mechid.ink.digits import digits, plain, with_sigma

NO_NUMBER = "–"
ABSENT = "no such"


def fleet_texts(data: Data) -> dict[str, Any]:
    """Return the data of `fleet_data` with texts in each row, and parameters split into table and key."""
    return {
        **data,
        "campaigns": [{**c, "text": _campaign(data, c)} for c in data["campaigns"]],
        "parameters": [_parameter(data, p) for p in data["parameters"]],
        "trends": [{**t, "text": _trend(data, t)} for t in _sort_by_p(data["trends"])],
        "groups": [{**g, "text": _group(data, g)} for g in _sort_by_p(data["groups"])],
        "changes": [{**c, "text": _change(data, c)} for c in _sort_by_p(data["changes"])],
        "mean_changes": [{**c, "text": _mean_change(data, c)} for c in _sort_by_p(data["mean_changes"])],
    }


def unit_of(data: Data, name: str) -> str:
    """Return the unit of a parameter, empty for a plain number."""
    unit = next(p["unit"] for p in data["parameters"] if p["name"] == name)
    return "" if unit == "1" else str(unit)


def covariate_words(one: Data) -> str:
    """Return the name of a covariate; for dates with the origin of the days."""
    return f"{one['covariate']}, days from {one['first_day']}" if one["first_day"] else str(one["covariate"])


def _sort_by_p(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return tests sorted by p-value."""
    return sorted(rows, key=lambda row: row["p_value"])


def chance(p: float | None) -> str:
    """Return a probability as text.

    Examples
    --------
    >>> chance(0.031234), chance(1e-12), chance(None)
    ('0.031', '< 1e-06', '–')
    """
    if p is None or not math.isfinite(p):
        return NO_NUMBER
    return "< 1e-06" if p < 1e-6 else plain(p, 2)


def _campaign(data: Data, c: Data) -> dict[str, str]:
    given = {n: v if isinstance(v, str) else plain(v) for n, v in c["covariates"].items()}
    return {
        "grade": c["grade"] or "none",
        "seconds": f"{c['wall_time_s']:.1f}",
        "how": f"{c['how_words']} ({c['said']})" if c["said"] and c["grade"] else c["how_words"],
        "reason": c["reason"],
        **{f"covariate_{k}": given.get(n, NO_NUMBER) for k, n in enumerate(data["covariates"])},
    }


def _parameter(data: Data, p: Data) -> dict[str, Any]:
    table, _, key = p["name"].rpartition(".")
    mean, error = with_sigma(p["mean"], p["std_error"]) if p["mean"] is not None else (NO_NUMBER, "")
    text = {
        "unit": "" if p["unit"] == "1" else p["unit"],
        "mean": mean,
        "std_error": error,
        "units": str(p["units"]),
        "spread": _spread(p),
        "spread95": _range(p["spread95"], 2),
        "next95": _prediction_range(p),
        "repeatability": NO_NUMBER if p["repeatability"] is None else plain(p["repeatability"], 2),
        "differs": "differs" if p["differs"] else "",
        "q": chance(p["equal_q"]),
        "outliers": ", ".join(one["unit"] for one in p["outliers"]),
        "along": ""
        if p["along"] is None
        else f"at {plain(p['along']['reference'], 4)} ({covariate_words(p['along'])})",
        "lacking": f"{len(p['lacking'])} of {len(data['campaigns'])} have no such" if p["lacking"] else "",
    }
    stands_off = {one["unit"] for one in p["outliers"]}
    cells = [_cell(v, c["unit"] in stands_off) for v, c in zip(p["values"], data["campaigns"], strict=True)]
    name = f"{p['name']}, {text['unit']}" if text["unit"] else p["name"]
    by_unit = {
        "name": name,
        **{f"cell_{k}": _value_with_error(c["text"], c["error"], c["said"]) for k, c in enumerate(cells)},
    }
    return {**p, "table": table, "key": key, "text": text, "by_unit": {"text": by_unit, "cells": cells}}


def _spread(p: Data) -> str:
    """Return the spread, with its share of the mean except for angles."""
    if p["spread"] is None:
        return NO_NUMBER
    if p["unit"] == "deg" or not p["mean"]:
        return plain(p["spread"], 2)
    return f"{plain(p['spread'], 2)} ({digits(100.0 * p['spread'] / abs(p['mean']), 2)} %)"


def _range(ends: Any, count: int) -> str:
    return NO_NUMBER if ends is None else f"{plain(ends[0], count)} to {plain(ends[1], count)}"


def _prediction_range(p: Data) -> str:
    """Return the range of a further unit, rounded to the first decimal of half its width."""
    if p["next95"] is None:
        return NO_NUMBER
    low, high = p["next95"]
    return " to ".join(with_sigma(end, (high - low) / 2.0)[0] for end in (low, high))


def _cell(v: Data | None, stands_off: bool) -> dict[str, Any]:
    """Return the texts of a value and its error, and its mark."""
    if v is None:
        return {"text": "", "error": "", "said": "", "mark": "absent", "why": ABSENT, "off": 0.0}
    value, error = with_sigma(v["value"], v["std_error"])
    mark = "left-out" if v["left_out"] else "off" if stands_off else "near" if v["near_threshold"] else ""
    why = v["left_out"] or ("stands off" if stands_off else "near threshold" if v["near_threshold"] else "")
    return {"text": value, "error": error, "said": v["left_out"], "mark": mark, "why": why, "off": v["off"] or 0.0}


def _value_with_error(value: str, error: str, more: str = "") -> str:
    """Return a value with its error and a suffix: a unit, or why it is not counted; empty parts are left out.

    Examples
    --------
    >>> _value_with_error("2.70", "0.12", "N m"), _value_with_error("2.70", "")
    ('2.70 ± 0.12 N m', '2.70')
    """
    return " ".join(filter(None, (value, f"± {error}" if error else "", more)))


def _trend(data: Data, t: Data) -> dict[str, str]:
    of = "day" if t["first_day"] else t["covariate"]
    unit = f"{unit_of(data, t['name'])} / {of}".strip()
    how = "within units" if t["within"] else "over units"
    return {
        "covariate": covariate_words(t),
        "slope": _value_with_error(*with_sigma(t["slope"], t["error"]), unit),
        "range": _range(t["slope95"], 3),
        "of": f"{how}, {t['campaigns']} campaigns" if t["within"] else f"{how}, {t['units']}",
        "q": chance(t["q"]),
    }


def _group(data: Data, g: Data) -> dict[str, str]:
    means = [(m, _value_with_error(*with_sigma(m["mean"], m["error"]))) for m in g["means"]]
    return {
        "means": "; ".join(f"{m['group']} {mean} ({m['units']})" for m, mean in means),
        "unit": unit_of(data, g["name"]),
        "q": chance(g["q"]),
    }


def _change(data: Data, c: Data) -> dict[str, str]:
    return {
        "states": " to ".join(c["states"]),
        "difference": _value_with_error(*with_sigma(c["difference"], c["error"]), unit_of(data, c["name"])),
        "sigmas": f"{c['difference'] / c['error']:+.1f}",
        "q": chance(c["q"]),
    }


def _mean_change(data: Data, c: Data) -> dict[str, str]:
    return {
        "states": " to ".join(c["states"]),
        "mean": _value_with_error(*with_sigma(c["mean"], c["error"]), unit_of(data, c["name"])),
        "range": _range(c["mean95"], 3),
        "spread": plain(c["spread"], 2),
        "q": chance(c["q"]),
    }
