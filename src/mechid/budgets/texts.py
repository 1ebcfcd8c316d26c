"""Formatted texts of a budget's numbers: table cells, and sentences that several sections share."""

from __future__ import annotations

import re
from typing import Any

from mechid.budgets.verdict import drivers, standing_word
from mechid.ink.data import Data
from mechid.ink.digits import plain, with_sigma
from mechid.ink.quantities import quantity_words

NO_NUMBER = "–"
SHOWN_STEADY = 16
REPEATS = ("does not", "each 2/rate", "each {} times 2/rate")


def add_texts(data: Data) -> dict[str, Any]:
    """Return the data of `budget_numbers` with the texts of requirements and modes."""
    modes = [
        {
            **mode,
            "key": mode_key(k, mode["name"]),
            "text": _mode_text(data, mode),
            "steady_rows": steady_rows(data, mode),
            "emission_rows": emission_rows(mode),
            "side_rows": side_rows(data, mode),
            "named_rows": named_rows(data, mode),
        }
        for k, mode in enumerate(data["modes"])
    ]
    return {
        **data,
        "modes": modes,
        "requirements": [{**r, "text": requirement_text(r)} for r in data["requirements"]],
    }


def mode_key(position: int, name: str) -> str:
    """Return the name of a mode for files and addresses.

    Examples
    --------
    >>> mode_key(1, "run up <1>")
    '1_run_up_1'
    """
    return f"{position}_" + re.sub(r"[^A-Za-z0-9-]+", "_", name).strip("_")


def requirement_text(r: Data) -> dict[str, str]:
    """Return the texts of a requirement's row; `deciding` is the one in bold."""
    decided = r["decided"]
    level, sigma = with_sigma(decided["level_rad"], decided["sigma_rad"])
    worst = r["worst_member_share"]
    window = f" {plain(r['window_s'])} s" if r["window_s"] else ""
    return {
        "index": r["index"] + window + (f", {plain(r['separation_s'])} s apart" if r["separation_s"] else ""),
        "statistics": f"{r['interpretation']}, {100.0 * r['confidence']:.4g} %",
        "period": f"{plain(r['evaluation_period_s'])} s",
        "rate": NO_NUMBER if decided["at_rate"] is None else plain(decided["at_rate"], 4),
        "level": level,
        "sigma": sigma,
        "sampling": plain(decided["sampling_sigma_rad"], 2) if decided["sampling_sigma_rad"] else NO_NUMBER,
        "one_way": plain(r["level_rad"], 4),
        "nominal": plain(r["nominal_rad"], 4),
        "others": plain(r["others_rad"], 3),
        "lacking": _residual_text(r),
        "two_way": NO_NUMBER if r["two_way_rad"] is None else plain(r["two_way_rad"], 4),
        "ecss": plain(r["ecss_summation_rad"], 3),
        "limit": plain(r["limit_rad"], 3),
        "one_way_margin": _margin(r),
        "two_way_margin": NO_NUMBER if r["two_way"] is None else _margin(r["two_way"]),
        "deciding": f"{100.0 * decided['margin95'][0]:.1f}",
        "coupling": decided["coupling"],
        "met": standing_word(decided),
        "shares": drivers(r["variance_shares"], shown=6),
        "spread": drivers(r["spread_shares"], shown=4),
        "worst_member": f"{100.0 * worst:.5g} % are no worse; " if worst and any(r["spread_shares"].values()) else "",
    }


def _residual_text(r: Data) -> str:
    """Return the increase of the level due to unmodelled torque, and its share of the limit."""
    lacking = r["decided"]["residual_rad"]
    return f"{plain(lacking, 2)} ({100.0 * lacking / r['limit_rad']:.2g} %)" if lacking else NO_NUMBER


def _margin(r: Data) -> str:
    """Return a margin and its 95 % interval, in percent."""
    low, high = (100.0 * m for m in r["margin95"])
    return f"{100.0 * r['margin']:.1f} ({low:.1f} to {high:.1f})"


def _mode_text(data: Data, mode: Data) -> dict[str, str]:
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
        "one_way": _per_axis(data, mode["line_of_sight_rms_rad"]),
        "two_way": _per_axis(data, mode["line_of_sight_rms_two_way_rad"]),
        "lacking": _per_axis(data, _residual_rms(mode)),
        "gain": plain(mode["loop_gain"], 2),
        "slowest": _slowest(mode),
    }


def _residual_rms(mode: Data) -> Any:
    """Return the RMS along each line of sight due to unmodelled torque; None if unknown."""
    rms = mode["line_of_sight_rms_lacking_rad"] if mode["kind"] == "steady" else None
    return rms if rms and any(rms) else None


def emission_rows(mode: Data) -> list[dict[str, str]]:
    """Return a row of texts for each third octave of the torque."""
    bands = mode["emission"]["bands"] if mode["kind"] == "steady" else []
    return [
        {
            "hz": f"{plain(b['from_hz'], 3)} to {plain(b['to_hz'], 3)}",
            "rate": plain(b["at_rate"], 4),
            "modelled": plain(b["modelled_rms_Nm"], 3),
            "residual": plain(b["residual_rms_Nm"], 3) if b["residual_rms_Nm"] else NO_NUMBER,
            "bound": plain(b["bound_rms_Nm"], 3),
        }
        for b in bands
    ]


def named_rows(data: Data, mode: Data) -> list[dict[str, str]]:
    """Return a row of texts for each line at an order that the mechanism names."""
    return [
        {
            "name": one["name"],
            "words": one["words"],
            "order": plain(one["order"], 6),
            "hz": plain(one["frequency_hz"], 6),
            "torque": plain(one["torque_Nm"], 3),
            "residual": plain(one["residual_Nm"], 3) if one["residual_Nm"] else NO_NUMBER,
            "bound": plain(one["bound_Nm"], 3),
            "rms": _per_axis(data, one["line_of_sight_rad"]),
        }
        for one in mode.get("named_lines", ())
    ]


def side_rows(data: Data, mode: Data) -> list[dict[str, str]]:
    """Return a row of texts for the torque, for each other component, and for all together."""
    side = mode.get("side")
    if side is None:
        return []
    rows = [_side_row(data, "torque", NO_NUMBER, NO_NUMBER, side["drive_rms_rad"])]
    rows += [
        _side_row(
            data, quantity_words(c["name"]), str(c["coherent"]), str(c["by_magnitude"]), c["line_of_sight_rms_rad"]
        )
        for c in side["components"]
    ]
    rows.append(_side_row(data, "together, on the torque's lines", "", "", side["together_rms_rad"]))
    if any(side["alone_rms_rad"]):
        rows.append(_side_row(data, "where the model has no line, on top", "", "", side["alone_rms_rad"]))
    return rows


def _side_row(data: Data, name: str, coherent: str, magnitude: str, rms: Any) -> dict[str, str]:
    return {"name": name, "coherent": coherent, "magnitude": magnitude, "rms": _per_axis(data, rms)}


def side_words(data: Data) -> str:
    """Return a sentence on the transfer of the bench's six components to the structure; empty without any."""
    side = data.get("side")
    if side is None:
        return ""
    point = ", ".join(plain(value, 4) for value in side["mounting_point_m"])
    axes = (f"{name} [{', '.join(plain(row[k], 4) for row in side['frame'])}]" for k, name in enumerate("xyz"))
    said = (
        f"measured with the torque about {side['drive_axis']} of the bench, moved to the mounting point at [{point}] m"
        f", the bench's axes in the structure's frame {', '.join(axes)}"
    )
    left = ", ".join(quantity_words(name) for name in side["left_out"])
    flying = ", ".join(quantity_words(name) for name in side["flying"]) or "nothing"
    return f"{flying}: {said}" + (f"; without a direction of the structure, not counted: {left}" if left else "")


def _slowest(mode: Data) -> str:
    """Return the slowest transient in words; empty for a profile, or if no motion repeats."""
    slowest = mode["steady_states"]["slowest"] if mode["kind"] == "steady" else None
    if slowest is None or slowest["decay_s"] is None:
        return NO_NUMBER
    return f"{plain(slowest['decay_s'], 2)} s at {plain(slowest['rate'], 4)} steps/s"


def steady_rows(data: Data, mode: Data) -> list[dict[str, str]]:
    """Return a row of texts for each steady state at rates with several, or with an unusual one."""
    several = mode["steady_states"]["several"] if mode["kind"] == "steady" else []
    rows = [
        {
            "rate": plain(here["rate"], 5),
            "reached": ", ".join(s["reached"]),
            "repeats": REPEATS[min(s["periods"], 2)].format(s["periods"]),
            "multiplier": plain(s["largest_multiplier"], 3) if s["periods"] else NO_NUMBER,
            "decay": plain(s["decay_s"], 2) if s["periods"] else NO_NUMBER,
            "follows": "yes" if s["follows"] else "no",
            "torque": plain(s["torque_rms_Nm"], 3),
            "rms": _per_axis(data, s["rms_rad"]),
            "counts": "counts" if s["worst"] else "",
        }
        for here in several
        for s in here["states"]
    ]
    if len(rows) <= SHOWN_STEADY:
        return rows
    more = dict.fromkeys(rows[0], "") | {"rate": f"{len(rows) - SHOWN_STEADY} more", "reached": "in steady_states.csv"}
    return [*rows[:SHOWN_STEADY], more]


def _per_axis(data: Data, values: Any) -> str:
    if values is None:
        return NO_NUMBER
    return ", ".join(f"{a} {plain(v, 3)}" for a, v in zip(data["line_of_sight"], values, strict=True))
