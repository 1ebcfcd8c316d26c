"""All that a budget's report shows: its numbers, their texts, and the verdict, in one plain dict."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from mechid.report.budget.verdict import budget_verdict, drivers, standing_word
from mechid.report.digits import plain, with_sigma

Data = Mapping[str, Any]
NO_NUMBER = "–"


def budget_contents(data: Data) -> dict[str, Any]:
    """Return what `budget_data` made with verdict, texts and a key for each mode by which its figures are named."""
    modes = [{**mode, "key": mode_key(k, mode["name"]), "text": _mode_text(data, mode)} for k, mode in
             enumerate(data["modes"])]  # fmt: skip
    return {
        **data,
        "modes": modes,
        "requirements": [{**r, "text": _requirement_text(r)} for r in data["requirements"]],
        "verdict": budget_verdict(data),
    }


def mode_key(position: int, name: str) -> str:
    """Return a name that may be a file's and an element's.

    Examples
    --------
    >>> mode_key(1, "run up <1>")
    '1_run_up_1'
    """
    return f"{position}_" + re.sub(r"[^A-Za-z0-9-]+", "_", name).strip("_")


def _requirement_text(r: Data) -> dict[str, str]:
    level, sigma = with_sigma(r["level_rad"], r["sigma_rad"])
    low, high = (100.0 * m for m in r["margin95"])
    window = f" {plain(r['window_s'])} s" if r["window_s"] else ""
    return {
        "index": r["index"] + window + (f", {plain(r['separation_s'])} s apart" if r["separation_s"] else ""),
        "statistics": f"{r['interpretation']}, {100.0 * r['confidence']:.4g} %",
        "period": f"{plain(r['evaluation_period_s'])} s",
        "rate": NO_NUMBER if r["at_rate"] is None else plain(r["at_rate"], 4),
        "level": level,
        "sigma": sigma,
        "nominal": plain(r["nominal_rad"], 4),
        "others": plain(r["others_rad"], 3),
        "two_way": NO_NUMBER if r["two_way_rad"] is None else plain(r["two_way_rad"], 4),
        "ecss": plain(r["ecss_summation_rad"], 3),
        "limit": plain(r["limit_rad"], 3),
        "margin": f"{100.0 * r['margin']:.1f}",
        "margin95": f"{low:.1f} to {high:.1f}",
        "decided": f"{100.0 * r['decided']['margin']:.1f}",
        "coupling": r["decided"]["coupling"],
        "met": standing_word(r["decided"]),
        "shares": drivers(r["variance_shares"], shown=6),
        "spread": drivers(r["spread_shares"], shown=4),
    }


def _mode_text(data: Data, mode: Data) -> dict[str, str]:
    def per_axis(values: Any) -> str:
        if values is None:
            return NO_NUMBER
        return ", ".join(f"{a} {plain(v, 3)}" for a, v in zip(data["line_of_sight"], values, strict=True))

    rates = mode["rates"]
    stepping = f"{mode['stepping']}, {mode['microsteps']} a step" if mode["stepping"] == "micro" else mode["stepping"]
    driven = f"{plain(rates[0], 4)} to {plain(rates[-1], 4)} steps/s in {len(rates)}" if len(rates) > 1 else ""
    if mode["kind"] == "profile":
        driven = f"profile of {plain(mode['duration_s'], 4)} s, RMS in {plain(mode['rms_window_s'], 3)} s"
    return {
        "stepping": stepping,
        "driven": driven or f"{plain(rates[0], 4)} steps/s",
        "duty": NO_NUMBER if mode["duty"] is None else f"{100.0 * mode['duty']:.4g} %",
        "worst_rate": plain(mode["worst_rate"], 4),
        "torque": plain(mode["torque_rms_Nm"], 3),
        "one_way": per_axis(mode["line_of_sight_rms_rad"]),
        "two_way": per_axis(mode["line_of_sight_rms_two_way_rad"]),
        "gain": plain(mode["loop_gain"], 2),
    }
