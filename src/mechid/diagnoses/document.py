"""Document of a diagnosis: effects with location and evidence, and next steps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from mechid.campaign.mechanism_text import mechanism_text
from mechid.diagnoses.effect_rows import own_table
from mechid.diagnoses.figures import diagnosis_figures
from mechid.diagnoses.numbers import BANDS, LINES, diagnosis_numbers, plain_numbers
from mechid.diagnoses.path import MEANING, path_table
from mechid.identification.diagnosis.diagnosis import Diagnosis
from mechid.identification.result.diagnosis_file import FILE_NAME, PROPOSED_NAME
from mechid.identification.result.estimate_file import json_text
from mechid.ink.document import (
    IN_DOCUMENTS,
    ON_TERMINAL,
    Code,
    Document,
    Lines,
    Part,
    Picture,
    Rows,
    Section,
    Words,
)
from mechid.ink.presenter import Presenter
from mechid.ink.table import Table
from mechid.ink.text_table import Column

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
ACTS = (
    "An effect's share is what the model with all effects gives less what it gives without this one, everything else "
    "fitted again: what nothing else in the model can imitate."
)
SPECTRUM = "Density of the residual, measured less modelled, of the records that the mechanism as written misses most."
DOTTED = "Dotted: the frequencies in Hz at which an effect acts most."
STRETCH = "The part of the record that the mechanism as written misses most; below, measured less modelled."

EFFECTS = (
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
PLACES = (
    Column("record", "record", words=True),
    Column("acts most at, Hz", "text_hz", words=True),
    Column("", "kind", words=True),
)


def diagnosis_document(data: Mapping[str, Any]) -> Document:
    """Make the document from the result of `diagnosis_numbers`."""
    return Document(
        title="What the model is missing",
        command="mechid diagnose",
        is_synthetic=bool(data["synthetic"]),
        parts=[Words(data["unexplained"]["words"], "strong"), *_parts(data)],
    )


def _parts(data: Mapping[str, Any]) -> Iterator[Part]:
    yield from _all_effects(data)
    yield from (_effect(number, one) for number, one in enumerate(data["missing"], 1))
    if data["missing"]:
        said = (Lines(data["evidence"], "evidence"), Lines(next_lines(data), "next"))
        yield Section("What speaks for it, and what to do next", said, "next", "Next")
    yield from _picture_sections(data)
    if data["path"]:
        steps = (Rows(path_table(data["path"])), Words(MEANING, where=IN_DOCUMENTS))
        yield Section("The path", steps, "path", "The path")
    tried = data["tried"]
    yield Lines([f"{one['name']}: {one['why']}" for one in tried], "tried", where=ON_TERMINAL)
    lines = Lines([f"**{one['name']}**: {one['words']}; {one['why']}" for one in tried], where=IN_DOCUMENTS)
    yield Section("Tried and not named", (lines,), "tried", entry="Tried")


def _all_effects(data: Mapping[str, Any]) -> Iterator[Part]:
    """Yield all effects in one section for a terminal; documents have one section each."""
    missing = data["missing"]
    yield Rows(Table(EFFECTS, missing), where=ON_TERMINAL)
    yield Lines([f"{one['name']}: {one['words']}" for one in missing], "missing", where=ON_TERMINAL)
    yield Rows(Table(VALUES, [_value(row) for one in missing for row in one["rows"]]), where=ON_TERMINAL)
    yield Lines([_acts(one) for one in missing if one["places"]], "acts", where=ON_TERMINAL)


def _value(row: Mapping[str, Any]) -> dict[str, Any]:
    return {**row, "text": {**row["text"], "name": row["name"]}}


def _acts(one: Mapping[str, Any]) -> str:
    near = {LINES: "", BANDS: "around "}
    places = [f"{near[place['kind']]}{place['text']} Hz of {place['record']}" for place in one["places"]]
    return f"{one['name']}: at {'; '.join(places)}"


def _effect(number: int, one: Mapping[str, Any]) -> Section:
    places = [{"record": p["record"], "text_hz": p["text"], "kind": p["kind"]} for p in one["places"]]
    parts = (
        Words(sentence(one)),
        Rows(own_table(one["rows"])),
        Rows(Table(PLACES, places)),
        Code(one["toml"], summary="What declares it"),
    )
    return Section(one["name"], parts, f"effect-{number}", entry=one["name"], where=IN_DOCUMENTS)


def sentence(one: Mapping[str, Any]) -> str:
    """Describe the share of an effect, and the effects from which it cannot be distinguished."""
    text = one["text"]
    alike = f"; {CANNOT_TELL.format(text['aliases'])}" if one["aliases"] else ""
    words = one["words"][:1].upper() + one["words"][1:]
    return (
        f"{words}: it explains {text['share_percent']} % of the misfit (chi-square "
        f"{text['chi_square']} for {one['dof']}), in the records {text['records']}{alike}."
    )


def next_lines(data: Mapping[str, Any]) -> list[str]:
    """Return the next steps, one line each."""
    return [NEXT, *([APART] if any(one["aliases"] for one in data["missing"]) else [])]


def _picture_sections(data: Mapping[str, Any]) -> Iterator[Section]:
    drawn = data["drawn"]
    words = " ".join([SPECTRUM, *([DOTTED, ACTS] if data["missing"] else [])])
    pictures = [
        Section(one["record"], (Picture(one["figure"], f"Spectrum of what is left of {one['record']}"),))
        for one in drawn["spectra"]
    ]
    if pictures:
        yield Section(
            "What is left, over frequency", (Words(words), *pictures), "spectra", "Over frequency", where=IN_DOCUMENTS
        )
    if drawn["stretch"]:
        record = drawn["stretch"]["record"]
        picture = Picture(drawn["stretch"]["figure"], f"Measured and modelled of {record}, before and after")
        yield Section(
            f"Before and after: {record}",
            (Words(STRETCH), picture),
            "stretch",
            "Before and after",
            where=IN_DOCUMENTS,
        )


def _texts(found: Diagnosis, data: Mapping[str, Any]) -> dict[str, str]:
    texts = {FILE_NAME: json_text(plain_numbers(data))}
    if found.mechanism is not None:
        texts[PROPOSED_NAME] = mechanism_text(found.mechanism, PROPOSED)
    return texts


PRESENTER = Presenter(
    name="diagnose",
    numbers=diagnosis_numbers,
    document=diagnosis_document,
    line=lambda found: ", ".join(one.name for one in found.missing) or "nothing is named",
    texts=_texts,
    figures=lambda found, data: diagnosis_figures(found.pictures),
)
