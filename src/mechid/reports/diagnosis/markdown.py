"""A diagnosis as Markdown."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mechid.ink.markdown_text import bullets, cell, synthetic_words, table
from mechid.ink.sheet import FOLDER_NAME
from mechid.reports.diagnosis.verdict import ACTS, DOTTED, PATH_TITLE, SPECTRUM, STRETCH, next_lines, sentence
from mechid.reports.fit.path import MEANING
from mechid.reports.fit.tables import own_table, path_table


def diagnosis_markdown(data: Mapping[str, Any]) -> str:
    """Return the diagnosis as Markdown."""
    lines = ["# What the model is missing", ""]
    lines += [line for words in (*synthetic_words(data), data["unexplained"]["words"]) for line in (words, "")]
    for one in data["missing"]:
        lines += [f"## {one['name']}", "", f"{sentence(one)}", ""]
        lines += [own_table(one["rows"]).markdown(), ""]
        if one["places"]:
            places = [(place["record"], place["text"], place["kind"]) for place in one["places"]]
            lines += [table(("record", "acts most at, Hz", ""), places), ""]
        lines += ["```toml", one["toml"].rstrip(), "```", ""]
    if data["missing"]:
        lines += [bullets([*data["evidence"], *next_lines(data)]), ""]
    lines += _drawn_markdown(data)
    if data["path"]:
        lines += [f"## {PATH_TITLE}", "", path_table(data["path"]).markdown(), "", MEANING, ""]
    if data["tried"]:
        said = [f"{one['name']}: {one['words']}; {one['why']}" for one in data["tried"]]
        lines += ["## Tried and not named", "", bullets(said), ""]
    return "\n".join(lines)


def _drawn_markdown(data: Mapping[str, Any]) -> list[str]:
    """Return headings and figures, which lie in a folder beside the text."""
    lines, figures = list[str](), data["drawn"]
    if figures["spectra"]:
        lines += [
            "## What is left, over frequency",
            "",
            " ".join([SPECTRUM, *([DOTTED, ACTS] if data["missing"] else [])]),
            "",
        ]
    for one in figures["spectra"]:
        lines += [f"### {cell(one['record'])}", "", f"![Spectrum](<{FOLDER_NAME}/{one['figure']}.svg>)", ""]
    if figures["stretch"]:
        one = figures["stretch"]
        lines += [f"## Before and after: {cell(one['record'])}", "", STRETCH, ""]
        lines += [f"![Over time](<{FOLDER_NAME}/{one['figure']}.svg>)", ""]
    return lines
