"""Survey document: all channels in one table, then each record with its channels."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from markupsafe import Markup

from mechid.analysis.survey import Survey
from mechid.identification.result.estimate_file import json_text
from mechid.ink.data import Data
from mechid.ink.digits import plain
from mechid.ink.document import IN_DOCUMENTS, Document, Lines, Part, Picture, Rows, Section, Words
from mechid.ink.page_rules import COMPACT, ONE_COLUMN
from mechid.ink.presenter import Presenter
from mechid.ink.quantities import quantity_words
from mechid.ink.table import Table
from mechid.ink.text_table import PAGE, Column, OnPage, Row
from mechid.looks.csv_files import look_tables
from mechid.looks.figures import look_figures
from mechid.looks.numbers import look_numbers
from mechid.writing import write_together

JSON_NAME, CSV_FOLDER = "look.json", "csv"
PLAIN = "plain"
"""Class of tables of numbers, which scroll on a small page."""
FEW = 12
"""Largest number of spectral lines for which a page does not fold the table."""
TAB_LETTERS = 60
"""Largest number of letters of a page's title in a browser."""
SHARED = "Frequencies that do not follow the step rate, in several records or by several orders of one"
ORDERS = "Orders of the step rate (1: once a full step), RMS over windows of equal travel"
NAMED = "Lines that the mechanism file names, RMS over windows of equal travel"
ABOUT = {
    "health": "Health",
    "noise": "Noise",
    "lines": "Lines",
    "mains": "Mains",
    "resonances": "Frequencies that do not follow the rate",
}
"""Heading of each kind of sentence on a channel; a terminal begins its lines with the kind."""


def _channel_link(row: Row) -> Markup:
    return Markup('<a href="#channel-{}">{}</a>').format(row["key"], row["name"])


OVERVIEW = (
    Column("record", "name", words=True, on_page=OnPage(ink=_channel_link)),
    Column("channel", "channel", words=True),
    Column("samples", "samples"),
    Column("rate, Hz", "sample_rate_hz"),
    Column("lasts, s", "duration_s"),
    Column("RMS", "rms"),
    Column("noise", "noise"),
    Column("unit", "unit", words=True, on_page=OnPage(style="word short")),
    Column("largest line", "largest", words=True, on_page=OnPage(style="word short")),
    Column("health", "health", words=True, on_page=OnPage(wide=True)),
)
FIGURES = (
    (
        "time",
        "Over time",
        "Least and largest sample of each column of the picture. Green: quiet; orange: at its extreme; pink: missing "
        "samples.",
        "Time history",
    ),
    (
        "over_rate",
        "Amplitude over the step rate",
        "Each order of the step rate in windows of equal travel, the noise's power subtracted. Dotted: where an order "
        "passes a resonance.",
        "Amplitude over the step rate",
    ),
    (
        "spectrum",
        "Spectrum",
        "Amplitude under a Hann window, over the level around it. Dots are lines: pink with their order of the step "
        "rate or their name in the mechanism file, orange at multiples of the mains, grey neither. Shaded: resonances.",
        "Amplitude spectrum",
    ),
    ("waterfall", "Waterfall", "", "Waterfall"),
    ("bands", "Density, and RMS in third octaves", "", "Power density and third octaves"),
)
"""Figures of each channel: suffix of the name, heading, caption, and content."""
STYLE = f"""{COMPACT}{ONE_COLUMN}
.short {{ white-space: nowrap; }}
@media print {{ section:has(> h2[id^="record-"]) {{ break-before: page; }} }}
"""


def look_document(data: Mapping[str, Any]) -> Document:
    """Return the document of the data of `look_numbers`."""
    records = data["records"]
    names = ", ".join(record["name"] for record in records)
    return Document(
        title=f"A look at {len(records)} record{'s' * (len(records) != 1)}",
        command="mechid look",
        under="What they show by themselves, before any model.",
        tab=names if len(names) <= TAB_LETTERS else f"{names[: TAB_LETTERS - 3]}...",
        parts=(
            Section("Overview", tuple(_overview(data)), "overview", "Overview"),
            *(_record(record) for record in records),
        ),
    )


def _overview(data: Data) -> Iterator[Part]:
    rows = [_channel_row(record, channel) for record in data["records"] for channel in record["channels"]]
    yield Rows(Table(OVERVIEW, rows), where=IN_DOCUMENTS)
    yield Lines([one["words"] for one in data["resonances"]], "resonance", SHARED)
    messages = [one["message"] for one in data["left_out"]]
    yield Lines(messages, "left out", "Files that could not be read", "yellow")


def _channel_row(record: Data, channel: Data) -> dict[str, Any]:
    largest = max(channel["lines"], key=lambda line: line["amplitude"], default=None)
    words = filter(None, (f"{largest['text']['frequency_hz']} Hz", largest["text"]["what"])) if largest else ["none"]
    return {
        **channel,
        "name": record["name"],
        "channel": quantity_words(channel["quantity"]),
        "largest": ", ".join(words),
        "health": channel["words"]["health"][0],
        "text": {**record["text"], **channel["text"]},
    }


def _record(record: Data) -> Section:
    text = record["text"]
    recorded = f"; recorded on {record['start_time']}" if record["start_time"] else ""
    size = f"{text['samples']} samples at {text['sample_rate_hz']} Hz, {text['duration_s']} s"
    parts: tuple[Part, ...] = (
        Words(f"{record['file']}; {size}{recorded}", "soft"),
        Lines(record["driven"]["words"]),
        Lines(record["treatments"], heading="What was done to read it"),
        Lines(record["warnings"], "warning", "What is odd", "yellow"),
        *(_channel(channel) for channel in record["channels"]),
        Words(f"SHA-256 {record['sha256']}", "soft", where=IN_DOCUMENTS),
    )
    return Section(record["name"], parts, f"record-{record['name']}", record["name"])


def _channel(channel: Data) -> Section:
    unit, words = channel["unit"], channel["words"]
    about = tuple(Lines(words[kind], kind, heading) for kind, heading in ABOUT.items())
    return Section(
        f"{_with_unit(quantity_words(channel['quantity']), unit)} (column {channel['column']})",
        (
            Section("", about, side_by_side=True),
            *_figures(channel),
            Rows(_step_lines(channel), _with_unit(ORDERS, unit), where=IN_DOCUMENTS),
            *([Rows(_named_lines(channel), _with_unit(NAMED, unit))] if channel["named_lines"] else []),
            _all_lines(channel),
            Section("Third octaves", (Rows(_third_octaves(channel)),), is_folded=True, where=(PAGE,)),
        ),
        f"channel-{channel['key']}",
    )


def _with_unit(words: str, unit: str) -> str:
    return f"{words}, {unit}" if unit else words


def _figures(channel: Data) -> Iterator[Section]:
    for kind, heading, caption, shown in FIGURES:
        if kind != "over_rate" or channel["over_rate"]:
            picture = Picture(f"{channel['key']}_{kind}", f"{shown} of {channel['key']}")
            yield Section(heading, (Words(caption, "soft"), picture), where=IN_DOCUMENTS)


def _step_lines(channel: Data) -> Table:
    columns = (
        Column("order", "order"),
        Column("amplitude", "amplitude"),
        Column("± σ", "sigma"),
        Column("windows", "windows"),
        Column("largest", "peak_amplitude"),
        Column("at, full steps/s", "peak_rate"),
    )
    return Table(columns, channel["step_lines"], style=PLAIN)


def _named_lines(channel: Data) -> Table:
    columns = (
        Column("line", "names", words=True),
        Column("order", "order"),
        Column("per rotor turn", "per_turn"),
        Column("amplitude", "amplitude"),
        Column("± σ", "sigma"),
    )
    return Table(columns, channel["named_lines"], style=PLAIN)


def _all_lines(channel: Data) -> Section:
    """Return every line of the spectrum, on a page only, since there may be hundreds."""
    columns = (
        Column("frequency, Hz", "frequency_hz"),
        Column(_with_unit("amplitude", channel["unit"]), "amplitude"),
        Column("± σ", "sigma"),
        Column("power over its surroundings", "ratio"),
        Column("what it may be", "what", words=True),
    )
    lines = channel["lines"]
    heading = f"All {len(lines)} lines of the spectrum"
    return Section(heading, (Rows(Table(columns, lines, style=PLAIN)),), is_folded=len(lines) > FEW, where=(PAGE,))


def _third_octaves(channel: Data) -> Table:
    columns = (Column("centre, Hz", "centre"), Column(_with_unit("RMS", channel["unit"]), "rms"))
    bands = [("below", channel["below_rms"])]
    bands += [(plain(band["centre_hz"], 4), band["rms"]) for band in channel["third_octaves"]]
    return Table(columns, [{"text": {"centre": centre, "rms": plain(rms, 3)}} for centre, rms in bands], style=PLAIN)


def _write_tables(found: Survey, data: Mapping[str, Any], folder: Path) -> list[Path]:
    # The tables are many; a folder of their own keeps the results readable.
    (folder / CSV_FOLDER).mkdir(exist_ok=True)
    write_together(folder, {f"{CSV_FOLDER}/{name}": text for name, text in look_tables(data, found.looks).items()})
    return [folder / CSV_FOLDER]


PRESENTER = Presenter(
    name="look",
    numbers=look_numbers,
    document=look_document,
    line=lambda found: ", ".join(look.record.name for look in found.looks),
    texts=lambda _found, data: {JSON_NAME: json_text(data)},
    files=_write_tables,
    figures=lambda found, _data: look_figures(found.looks),
    style=STYLE,
)
