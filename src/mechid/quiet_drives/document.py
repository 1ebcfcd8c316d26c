"""Document of a quiet drive: gain, lines before and after, reserve, rates, layouts of drivers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from mechid.identification.result.estimate_file import json_text
from mechid.ink.document import BAD, GOOD, IN_DOCUMENTS, Document, Lines, Part, Picture, Rows, Section, Verdict, Words
from mechid.ink.presenter import Presenter
from mechid.ink.table import Table
from mechid.ink.text_table import Column
from mechid.quiet_drives.numbers import FILE_NAME, quiet_numbers
from mechid.quiet_drives.quiet_drive import QuietDrive
from mechid.quiet_drives.settings import QUIET
from mechid.quiet_drives.table_files import (
    HEADER_NAME,
    RATES_CSV,
    RATES_TOML,
    TABLE_NAME,
    rates_csv,
    rates_toml,
    table_csv,
    table_header,
)

GAINS = (
    Column("rate", "rate", said="rate, full steps/s"),
    Column("before", "before", said="RMS before, {unit}"),
    Column("after", "after", said="RMS after, {unit}"),
    Column("gain dB", "gain", said="gain, dB"),
    Column("95 % dB", "bound", said="gain exceeded with 95 %, dB"),
)
LINES = (
    Column("rate", "rate", said="rate, full steps/s"),
    Column("order", "order"),
    Column("before", "before", said="before, N m"),
    Column("bound", "before_bound", said="95 % bound"),
    Column("after", "after", said="after, N m"),
    Column("bound", "after_bound", said="95 % bound"),
    Column("down dB", "reduction", said="reduction, dB"),
)
RESERVES = (
    Column("rate", "rate", said="rate, full steps/s"),
    Column("nominal", "nominal", said="nominal table, N m"),
    Column("table", "table", said="this table, N m"),
    Column("share", "share"),
)
SENSITIVITIES = (
    Column("parameter", "name", words=True),
    Column("change dB", "change_db", said="change of the gain, dB"),
)
UNITS = (Column("unit", "unit", words=True), *GAINS[:4])
BANDS = (
    Column("stepping", "stepping", words=True),
    Column("from", "low", said="from, full steps/s"),
    Column("to", "high"),
    Column("worst", "worst", said="largest bound, {unit}"),
)
PAIRS = (
    Column("mean", "mean", said="mean rate, full steps/s"),
    Column("stepping", "stepping", words=True),
    Column("low", "low", said="lower rate"),
    Column("high", "high", said="higher rate"),
    Column("time", "share", said="time at the higher"),
    Column("RMS", "rms", said="RMS bound, {unit}"),
    Column("alone", "alone", said="at the mean rate, {unit}"),
)
VERDICTS = (
    Column("requirement", "name", words=True),
    Column("nominal", "nominal", words=True),
    Column("table", "table", words=True),
)
CONFIRMATIONS = (
    Column("rate", "rate", said="rate, full steps/s"),
    Column("seconds", "seconds", said="length, s"),
    Column("command", "command", words=True),
)
DRIVERS = (
    Column("driver", "driver", words=True),
    Column("gain dB", "gains", said="gain at the design rates, dB"),
    Column("note", "note", words=True),
)
MEANING = (
    "{level} with the nominal sine table and with the table found here. Bounds are 95 % quantiles: "
    "covariance of the parameters, model discrepancy and unmodelled torque."
)
LEVELS = {"N*m": "Torque on a held base", "rad": "Lines of sight {axes}, their root sum of squares,"}
"""What is compared, by its unit."""
SHORT = {"N*m": "RMS torque", "rad": "RMS line of sight"}
RESERVE = (
    "Dry friction at the rotor that may be added before steps are lost, in a run that rises to the rate and stops."
)
RATES = (
    "{level} over the rate of each stepping, with its 95 % bound over draws of the covariance. Recommended rates "
    "have a bound in the lowest quarter of all; forbidden ones exceed the limit."
)


CONFIRM = (
    "Length of a record on the bench of the fit, at a constant rate with this table, that shows the RMS of the torque "
    "lines to 1 dB with 95 %. The bench's noise counts as white; record the nominal table for as long."
)


def quiet_document(data: Mapping[str, Any]) -> Document:
    """Make the document from the result of `quiet_numbers`."""
    return Document(
        title="Quiet drive",
        command="mechid quiet",
        under=f"{data['fit']}, grade {data['grade']}",
        is_synthetic=bool(data["synthetic"]),
        parts=tuple(_parts(data)),
    )


def _parts(data: Mapping[str, Any]) -> Iterator[Part]:
    yield _verdict(data)
    unit = data["level_unit"]
    level = LEVELS[unit].format(axes=", ".join(data["lines_of_sight"]))
    yield Words(MEANING.format(level=level), where=IN_DOCUMENTS)
    yield Section(
        "Gain",
        (Rows(Table(_columns(GAINS, unit), data["gains"])), Picture("quiet_table", "Table over the electrical angle")),
        "gain",
        "Gain",
    )
    yield Section("Torque lines before and after", (Rows(Table(LINES, data["lines"])),), "lines", "Lines")
    yield Section(
        "Torque reserve",
        (Words(RESERVE, where=IN_DOCUMENTS), Rows(Table(RESERVES, data["margins"]))),
        "reserve",
        "Reserve",
    )
    yield Section(
        "Sensitivity of the gain",
        (
            Words(
                "Mean gain at the design rates with one parameter two standard errors off, the worse side.",
                where=IN_DOCUMENTS,
            ),
            Rows(Table(SENSITIVITIES, data["sensitivity"])),
        ),
        "sensitivity",
        "Sensitivity",
        where=IN_DOCUMENTS,
    )
    units = [{"unit": name, **gain} for name, gains in data["units"].items() for gain in gains]
    yield Section("The table on other units", (Rows(Table(_columns(UNITS, unit), units)),), "units", "Other units")
    yield Section("Rates and stepping", tuple(_rates(data["survey"], unit)), "rates", "Rates")
    yield Section("Requirements", (Rows(Table(VERDICTS, data["requirements"])),), "requirements", "Requirements")
    yield Section(
        "Record that confirms it",
        (Words(CONFIRM, where=IN_DOCUMENTS), Rows(Table(CONFIRMATIONS, data["confirmations"]))),
        "confirmation",
        "Confirmation",
    )
    yield Section("Drivers with a wave table", (Rows(Table(DRIVERS, data["drivers"])),), "drivers", "Drivers")


def _verdict(data: Mapping[str, Any]) -> Verdict:
    gains = [one["gain_db"] for one in data["gains"]]
    rise = data["worst_rise"]["rise_db"]
    loud = rise is None or rise > QUIET.promised_rise_db
    if rise is None:
        over = "but the rotor loses steps in the range"
    elif rise <= 0.0:
        over = "and lower at all rates of the range"
    else:
        over = f"at most {rise:.1f} dB up elsewhere in the range"
    rates = f"{len(gains)} design rates" if len(gains) > 1 else "the design rate"
    size = f"{min(gains):.1f}" if len(gains) == 1 else f"{min(gains):.1f} to {max(gains):.1f}"
    headline = f"{SHORT[data['level_unit']]} down by {size} dB at {rates} with {data['table']['bits']} bits, {over}."
    return Verdict(
        headline, tone=BAD if loud else GOOD, warnings=Lines(data["warnings"], "warning", "Warnings", "yellow")
    )


def _rates(survey: Mapping[str, Any], unit: str) -> Iterator[Part]:
    yield Words(RATES.format(level=SHORT[unit]), where=IN_DOCUMENTS)
    yield Picture("quiet_rates", f"{SHORT[unit]} over the rate of each stepping")
    yield Rows(Table(_columns(BANDS, unit), survey["recommended"]), "Widest recommended bands")
    yield Rows(Table(_columns(BANDS, unit), survey["forbidden"]), "Widest forbidden bands")
    yield Rows(Table(_columns(PAIRS, unit), survey["pairs"]), "Pairs of rates that alternate to a mean rate")


def _columns(columns: tuple[Column, ...], unit: str) -> tuple[Column, ...]:
    """Return columns with the unit of the level in their heads."""
    return tuple(replace(one, said=one.said and one.said.format(unit=unit.replace("*", " "))) for one in columns)


def _texts(found: QuietDrive, data: Mapping[str, Any]) -> dict[str, str]:
    return {
        FILE_NAME: json_text(data),
        TABLE_NAME: table_csv(found.table),
        HEADER_NAME: table_header(data),
        RATES_CSV: rates_csv(data),
        RATES_TOML: rates_toml(data),
    }


def _figures(_found: QuietDrive, data: Mapping[str, Any]) -> Iterator[Any]:
    # Imported here, since Matplotlib takes half a second to load.
    from mechid.quiet_drives.figures import quiet_figures

    yield from quiet_figures(data)


def _line(found: QuietDrive) -> str:
    gains = ", ".join(f"{one.gain_db:.1f} dB at {one.rate:g}" for one in found.improvement.gains)
    return f"{len(found.table)} microsteps, {gains} full steps/s"


PRESENTER = Presenter(
    name="quiet",
    numbers=quiet_numbers,
    document=quiet_document,
    line=_line,
    texts=_texts,
    figures=_figures,
)
