"""The budget's verdict and tables as Markdown, to be pasted into a document."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mechid.ink.markdown_text import bullets, cell, synthetic_words
from mechid.reports.budget.tables import (
    crossing_table,
    emission_table,
    mode_table,
    requirement_table,
    side_table,
    steady_table,
)
from mechid.reports.side import SIDE_TITLE


def budget_markdown(data: Mapping[str, Any]) -> str:
    """Return verdict and tables of what `budget_contents` made."""
    verdict = data["verdict"]
    parts = [f"# Microvibration budget of {cell(data['file'])}", *synthetic_words(data), f"**{verdict['headline']}**"]
    for each in verdict["questions"]:
        parts += [f"## {each['question']}", bullets(each["answers"])]
    if data["requirements"]:
        parts += ["## Requirements", requirement_table(data).markdown()]
    parts += ["## Modes of operation", mode_table(data).markdown()]
    for title, words, table in (
        ("Rates with several steady states, or an odd one", [], steady_table(*data["modes"])),
        ("Torque on the base", [], emission_table(*data["modes"])),
        (SIDE_TITLE, [cell(data["side_words"])], side_table(*data["modes"])),
        ("Crossings", [], crossing_table(data)),
    ):
        parts += [f"## {title}", *words, table.markdown()] if table.rows else []
    if data["warnings"]:
        parts += ["## Warnings", bullets(data["warnings"])]
    return "\n\n".join(parts) + "\n"
