"""A diagnosis: every number in one dict, its files, and its ink for a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console

from mechid.campaign.mechanism_text import mechanism_text
from mechid.identification.diagnosis.diagnosis import Diagnosis
from mechid.identification.result.diagnosis_file import FILE_NAME as DATA_NAME
from mechid.identification.result.diagnosis_file import FORMAT, PROPOSED_NAME
from mechid.identification.result.estimate_file import json_text
from mechid.report.lacking import missing_data
from mechid.report.markdown import bullets, table
from mechid.report.page import asset, environment
from mechid.report.terminal import print_lines, say
from mechid.report.text_table import Column, print_tables
from mechid.writing import write_together

PAGE_NAME, MARKDOWN_NAME = "diagnose.html", "diagnose.md"
PROPOSED = (
    "Proposed by mechid diagnose: the mechanism file with the effects that the records ask for, at the values found\n"
    "together with them. Nothing of it is sure before it was identified anew and makes sense for this mechanism."
)
NEXT = (
    "Where an effect makes sense for your mechanism, take it from mechanism_proposed.toml into the mechanism file and "
    "identify again; hold a record back, and see whether that is predicted better (mechid compare)."
)
CANNOT_TELL = "these records cannot tell it from {0}"
COLUMNS = (
    Column("effect", "name", words=True),
    Column("chi-square", "chi_square"),
    Column("explains %", "share_percent"),
    Column("records", "records", words=True),
    Column("or else", "aliases", words=True),
)
VALUES = (
    Column("parameter", "name", words=True),
    Column("value", "value"),
    Column("+-", "std_error"),
    Column("unit", "unit", words=True),
)


def diagnosis_data(found: Diagnosis) -> dict[str, Any]:
    """Return all that a diagnosis shows: numbers, and beside those that need rounding their text."""
    return {
        "format": FORMAT,
        "missing": [_entry(missing_data(one)) for one in found.missing],
        "unexplained": {"share": found.unexplained, "words": found.words},
        "over_noise": {"as_written": found.over_noise[0], "with_effects": found.over_noise[1]},
        "tried": [asdict(one) for one in found.tried],
        "steps": [asdict(one) for one in found.steps],
    }


def _entry(data: dict[str, Any]) -> dict[str, Any]:
    texts = {"records": ", ".join(data["records"]), "aliases": ", ".join(data["aliases"])}
    return {**data, "text": {**data["text"], **texts, "name": data["name"]}}


def write_diagnosis(found: Diagnosis, data: Mapping[str, Any], folder: Path | str) -> list[Path]:
    """Write diagnose.json, its page and Markdown, and the proposed mechanism where there is one.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    texts = {DATA_NAME: json_text(_plain(data)), MARKDOWN_NAME: diagnosis_markdown(data), PAGE_NAME: _page(data)}
    if found.mechanism is not None:
        texts[PROPOSED_NAME] = mechanism_text(found.mechanism, PROPOSED)
    return write_together(folder, texts)


def _plain(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers alone."""
    missing = [{k: v for k, v in one.items() if k not in ("rows", "text")} for one in data["missing"]]
    return {**data, "missing": missing}


def diagnosis_markdown(data: Mapping[str, Any]) -> str:
    """Return the diagnosis as Markdown."""
    lines = ["# What the model is missing", "", data["unexplained"]["words"], ""]
    for one in data["missing"]:
        lines += [f"## {one['name']}", "", f"{_sentence(one)}", ""]
        rows = [(r["name"], r["text"]["value"], r["text"]["std_error"], r["text"]["unit"]) for r in one["rows"]]
        lines += [table(("parameter", "value", "+-", "unit"), rows), "", "```toml", one["toml"].rstrip(), "```", ""]
    if data["missing"]:
        lines += [NEXT, ""]
    if data["tried"]:
        said = [f"{one['name']}: {one['words']}; {one['why']}" for one in data["tried"]]
        lines += ["## Tried and not named", "", bullets(said), ""]
    return "\n".join(lines)


def _sentence(one: Mapping[str, Any]) -> str:
    text = one["text"]
    alike = f"; {CANNOT_TELL.format(text['aliases'])}" if one["aliases"] else ""
    words = one["words"][:1].upper() + one["words"][1:]
    return (
        f"{words}: it explains {text['share_percent']} % of the misfit (chi-square "
        f"{text['chi_square']} for {one['dof']}), in the records {text['records']}{alike}."
    )


def _page(data: Mapping[str, Any]) -> str:
    sentences = {one["name"]: _sentence(one) for one in data["missing"]}
    template = environment().get_template("diagnose.html")
    return template.render(data=data, sentences=sentences, next=NEXT, style=asset("report.css"))


def print_diagnosis(data: Mapping[str, Any], console: Console, files: Sequence[Path] = ()) -> None:
    """Print what `diagnosis_data` made, and where the files are."""
    say(console, data["unexplained"]["words"], "bold")
    if data["missing"]:
        console.print()
        print_tables(console, ((COLUMNS,),), data["missing"])
        print_lines(console, "missing", [f"{one['name']}: {one['words']}" for one in data["missing"]])
        print_tables(console, ((VALUES,),), [_value(row) for one in data["missing"] for row in one["rows"]])
        print_lines(console, "next", [NEXT])
    print_lines(console, "tried", [f"{one['name']}: {one['why']}" for one in data["tried"]])
    print_lines(console, "written", [str(path) for path in files])


def _value(row: Mapping[str, Any]) -> dict[str, Any]:
    return {**row, "text": {**row["text"], "name": row["name"]}}
