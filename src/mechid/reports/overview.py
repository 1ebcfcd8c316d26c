"""Overview of a campaign: every number in one dict, and its ink for a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console

from mechid.campaign import Campaign, CampaignRecord
from mechid.campaign.campaign import START, key_in_record, names_start
from mechid.campaign.prediction import time_base
from mechid.command import MeasuredCommand
from mechid.command.words import command_words
from mechid.ink.console import print_lines, say, say_if_synthetic
from mechid.ink.digits import digits, plain
from mechid.ink.text_table import Column, print_table
from mechid.parameter import Parameter
from mechid.plant.mechanism import Mechanism
from mechid.records import Record
from mechid.reports.channels import channel_rows, print_channels
from mechid.signal.moments import extremes, root_mean_square
from mechid.signal.stored import is_long
from mechid.units import unit_words

COLUMNS = (
    Column("parameter", "key", words=True),
    Column("symbol", "symbol", words=True),
    Column("value", "value"),
    Column("unit", "unit", words=True),
    Column("min", "min"),
    Column("max", "max"),
    Column("prior", "sigma"),
    Column("status", "status", words=True),
)


def campaign_data(campaign: Campaign, warnings: Sequence[str] = ()) -> dict[str, Any]:
    """Return all that `mechid check` shows.

    Parameters
    ----------
    campaign : Campaign
        With its records read.
    warnings : sequence of str
        In addition to the campaign's own.
    """
    return {
        "campaign": str(campaign.path),
        "mechanism": str(campaign.mechanism_path),
        "synthetic": campaign.synthetic,
        "estimated": len(campaign.estimated),
        "validated": len(campaign.validated),
        "free": [parameter.name for parameter in campaign.free],
        "records": [_record(record, campaign) for record in campaign.records],
        "channels": channel_rows(record.data for record in campaign.records),
        "parameters": [_parameter(q, campaign.mechanism) for q in campaign.mechanism.parameters.values()]
        + [
            _parameter(q, None)
            for q in campaign.free
            if q.name not in campaign.mechanism.parameters and not names_start(q.name)
        ],
        "stages": [{"records": list(s.records), "window_s": s.window_s, "free": list(s.free)} for s in campaign.stages],
        "warnings": [*campaign.warnings, *warnings],
    }


def print_campaign(data: Mapping[str, Any], console: Console) -> None:
    """Print what `campaign_data` made; what is odd comes first, where it is read."""
    say(console, f"{data['campaign']} with {data['mechanism']}", "bold")
    say_if_synthetic(console, data)
    print_lines(console, "warning", data["warnings"], "yellow")
    say(console, f"{data['estimated']} records to estimate from, {data['validated']} to validate with")
    console.print()
    for record in data["records"]:
        say(console, f"{record['name']}  ({record['use']}, {record['file']})", "bold")
        for line in record["lines"]:
            say(console, f"  {line}")
    console.print()
    if data["channels"]:
        print_channels(console, data["channels"])
    print_table(console, COLUMNS, data["parameters"])
    for row in data["parameters"]:
        if row["tied_to"]:
            say(console, f"{row['name']} follows {row['tied_to']}")
    say(console, f"{len(data['free'])} parameters to be estimated")
    for number, stage in enumerate(data["stages"], 1):
        window = "all of them" if stage["window_s"] is None else "{:.9g} s to {:.9g} s".format(*stage["window_s"])
        say(console, f"stage {number}: {', '.join(stage['free'])}; {', '.join(stage['records'])}, {window}")
    if not data["stages"]:
        say(console, "no stages: mechid plans its own")


LONG = "a long record: read block by block in {:.3g} s, kept in a temporary file while mechid runs"


def _record(record: CampaignRecord, campaign: Campaign) -> dict[str, Any]:
    found = _measured(record.data, record) if record.data else _planned(record, campaign)
    data = {
        "name": record.name,
        "use": record.use,
        "file": record.spec.path or "no file",
        "command": command_words(record.command),
        "time_offset_s": record.time_offset.value,
        "begun_s": record.command.begun_s,
        "start": [key_in_record(q.name).removeprefix(f"{START}.") for q in record.start if q.is_free],
        "burn_in_s": record.burn_in_s,
        "clock_ppm": record.timing.clock_ppm,
        "test_stand": {key_in_record(q.name): q.value for q in record.replaced if not q.is_free},
        **found,
    }
    return data | {"lines": _lines(data)}


def _measured(data: Record, record: CampaignRecord) -> dict[str, Any]:
    torque = data.channel(record.leading).data
    low, high = extremes(torque)
    end = max(data.time_start_s + data.duration_s - record.time_offset.value - record.command.begun_s, 0.0)
    return {
        "samples": data.samples,
        "reading_s": data.reading_s if is_long(data.samples) else None,
        "sample_rate_hz": data.sample_rate_hz,
        "start_s": data.time_start_s,
        "duration_s": data.duration_s,
        "edges": record.command.excitation(end).times.size,
        "stepped": not isinstance(record.command, MeasuredCommand),
        "quantity": record.leading,
        "unit": unit_words(record.leading),
        "torque_min": low,
        "torque_max": high,
        "torque_rms": root_mean_square(torque),
        "noise_sigma": data.noise_floor(record.leading),
        "start_time": data.start_time,
        "conditioning": [treatment["text"] for treatment in data.treatments],
        "planned": False,
    }


def _planned(record: CampaignRecord, campaign: Campaign) -> dict[str, Any]:
    """Return what is known of a record that has no file."""
    base = time_base(record, campaign)
    return {
        "samples": base.samples,
        "sample_rate_hz": base.sample_rate_hz,
        "start_s": base.start_s,
        "duration_s": base.duration_s,
        "edges": record.command.excitation(base.duration_s).times.size,
        "stepped": True,
        "planned": True,
    }


def _begins(begun_s: float) -> str:
    return f"begins in motion, {begun_s:.9g} s after its command" if begun_s else "begins at rest"


def _lines(data: Mapping[str, Any]) -> list[str]:
    edges = f": {data['edges']} step edges" if data["stepped"] else ""
    offset = f", {data['time_offset_s']:.9g} s late" if data["time_offset_s"] else ""
    clock = f", the driver's clock {data['clock_ppm']:.9g} ppm faster than the recorder's" if data["clock_ppm"] else ""
    lines = [data["command"] + offset + clock + edges]
    if data["test_stand"]:
        own = ", ".join(f"{name} = {value:.9g}" for name, value in data["test_stand"].items())
        lines.append(f"of its own: {own}")
    if data["start"]:
        lines.append(f"{_begins(data['begun_s'])}: its start is estimated ({', '.join(data['start'])})")
    if data["burn_in_s"]:
        lines.append(f"the first {data['burn_in_s']:.9g} s are simulated and do not count")
    if data["planned"]:
        as_if = f"for {data['duration_s']:.9g} s at {data['sample_rate_hz']:.9g} Hz by simulate and design"
        return [*lines, f"planned: it has no file, and counts {as_if}"]
    until = data["start_s"] + data["duration_s"]
    span = f"{data['start_s']:.9g} s to {until:.9g} s"
    low, high, rms, noise = (digits(data[key], 3) for key in ("torque_min", "torque_max", "torque_rms", "noise_sigma"))
    unit = data["unit"]
    return [
        *lines,
        f"{data['samples']} samples at {data['sample_rate_hz']:.9g} Hz, {span}",
        f"{data['quantity']} {low} to {high} {unit}, RMS {rms} {unit}, noise floor {noise} {unit}",
        *([LONG.format(data["reading_s"])] if data["reading_s"] is not None else []),
        *([f"recorded on {data['start_time']}"] if data["start_time"] else []),
        *(f"conditioned: {line}" for line in data["conditioning"]),
    ]


def _parameter(q: Parameter, mechanism: Mechanism | None) -> dict[str, Any]:
    table, _, key = q.name.rpartition(".")
    value = mechanism.value(q.name) if mechanism else q.value
    limits = {"min": q.min, "max": q.max} if q.is_free else {"min": None, "max": None}
    return {
        "name": q.name,
        "table": table,
        "key": key,
        "symbol": q.declaration.symbol,
        "unit": q.declaration.unit,
        "value": value,
        **limits,
        "sigma": q.sigma,
        "status": str(q.status),
        "tied_to": q.tied_to,
        "text": {
            "value": plain(value),
            "unit": "" if q.declaration.unit == "1" else q.declaration.unit,
            **{key: "" if limit is None else plain(limit) for key, limit in limits.items()},
            "sigma": "" if q.sigma is None else plain(q.sigma),
            "status": str(q.status).replace("_", " "),
        },
    }
