"""The report's tables as Markdown, to be pasted into a document."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mechid.diagnoses.effects_shown import own_table
from mechid.diagnoses.path import COMPLETED_TITLE, path_table
from mechid.ink.markdown_text import bullets, cell, synthetic_words, table
from mechid.ink.quantities import quantity_words
from mechid.reports.side import SIDE_SAID, SIDE_TITLE
from mechid.reports.tables import (
    known_table,
    order_table,
    parameter_table,
    record_table,
    side_table,
    stage_table,
)


def report_markdown(data: Mapping[str, Any]) -> str:
    """Return verdict and tables of what `report_contents` made."""
    summary = data["summary"]
    parts = [f"# {cell(data['title'])}", f"**{summary['headline']}**"]
    parts += synthetic_words(data)
    for each in summary["questions"]:
        parts += [f"## {each['question']}", bullets(each["answers"])]
    parts += ["## Parameters", parameter_table(data).markdown()]
    parts += ["## Known values", known_table(data).markdown()]
    parts += _completed(data["completed"])
    parts += [part for one in data["missing"] for part in _missing(one)]
    parts += ["## Records", record_table(data).markdown()]
    if data["orders"]:
        parts += ["## Orders of the step rate", order_table(data["orders"]).markdown()]
    if data["side"]:
        parts += [f"## {SIDE_TITLE}", SIDE_SAID, side_table(data["side"]).markdown()]
    parts += _channel_information(data["information"])
    parts += ["## Stages", stage_table(data["stages"]).markdown(), *filter(None, [cell(data["arrived"])])]
    for title, lines in (("Warnings", data["warnings"]), ("Notes", data["notes"])):
        if lines:
            parts += [f"## {title}", bullets(lines)]
    inputs = data["provenance"].get("inputs_sha256", {}).items()
    parts += ["## Provenance", table(("", ""), data["origin"]), table(("input", "SHA-256"), inputs)]
    return "\n\n".join(parts) + "\n"


def _missing(one: Mapping[str, Any]) -> list[str]:
    """Return what the files do not declare and the fit has: a heading, its values, what declares it."""
    text = one["text"]
    said = f"Not declared, and the records ask for it: chi-square {text['chi_square']} for {one['dof']}, "
    said += f"{text['share_percent']} % of what they hold beyond noise{cell(text['apart'])}. "
    said += f"To declare it, {text['where']}:"
    heading = f"## Not declared: {cell(one['words'])}"
    return [heading, own_table(one["rows"]).markdown(), said, f"```toml\n{one['toml']}```"]


def _completed(completed: Mapping[str, Any] | None) -> list[str]:
    """Return the steps by which the mechanism was completed: a heading, what they are, a table."""
    if completed is None:
        return []
    rows = [path_table(completed["rows"]).markdown()] if completed["rows"] else []
    return [f"## {COMPLETED_TITLE}", *map(cell, completed["said"]), *rows]


def _channel_information(information: Mapping[str, Any] | None) -> list[str]:
    """Return what each channel adds, where there are several."""
    if not information or len(information["channels"]) < 2:
        return []
    words = [quantity_words(quantity) for quantity in information["channels"]]
    tables = {
        "Share of a channel in what is known of a parameter, percent, all others held:": "channel_share_percent",
        "Factor on a standard error if a channel were not measured:": "without_channel",
    }
    parts = ["## What each channel adds"]
    for said, key in tables.items():
        rows = zip(information["parameters"], information["text"][key], strict=True)
        parts += [said, table(("parameter", *words), ([name, *cells] for name, cells in rows))]
    return parts
