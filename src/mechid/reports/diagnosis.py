"""A diagnosis: every number in one dict, its files, and its ink for a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from markupsafe import Markup
from rich.console import Console

from mechid.campaign.mechanism_text import mechanism_text
from mechid.identification.diagnosis.diagnosis import Diagnosis
from mechid.identification.diagnosis.pictures import Pictures
from mechid.identification.result.diagnosis_file import FILE_NAME as DATA_NAME
from mechid.identification.result.diagnosis_file import FORMAT, PROPOSED_NAME
from mechid.identification.result.estimate_file import json_text
from mechid.reports.diagnosis_figures import STRETCH_NAME, diagnosis_figures, hertz, spectrum_name
from mechid.reports.evidence import evidence_lines
from mechid.reports.figures import write_figures
from mechid.reports.lacking import missing_data
from mechid.reports.markdown_text import bullets, cell, table
from mechid.reports.page import asset, environment
from mechid.reports.path import MEANING, path_rows
from mechid.reports.shared_tables import own_table, path_table
from mechid.reports.sheet import FOLDER_NAME
from mechid.reports.terminal import print_lines, say
from mechid.reports.text_table import Column, print_tables
from mechid.reports.themed import themed
from mechid.signal.strongest import Strongest
from mechid.writing import writable, write_together

PAGE_NAME, MARKDOWN_NAME = "diagnose.html", "diagnose.md"
PROPOSED = (
    "Proposed by mechid diagnose: the mechanism file with the effects that the records ask for, at the values found\n"
    "together with them. Nothing of it is sure before it was identified anew and makes sense for this mechanism."
)
NEXT = (
    "Where an effect makes sense for your mechanism, take it from mechanism_proposed.toml into the mechanism file and "
    "identify again; hold a record back, and see whether that is predicted better (mechid compare)."
)
APART = (
    "Where effects cannot be told apart, mechid design with --fit and --diagnosis proposes the record that tells them, "
    "if one can."
)
CANNOT_TELL = "these records cannot tell it from {0}"
LINES, BANDS = "lines", "third octaves around"
ACTS = (
    "An effect's share is what the model with all effects gives less what it gives without this one, everything else "
    "fitted again: what nothing else in the model can imitate."
)
SPECTRUM = "Density of the residual, measured less modelled, of the records that the mechanism as written misses most."
DOTTED = "Dotted: the frequencies in Hz at which an effect acts most."
STRETCH = "The part of the record that the mechanism as written misses most; below, measured less modelled."
PATH_TITLE = "The path"
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
        "missing": [_entry(missing_data(one), found.pictures) for one in found.missing],
        "unexplained": {"share": found.unexplained, "words": found.words},
        "over_noise": {"as_written": found.over_noise[0], "with_effects": found.over_noise[1]},
        "evidence": evidence_lines(found),
        "held_out": [asdict(one) for one in found.held_out],
        "locked": [asdict(one) for one in found.locked],
        "tried": [asdict(one) for one in found.tried],
        "as_written": asdict(found.as_written),
        "steps": [asdict(one) for one in found.steps],
        "path": path_rows([asdict(one) for one in found.steps], asdict(found.as_written)) if found.steps else [],
        "drawn": _drawn(found.pictures),
    }


def _entry(data: dict[str, Any], pictures: Pictures) -> dict[str, Any]:
    acts = pictures.acts.get(data["name"], {})
    places = [_place(record, acts[record]) for record in data["records"] if record in acts]
    texts = {"records": ", ".join(data["records"]), "aliases": ", ".join(data["aliases"])}
    return {
        **data,
        "frequencies_hz": {place["record"]: place["frequencies_hz"] for place in places},
        "places": places,
        "text": {**data["text"], **texts, "name": data["name"]},
    }


def _place(record: str, found: Strongest) -> dict[str, Any]:
    """Return where in a record an effect acts, with the words for it."""
    hz = [hertz(each) for each in found.frequencies_hz]
    text = " and ".join(filter(None, (", ".join(hz[:-1]), hz[-1]))) if hz else "-"
    kind = LINES if found.in_lines else BANDS
    return {"record": record, "frequencies_hz": list(found.frequencies_hz), "kind": kind, "text": text}


def _drawn(pictures: Pictures) -> dict[str, Any]:
    """Return of which records there are figures, with their names."""
    stretch = pictures.stretch
    return {
        "spectra": [{"record": one.record, "figure": spectrum_name(one.record)} for one in pictures.spectra],
        "stretch": {"record": stretch.record, "figure": STRETCH_NAME} if stretch else None,
    }


def write_diagnosis(found: Diagnosis, data: Mapping[str, Any], folder: Path | str) -> list[Path]:
    """Write diagnose.json, its page, Markdown and figures, and the proposed mechanism where there is one.

    Returns
    -------
    list of Path
        The files, and the folder of the figures where there are any.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    folder = Path(folder)
    figures: dict[str, str] = {}
    if data["drawn"]["spectra"]:
        with writable(folder):
            figures = write_figures(diagnosis_figures(found.pictures), folder / FOLDER_NAME)
    page = _page(data, figures)
    texts = {DATA_NAME: json_text(_plain(data)), MARKDOWN_NAME: diagnosis_markdown(data), PAGE_NAME: page}
    if found.mechanism is not None:
        texts[PROPOSED_NAME] = mechanism_text(found.mechanism, PROPOSED)
    return [*write_together(folder, texts), *([folder / FOLDER_NAME] if figures else [])]


def _plain(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers alone."""
    missing = [{k: v for k, v in one.items() if k not in ("rows", "text", "places")} for one in data["missing"]]
    return {**{k: v for k, v in data.items() if k not in ("path", "drawn")}, "missing": missing}


def diagnosis_markdown(data: Mapping[str, Any]) -> str:
    """Return the diagnosis as Markdown."""
    lines = ["# What the model is missing", "", data["unexplained"]["words"], ""]
    for one in data["missing"]:
        lines += [f"## {one['name']}", "", f"{_sentence(one)}", ""]
        lines += [own_table(one["rows"]).markdown(), ""]
        if one["places"]:
            places = [(place["record"], place["text"], place["kind"]) for place in one["places"]]
            lines += [table(("record", "acts most at, Hz", ""), places), ""]
        lines += ["```toml", one["toml"].rstrip(), "```", ""]
    if data["missing"]:
        lines += [bullets([*data["evidence"], *_next(data)]), ""]
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


def _next(data: Mapping[str, Any]) -> list[str]:
    """Return what to do next, a line each."""
    return [NEXT, *([APART] if any(one["aliases"] for one in data["missing"]) else [])]


def _sentence(one: Mapping[str, Any]) -> str:
    text = one["text"]
    alike = f"; {CANNOT_TELL.format(text['aliases'])}" if one["aliases"] else ""
    words = one["words"][:1].upper() + one["words"][1:]
    return (
        f"{words}: it explains {text['share_percent']} % of the misfit (chi-square "
        f"{text['chi_square']} for {one['dof']}), in the records {text['records']}{alike}."
    )


def _page(data: Mapping[str, Any], figures: Mapping[str, str]) -> str:
    sentences = {one["name"]: _sentence(one) for one in data["missing"]}
    words = {
        "next": _next(data),
        "acts": f"{DOTTED} {ACTS}",
        "spectrum": SPECTRUM,
        "stretch": STRETCH,
        "meaning": MEANING,
        "path": PATH_TITLE,
    }
    template = environment().get_template("diagnose.html")
    return template.render(
        data=data,
        sentences=sentences,
        words=words,
        figures={name: Markup(themed(text)) for name, text in figures.items()},
        path=path_table(data["path"]).html(),
        own=lambda rows: own_table(rows).html(),
        style=asset("report.css"),
    )


def print_diagnosis(data: Mapping[str, Any], console: Console, files: Sequence[Path] = ()) -> None:
    """Print what `diagnosis_data` made, and where the files are."""
    say(console, data["unexplained"]["words"], "bold")
    if data["missing"]:
        console.print()
        print_tables(console, ((COLUMNS,),), data["missing"])
        print_lines(console, "missing", [f"{one['name']}: {one['words']}" for one in data["missing"]])
        print_tables(console, ((VALUES,),), [_value(row) for one in data["missing"] for row in one["rows"]])
        print_lines(console, "acts", [_acts_line(one) for one in data["missing"] if one["places"]])
        print_lines(console, "evidence", data["evidence"])
        print_lines(console, "next", _next(data))
    if data["path"]:
        console.print()
        say(console, PATH_TITLE, "bold")
        path_table(data["path"]).print(console)
    print_lines(console, "tried", [f"{one['name']}: {one['why']}" for one in data["tried"]])
    print_lines(console, "written", [str(path) for path in files])


def _acts_line(one: Mapping[str, Any]) -> str:
    """Say where an effect acts, in a line."""
    near = {LINES: "", BANDS: "around "}
    places = [f"{near[place['kind']]}{place['text']} Hz of {place['record']}" for place in one["places"]]
    return f"{one['name']}: at {'; '.join(places)}"


def _value(row: Mapping[str, Any]) -> dict[str, Any]:
    return {**row, "text": {**row["text"], "name": row["name"]}}
