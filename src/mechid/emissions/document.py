"""Emission verdict as a document: the verdicts, each direction's spectra, the values over the rate, the lines."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from mechid.budgets.prediction_figures import predicts
from mechid.emissions.emission import Emission
from mechid.emissions.figures import (
    emission_figures,
    orders_name,
    over_rate_name,
    rates_of,
    spectrum_name,
    steppings_of,
    waterfall_name,
)
from mechid.emissions.numbers import emission_numbers
from mechid.emissions.predicted import BENCH
from mechid.emissions.tables import csv_texts, write_emission_workbook
from mechid.emissions.verification import emission_report
from mechid.identification.result.estimate_file import json_text
from mechid.ink.data import Data
from mechid.ink.digits import plain
from mechid.ink.document import (
    BAD,
    CAUTION,
    GOOD,
    IN_DOCUMENTS,
    Document,
    Lines,
    Part,
    Picture,
    Rows,
    Section,
    Verdict,
    Words,
)
from mechid.ink.presenter import Presenter
from mechid.ink.table import Table
from mechid.ink.text_table import MARKDOWN, PAGE, Column, OnPage, Row
from mechid.records.components import AXES
from mechid.specification.numbers import VERDICT_MEANING
from mechid.specification.requirement import AMPLITUDE, PSD
from mechid.specification.verdict import RANK
from mechid.specification.verdict import Verdict as EmissionVerdict

JSON_NAME = "emission.json"
MOST_LINES = 12
"""Largest lines of a direction that a page shows; lines.csv has all."""
AT_TRANSDUCER = "The torque at the transducer, with the load and the supply of the bench."
ON_BASE = "The torque on a held base in flight, without the test stand."
PREDICTION = (
    "The bounds hold the errors of the fit's parameters and the torque that the model lacks, as the residuals of the "
    "records show it. Where the rotor may move in several ways at a rate, the worst one counts."
)


def _verdict_style(row: Row) -> str:
    """Return the style of the cell of a verdict."""
    style = {"pass": "met", "fail": "failed"}.get(str(row["verdict"]), "open")
    return f"word {style}"


VERDICTS = (
    Column("requirement", "name", words=True),
    Column("direction", "direction", words=True),
    Column("rate, steps/s", "rate"),
    Column("frequency, Hz", "frequency"),
    Column("value", "value"),
    Column("bounds", "bounds", on_page=OnPage(wide=True)),
    Column("limit", "limit"),
    Column("unit", "unit", words=True),
    Column("margin, dB", "margin"),
    Column("verdict", "verdict", words=True, strong=True, on_page=OnPage(style=_verdict_style, wide=True)),
)
WITH_FIT = (
    *VERDICTS[:-1],
    Column("records", "records", words=True),
    Column("prediction", "predicted", words=True),
    VERDICTS[-1],
)
AT_RATES = (
    Column("record", "record", words=True),
    Column("rate, steps/s", "rate"),
    Column("frequency, Hz", "frequency"),
    Column("value", "value"),
    Column("bounds", "bounds", on_page=OnPage(wide=True)),
    Column("limit", "limit"),
    Column("background", "background"),
    Column("margin, dB", "margin"),
    Column("verdict", "verdict", words=True, on_page=OnPage(style=_verdict_style, wide=True)),
)
PREDICTED = (
    Column("stepping", "stepping", words=True),
    Column("rates", "count"),
    *(column for column in AT_RATES if column.key not in ("record", "background")),
)
LINES = (
    Column("record", "record", words=True),
    Column("rate, steps/s", "rate_text"),
    Column("frequency, Hz", "frequency_Hz"),
    Column("order", "order_text"),
    Column("amplitude, peak", "amplitude"),
    Column("± σ", "sigma"),
    Column("mains, Hz", "mains_text"),
)


STYLE = """
td.met { color: var(--good); font-weight: 600; } td.failed { color: var(--bad); font-weight: 600; }
td.open { color: var(--caution); font-weight: 600; }
"""
NAMES = {
    **{f"f{axis}": f"force along {axis}" for axis in AXES},
    **{f"m{axis}": f"moment about {axis}" for axis in AXES},
    "torque": "about the drive axis",
}


def emission_document(data: Mapping[str, Any]) -> Document:
    """Return the document of what `emission_numbers` made."""
    requirements = data["requirements"]
    return Document(
        title="Emission at the interface",
        command="mechid emission",
        under=_subtitle(data["prediction"]),
        is_synthetic=bool(data["synthetic"]),
        parts=(
            _verdict(requirements),
            Section("Requirements", tuple(_overview(data)), "requirements", "Requirements"),
            _prediction(data),
            Section("", tuple(_direction(data, one) for one in data["directions"]), entry="directions"),
            Section("", tuple(_requirement(k, one) for k, one in enumerate(requirements)), entry="requirements"),
            Section("Records", tuple(_records(data)), "records", "Records", where=(MARKDOWN, PAGE)),
        ),
    )


def _subtitle(prediction: Data | None) -> str:
    if prediction is None:
        return "Exported forces and torques of the records against their requirements, without a model."
    where = "with the values of the bench" if prediction["values"] == BENCH else "in flight"
    return f"Exported forces and torques of the records, and predicted by {prediction['fit']} {where}."


def _prediction(data: Data) -> Section:
    """Return the section of the prediction: its range, and the largest orders with what was measured of them."""
    prediction = data["prediction"]
    if prediction is None:
        return Section("", ())
    ranges = [
        f"{one['stepping']}: {one['count']} rates from {plain(one['from'], 4)} to {plain(one['to'], 4)} steps/s, "
        f"{one['tested']} of them within the records"
        for one in prediction["rates"]
    ]
    where = AT_TRANSDUCER if prediction["values"] == BENCH else ON_BASE
    words = Words(f"{where} {PREDICTION}", where=IN_DOCUMENTS)
    pictures = [
        Picture(orders_name(name), f"Largest orders over the rate, {name}") for name in steppings_of(prediction)
    ]
    return Section("Prediction", (words, Lines(ranges), *pictures), "prediction", "Prediction", where=IN_DOCUMENTS)


def _verdict(requirements: list[Data]) -> Verdict:
    counts = {word: sum(one["verdict"] == word for one in requirements) for word in ("pass", "fail", "not_shown")}
    met = f"{counts['pass']} of {len(requirements)} requirements shown to be met"
    failed = f", {counts['fail']} failed" if counts["fail"] else ""
    tone = BAD if counts["fail"] else GOOD if counts["pass"] == len(requirements) else CAUTION
    return Verdict(met + failed, tone=tone)


def _overview(data: Data) -> Iterator[Part]:
    columns = WITH_FIT if data["prediction"] else VERDICTS
    narrow = tuple(column for column in columns if column.key not in ("bounds", "unit", "direction"))
    yield Rows(Table(columns, data["requirements"], narrower=((narrow,),)))
    yield Words(VERDICT_MEANING, "soft", where=IN_DOCUMENTS)
    low, high = data["usable_band_Hz"]
    if low is not None and high is not None:
        yield Words(
            f"Judged in all directions from {plain(low, 4)} to {plain(high, 4)} Hz: from three bins of the windows "
            "to the sample rate over 2.56, or as far as the bench supports a direction.",
            "soft",
        )
    yield Lines(data["notes"], "note", "Notes", "yellow")


def _direction(data: Data, of: Data) -> Section:
    direction, unit = of["name"], of["text"]["unit"]
    own = [line for line in data["lines"] if line["direction"] == direction]
    largest = sorted(own, key=lambda line: -line["amplitude"])[:MOST_LINES]
    rows = [{**line, **_line_texts(line)} for line in largest]
    parts: list[Part] = [Picture(spectrum_name(direction, AMPLITUDE), f"Amplitude spectra of {direction} with masks")]
    if _draws_density(data, direction):
        parts.append(Picture(spectrum_name(direction, PSD), f"Power densities of {direction} with masks"))
    if len(of["rates"]) > 1:
        parts.append(Picture(waterfall_name(direction), f"Waterfall of {direction} over the step rate"))
    parts.append(Rows(Table(LINES, rows), f"Largest of {len(own)} lines, {unit}"))
    title = f"{direction}, {NAMES[direction]}"
    return Section(title, tuple(parts), f"direction-{direction}", direction, where=IN_DOCUMENTS)


def _draws_density(data: Data, direction: str) -> bool:
    """Whether a direction has a figure of densities: a requirement on the torque is on the drive axis's moment."""
    wanted = {one["direction"] for one in data["requirements"] if one["kind"] == PSD}
    measured = {one["name"] for one in data["directions"]}
    return direction in wanted or ("torque" in wanted and "torque" not in measured and direction.startswith("m"))


def _line_texts(line: Data) -> dict[str, str]:
    order = plain(line["order"], 4) if line["order"] is not None else ""
    return {
        "rate_text": plain(line["rate"], 5) if line["rate"] is not None else "",
        "order_text": ", or ".join(filter(None, (order, line["named"]))),
        "mains_text": plain(line["mains_Hz"], 4) if line["mains_Hz"] is not None else "",
    }


def _requirement(number: int, one: Data) -> Section:
    definition, unit = one["definition"], one["text"]["unit"]
    words = f"{definition[:1].upper()}{definition[1:]}. Unit: {unit}. Confidence {100.0 * one['confidence']:g} %."
    parts: list[Part] = [Words(words, "soft")]
    if predicts(one["predicted"]):
        parts.append(Picture(over_rate_name(number), f"{one['name']} over the step rate, measured and predicted"))
    elif len(rates_of(one["at_rates"])) > 1:
        parts.append(Picture(over_rate_name(number), f"{one['name']} over the step rate"))
    parts.append(Rows(Table(AT_RATES, one["at_rates"])))
    if one["predicted"] and one["predicted"]["at_rates"]:
        parts.append(Rows(Table(PREDICTED, list(_worst_of_steppings(one["predicted"]))), "Prediction, the worst rate"))
    return Section(one["name"], tuple(parts), f"requirement-{number + 1}", one["name"], where=IN_DOCUMENTS)


def _worst_of_steppings(predicted: Data) -> Iterator[Data]:
    """Yield for each way of stepping the rate that decides, with the number of rates that were judged."""
    for stepping in dict.fromkeys(at["stepping"] for at in predicted["at_rates"]):
        own = [at for at in predicted["at_rates"] if at["stepping"] == stepping]
        worst = max(own, key=_gravity)
        yield {**worst, "count": str(len(own))}


def _gravity(at: Data) -> tuple[int, float]:
    """Return the rank of a verdict, and the upper bound over the limit by which rates of one verdict are sorted."""
    nearness = float(at["worst"]["upper"] / at["worst"]["limit"]) if at["worst"] else 0.0
    return RANK[EmissionVerdict(at["verdict"])], nearness


def _records(data: Data) -> Iterator[Part]:
    columns = (
        Column("record", "name", words=True),
        Column("state", "state", words=True),
        Column("file", "file_name", words=True),
        Column("lasts, s", "duration"),
        Column("rate, Hz", "sampled"),
        Column("SHA-256", "sha256", words=True, on_page=OnPage(style="word digest", wide=True)),
    )
    rows = [
        {
            **one,
            "file_name": Path(one["file"]).name,
            "duration": plain(one["duration_s"], 5),
            "sampled": plain(one["sample_rate_hz"], 6),
        }
        for one in data["sources"]
    ]
    yield Rows(Table(columns, rows))


def _write_workbook(_found: Emission, data: Mapping[str, Any], folder: Path) -> list[Path]:
    return [write_emission_workbook(data, folder)]


PRESENTER = Presenter(
    name="emission",
    style=STYLE,
    numbers=emission_numbers,
    document=emission_document,
    line=lambda found: ", ".join(f"{one.requirement.name}: {one.verdict}" for one in found.assessments),
    texts=lambda _found, data: {JSON_NAME: json_text(data), **csv_texts(data)},
    files=_write_workbook,
    figures=emission_figures,
    report=emission_report,
)
