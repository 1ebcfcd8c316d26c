"""CSV tables of a survey: lines, third octaves, densities, spectra, amplitude over rate."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from mechid.analysis.look import RecordLook
from mechid.ink.data import Data
from mechid.looks.figures import spectrum_groups
from mechid.records.channel_keys import channel_keys

LINE_KEYS = ("frequency_hz", "amplitude", "sigma", "ratio", "order", "named", "mains_hz", "mains_multiple")
STEP_KEYS = ("order", "windows", "amplitude", "sigma", "peak_rate", "peak_amplitude")
NAMED_KEYS = ("names", "order", "per_turn", "windows", "amplitude", "sigma")
BAND_KEYS = ("centre_hz", "lower_hz", "upper_hz", "rms")
RATE_KEYS = ("order", "rate", "amplitude", "sigma")
SHEETS = {
    "lines.csv": ("lines", LINE_KEYS),
    "step_lines.csv": ("step_lines", STEP_KEYS),
    "named_lines.csv": ("named_lines", NAMED_KEYS),
    "third_octaves.csv": ("third_octaves", BAND_KEYS),
    "amplitude_over_rate.csv": ("over_rate", RATE_KEYS),
}
"""File name, key of its rows in a channel's dict, and their columns."""


def look_tables(data: Data, looks: Sequence[RecordLook]) -> dict[str, Iterable[str]]:
    """Return the CSV files by name, line by line; densities and spectra have one file per channel."""
    sheets: dict[str, Iterable[str]] = {name: _sheet(data, *sheet) for name, sheet in SHEETS.items()}
    for look in looks:
        for key, channel in zip(channel_keys(look.record), look.channels, strict=True):
            columns = zip(channel.density_hz.tolist(), channel.density.tolist(), strict=True)
            sheets[f"{key}_density.csv"] = _lines(("frequency_hz", "density_unit2_per_hz"), columns)
            groups = zip(*(column.tolist() for column in spectrum_groups(channel)), strict=True)
            sheets[f"{key}_spectrum.csv"] = _lines(("frequency_hz", "amplitude", "level_around"), groups)
    return sheets


def _sheet(data: Data, rows: str, keys: Sequence[str]) -> Iterator[str]:
    channels = [channel for record in data["records"] for channel in record["channels"]]
    values = (
        (channel["key"], channel["quantity"], channel["unit"], *(row[key] for key in keys))
        for channel in channels
        for row in channel[rows]
    )
    return _lines(("channel", "quantity", "unit", *keys), values)


def _lines(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> Iterator[str]:
    yield ",".join(header) + "\n"
    for row in rows:
        yield ",".join(map(_cell, row)) + "\n"


def _cell(value: Any) -> str:
    """Return a value as a cell; texts with a comma are quoted."""
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:.10g}"
    text = " or ".join(value) if isinstance(value, list) else str(value)
    return '"' + text.replace('"', '""') + '"' if any(c in text for c in ',"\n') else text
