"""Tables of an emission verdict as CSV and as a workbook."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mechid.budgets.prediction_table import HEADER, TEXTS, predicted_rows
from mechid.exports.tables.table import Table, numbers, texts
from mechid.exports.tables.workbook import write_workbook

LINES_NAME, VERDICTS_NAME, PREDICTED_NAME = "lines.csv", "verdicts.csv", "predicted.csv"
WORKBOOK_NAME = "emission.xlsx"
LINE_TEXTS, VERDICT_TEXTS = (
    ("record", "direction", "unit", "named"),
    ("requirement", "direction", "kind", "unit", "verdict", "record"),
)
LINE_NUMBERS = {
    "rate_steps_per_s": "rate",
    "frequency_Hz": "frequency_Hz",
    "order": "order",
    "mains_Hz": "mains_Hz",
    "amplitude_peak": "amplitude",
    "sigma": "sigma",
    "background_peak": "background",
}
"""Columns of lines.csv that hold numbers, each with its key in emission.json."""
VERDICT_NUMBERS = {
    "rate_steps_per_s": "rate",
    "frequency_Hz": "frequency_Hz",
    "value": "value",
    "sigma": "sigma",
    "limit": "limit",
    "lower": "lower",
    "upper": "upper",
    "background": "background",
    "margin_dB": "margin_dB",
}


def csv_texts(data: Mapping[str, Any]) -> dict[str, str]:
    """Return lines.csv and verdicts.csv, with a fit predicted.csv, of what `emission_numbers` made."""
    texts_by_name = {
        LINES_NAME: _csv((*LINE_TEXTS, *LINE_NUMBERS), [_line_row(line) for line in data["lines"]]),
        VERDICTS_NAME: _csv((*VERDICT_TEXTS, *VERDICT_NUMBERS), [_verdict_row(one) for one in data["requirements"]]),
    }
    if data["prediction"]:
        texts_by_name[PREDICTED_NAME] = _csv(HEADER, _predicted_rows(data))
    return texts_by_name


def write_emission_workbook(data: Mapping[str, Any], folder: Path) -> Path:
    """Write the same tables as sheets, and return the file."""
    tables = [
        _table("verdicts", VERDICT_TEXTS, tuple(VERDICT_NUMBERS), [_verdict_row(one) for one in data["requirements"]]),
        _table("lines", LINE_TEXTS, tuple(LINE_NUMBERS), [_line_row(line) for line in data["lines"]]),
    ]
    if data["prediction"]:
        tables.append(_table("predicted", TEXTS, HEADER[len(TEXTS) :], _predicted_rows(data)))
    # A worksheet has a limited number of rows; the CSV files hold longer tables.
    return folder / write_workbook([table for table in tables if table.fits_sheet], folder, WORKBOOK_NAME)


def _predicted_rows(data: Mapping[str, Any]) -> list[list[Any]]:
    return [row for one in data["requirements"] for row in predicted_rows(one, one["predicted"])]


def _line_row(line: Mapping[str, Any]) -> list[Any]:
    return [*(line[key] for key in LINE_TEXTS), *(line[key] for key in LINE_NUMBERS.values())]


def _verdict_row(one: Mapping[str, Any]) -> list[Any]:
    worst = one["worst"] or {}
    words = [one["name"], one["direction"], one["kind"], one["unit"], one["verdict"], worst.get("record", "")]
    return [*words, *(worst.get(key) for key in VERDICT_NUMBERS.values())]


def _csv(header: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([f"{cell:.10g}" if isinstance(cell, float) else cell for cell in row] for row in rows)
    return file.getvalue()


def _table(name: str, words: Sequence[str], values: Sequence[str], rows: Sequence[Sequence[Any]]) -> Table:
    columns = [texts(key, key, [str(row[k]) for row in rows]) for k, key in enumerate(words)]
    columns += [numbers(key, "", key, [row[len(words) + k] for row in rows]) for k, key in enumerate(values)]
    return Table(name, tuple(columns))
