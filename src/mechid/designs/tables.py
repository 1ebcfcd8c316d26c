"""Tables of a design."""

from __future__ import annotations

import math

from mechid.ink.data import Data
from mechid.ink.digits import plain
from mechid.ink.table import Table
from mechid.ink.text_table import Column, OnPage

RECORDS = (
    Column("chosen record", "name", words=True),
    Column("s", "seconds"),
    Column("peak N m", "peak"),
    Column("sigma falls by", "gain"),
    Column("voltage margin %", "voltage"),
    Column("torque margin N m", "torque"),
)
LOSSES = (
    Column("stepping", "stepping", words=True),
    Column("changed", "changed", words=True),
    Column("pull-in steps/s", "pull_in"),
    Column("pull-out steps/s", "pull_out"),
)
SHOWN_RANGES = 3


def parameter_table(data: Data) -> Table:
    """Return standard errors before and after; after a fit, "before" is the present knowledge."""
    return Table(_columns(data), _parameter_rows(data))


def record_table(data: Data) -> Table:
    """Return the chosen records, the most informative first."""
    return Table(RECORDS, _record_rows(data))


def loss_table(data: Data) -> Table:
    """Return the rates at which each stepping holds."""
    return Table(LOSSES, _loss_rows(data))


def _columns(data: Data) -> tuple[Column, ...]:
    """Return the columns of the parameter table; after a fit, "before" is the present knowledge."""
    before, many = ("now", "of its draws") if data["after_fit"] else ("planned", "over the prior")
    return (
        Column("parameter", "name", words=True),
        Column("value", "value"),
        Column("unit", "unit", words=True),
        Column(f"sigma {before}", "planned", said=f"σ {before}"),
        Column("chosen", "chosen", said="σ chosen"),
        Column("better by", "gain"),
        Column(f"{many}: {before}", "planned_spread"),
        Column("chosen", "chosen_spread", said=f"{many}: chosen", on_page=OnPage(header="chosen")),
    )


def _parameter_rows(data: Data) -> list[dict[str, str]]:
    return [
        {
            "name": p["name"],
            "value": plain(p["value"]),
            "unit": p["unit"],
            "planned": _sigma(p["planned"], p["planned_reason"]),
            "chosen": _sigma(p["chosen"], p["chosen_reason"]),
            "gain": plain(p["planned"] / p["chosen"], 2) if p["planned"] and p["chosen"] else "-",
            "planned_spread": plain(p["planned_spread"][0], 2),
            "chosen_spread": plain(p["chosen_spread"][0], 2),
        }
        for p in data["parameters"]
    ]


def _sigma(sigma: float | None, reason: str) -> str:
    return reason or plain(sigma, 2)


def _record_rows(data: Data) -> list[dict[str, str]]:
    peaks = {c["name"]: c["peak_torque_Nm"] for c in data["candidates"]}
    steps = zip(data["trail"][:-1], data["trail"][1:], strict=True)
    return [
        _record_row(
            r["name"], r["duration_s"], peaks.get(r["name"]), before - after, data["margins"].get(r["name"], {})
        )
        for r, (before, after) in zip(data["chosen"]["records"], steps, strict=True)
    ]


def _record_row(name: str, seconds: float, peak: float | None, gain: float, margin: Data) -> dict[str, str]:
    voltage = margin.get("voltage")
    return {
        "name": name,
        "seconds": f"{seconds:g}",
        "peak": plain(peak, 2),
        "gain": f"{-100.0 * math.expm1(-gain):.1f} %",
        "voltage": "-" if voltage is None else f"{100.0 * voltage:.0f}",
        "torque": plain(margin.get("torque_Nm"), 2),
    }


def _loss_rows(data: Data) -> list[dict[str, str]]:
    return [
        {
            "stepping": row["stepping"],
            "changed": _change_text(row),
            "pull_in": limit_words(row["pull_in"]),
            "pull_out": limit_words(row["pull_out"]),
        }
        for row in data["step_loss"]
    ]


def _change_text(row: Data) -> str:
    if not row["changed"]:
        return "as believed"
    if row["changed"] == "friction torque":
        return f"{plain(row['to'], 2)} N m more friction"
    return f"{row['changed']} x {row['to']:g}"


def limit_words(limit: Data) -> str:
    """Return the ranges in which a stepping holds: "354", or "118, 147 to 1107" with a hole between."""
    low, high = limit["searched"]
    least = None if limit["brought_from"] else low
    ranges = [_range(first, last, least, high) for first, last in limit["ranges"]]
    if len(ranges) > SHOWN_RANGES:
        ranges[1:-1] = [f"{len(ranges) - 2} more"]
    return ", ".join(ranges) or "none"


def _range(first: float, last: float, least: float | None, highest: float) -> str:
    end = f"{last:.0f}" if last < highest else f"> {last:.0f}"
    return end if first == least else f"{first:.0f} to {end}"
