"""The budget's verdict and tables as Markdown, to be pasted into a document."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mechid.reports.fit.side import SIDE_TITLE
from mechid.reports.markdown_text import Strong, bullets, cell, table

REQUIREMENT = (
    "requirement", "mode", "index", "axis", "statistics", "at, steps/s", "level, rad", "± σ", "of it by draws",
    "of it lacking in the model (of the limit)", "two-way", "ECSS sum", "limit, rad", "one-way margin, %",
    "two-way margin, %", "decides, %", "of", "",
)  # fmt: skip
SHOWN = (
    "statistics",
    "rate",
    "level",
    "sigma",
    "sampling",
    "lacking",
    "two_way",
    "ecss",
    "limit",
    "one_way_margin",
    "two_way_margin",
    "deciding",
    "coupling",
    "met",
)
MODE = (
    "mode",
    "stepping",
    "driven",
    "duty",
    "worst rate, steps/s",
    "torque RMS, N m",
    "line of sight RMS, rad",
    "lacking in the model",
    "two-way",
    "largest R K",
    "slowest transient, to 1/e",
)


def budget_markdown(data: Mapping[str, Any]) -> str:
    """Return verdict and tables of what `budget_contents` made."""
    verdict = data["verdict"]
    parts = [f"# Microvibration budget of {cell(data['file'])}", f"**{verdict['headline']}**"]
    for each in verdict["questions"]:
        parts += [f"## {each['question']}", bullets(each["answers"])]
    if data["requirements"]:
        rows = [
            (
                r["requirement"],
                r["mode"],
                r["text"]["index"],
                r["axis"],
                *(Strong(t) if key == "deciding" else t for key, t in zip(SHOWN, _texts(r, SHOWN), strict=True)),
            )
            for r in data["requirements"]
        ]
        parts += ["## Requirements", table(REQUIREMENT, rows)]
    keys = ("stepping", "driven", "duty", "worst_rate", "torque", "one_way", "lacking", "two_way", "gain", "slowest")
    parts += ["## Modes of operation", table(MODE, [(m["name"], *_texts(m, keys)) for m in data["modes"]])]
    steady = [(m["name"], *row) for m in data["modes"] for row in m["steady_rows"]]
    if steady:
        parts += [
            "## Rates with several steady states, or an odd one",
            table(("mode", *data["steady_columns"]), steady),
        ]
    exerted = [(m["name"], *row) for m in data["modes"] for row in m["emission_rows"]]
    if exerted:
        parts += ["## Torque on the base", table(("mode", *data["emission_columns"]), exerted)]
    beside = [(m["name"], *row) for m in data["modes"] for row in m["side_rows"]]
    if beside:
        parts += [f"## {SIDE_TITLE}", cell(data["side_words"]), table(("mode", *data["side_columns"]), beside)]
    if data["crossings"]:
        crossed = [
            (f"{c['rate']:.4g}", f"{c['order']:g}", c["mode"], f"{c['frequency_hz']:.4g}") for c in data["crossings"]
        ]
        parts += ["## Crossings", table(("rate, steps/s", "order", "mode", "frequency, Hz"), crossed)]
    if data["warnings"]:
        parts += ["## Warnings", bullets(data["warnings"])]
    return "\n\n".join(parts) + "\n"


def _texts(row: Mapping[str, Any], keys: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(row["text"][key] for key in keys)
