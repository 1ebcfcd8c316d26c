"""Document of a check: warnings, records with figures, channels, parameters and stages."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from mechid.checks.numbers import FILE_NAME, check_numbers
from mechid.identification.result.estimate_file import json_text
from mechid.ink.document import ON_TERMINAL, Document, Lines, Picture, Rows, Section, Words
from mechid.ink.presenter import Presenter
from mechid.ink.table import Table
from mechid.ink.text_table import Column

PARAMETERS = (
    Column("parameter", "key", words=True),
    Column("symbol", "symbol", words=True),
    Column("value", "value"),
    Column("unit", "unit", words=True),
    Column("min", "min"),
    Column("max", "max"),
    Column("prior", "sigma"),
    Column("status", "status", words=True),
)
CHANNEL = Column("channel", "quantity", words=True)
ORIGIN = (
    Column("column", "column", words=True),
    Column("unit", "unit", words=True),
    Column("samples", "samples"),
    Column("rate Hz", "sample_rate_hz"),
    Column("from s", "start_s"),
    Column("lasts s", "duration_s"),
)
STATISTICS = (
    Column("min", "min"),
    Column("max", "max"),
    Column("mean", "mean"),
    Column("RMS", "rms"),
    Column("noise", "noise_sigma"),
)
NAME = Column("line", "name", words=True)
PLACES = (Column("per rotor turn", "per_turn"), Column("per full step", "order"), Column("Hz", "frequency_hz"))
NAMED = (NAME, Column("of", "words", words=True), *PLACES)
KINDS = {"spectrum": "over frequency", "waterfall": "over time and frequency"}


def check_document(data: Mapping[str, Any]) -> Document:
    """Make the document from the result of `check_numbers`."""
    files = f"{data['campaign']} with {data['mechanism']}"
    narrower = ((CHANNEL, *ORIGIN), (CHANNEL, *STATISTICS))
    channels = Table((CHANNEL, *ORIGIN, *STATISTICS), data["channels"], group="record", narrower=(narrower,))
    counts = f"{data['estimated']} records to estimate from, {data['validated']} to validate with"
    tied = [f"{row['name']} follows {row['tied_to']}" for row in data["parameters"] if row["tied_to"]]
    return Document(
        title=f"Campaign {Path(data['campaign']).resolve().parent.name}",
        command="mechid check",
        under=files,
        is_synthetic=data["synthetic"],
        parts=(
            Words(files, "strong", where=ON_TERMINAL),
            Lines(data["warnings"], "warning", "Warnings", "yellow"),
            Words(counts),
            *(_record(record) for record in data["records"]),
            Section("Channels", (Rows(channels),), "channels", "Channels"),
            Section(
                "Parameters",
                (
                    Rows(Table(PARAMETERS, data["parameters"], group="")),
                    Lines(tied),
                    Words(f"{len(data['free'])} parameters to be estimated"),
                ),
                "parameters",
                "Parameters",
            ),
            *([_named_lines(data["named_lines"])] if data["named_lines"] else []),
            Section("Stages", (Lines(_stages(data)),), "stages", "Stages"),
        ),
    )


def _record(record: Mapping[str, Any]) -> Section:
    name = record["name"]
    pictures = [Picture(figure, _picture_words(figure, name), folder="") for figure in record["figures"]]
    heading = f"{name}  ({record['use']}, {record['file']})"
    return Section(heading, (Lines(record["lines"]), *pictures), f"record-{name}", name)


def _named_lines(lines: Sequence[Mapping[str, Any]]) -> Section:
    table = Table(NAMED, lines, narrower=(((NAME, *PLACES),),))
    return Section("Lines by name", (Rows(table),), "named-lines", "Lines by name")


def _picture_words(figure: str, record: str) -> str:
    return (
        f"{record} {KINDS.get(figure.rpartition('_')[2], 'over time')}" if figure != record else f"{record} over time"
    )


def _stages(data: Mapping[str, Any]) -> list[str]:
    lines = []
    for number, stage in enumerate(data["stages"], 1):
        window = "all of them" if stage["window_s"] is None else "{:.9g} s to {:.9g} s".format(*stage["window_s"])
        lines.append(f"stage {number}: {', '.join(stage['free'])}; {', '.join(stage['records'])}, {window}")
    return lines or ["no stages: mechid plans its own"]


def _figures(found: Any, _numbers: Mapping[str, Any]) -> Iterator[Any]:
    # Imported here, since Matplotlib takes half a second to load.
    from mechid.checks.figures import check_figures

    yield from check_figures(found.campaign.records)


PRESENTER = Presenter(
    name="check",
    numbers=lambda found: check_numbers(found.campaign, found.found),
    document=check_document,
    line=lambda found: f"{len(found.campaign.records)} records, {len(found.warnings)} warnings",
    texts=lambda _found, data: {FILE_NAME: json_text(data)},
    figures=_figures,
    figure_folder="",
)
