"""Numbers of a check, in one dict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from mechid.analysis.commanded_rate import commanded_rate
from mechid.campaign import Campaign, CampaignRecord
from mechid.campaign.campaign import START, is_start_name, key_in_record
from mechid.campaign.prediction import time_base
from mechid.command import MeasuredCommand
from mechid.command.words import command_words
from mechid.identification.output_error.digests import file_digests
from mechid.ink.digits import digits, plain
from mechid.parameter import Parameter
from mechid.plant.mechanism import Mechanism, NamedLine
from mechid.records import Channel, Record
from mechid.records.channel_keys import channel_keys
from mechid.signal.moments import extremes, mean, root_mean_square
from mechid.signal.stored_series import is_long
from mechid.simulation.simulator import TimeBase
from mechid.units import unit_words

FORMAT = "mechid-check/1"
FILE_NAME = "check.json"


def check_numbers(campaign: Campaign, warnings: Sequence[str] = ()) -> dict[str, Any]:
    """Return the numbers shown by a check.

    Parameters
    ----------
    campaign : Campaign
        Campaign with its records read.
    warnings : sequence of str
        Warnings in addition to those of the campaign.
    """
    return {
        "format": FORMAT,
        "campaign": str(campaign.path),
        "mechanism": str(campaign.mechanism_path),
        "synthetic": campaign.synthetic,
        "estimated": len(campaign.estimated),
        "validated": len(campaign.validated),
        "free": [parameter.name for parameter in campaign.free],
        "records": [_record(record, campaign) for record in campaign.records],
        "channels": [_channel(r.data, channel) for r in campaign.records if r.data for channel in r.data.channels],
        "parameters": [_parameter(q, campaign.mechanism) for q in campaign.mechanism.parameters.values()]
        + [
            _parameter(q, None)
            for q in campaign.free
            # Free initial states are listed with their record, under `start`.
            if q.name not in campaign.mechanism.parameters and not is_start_name(q.name)
        ],
        "named_lines": [_named_line(one) for one in campaign.mechanism.named_lines],
        "stages": [{"records": list(s.records), "window_s": s.window_s, "free": list(s.free)} for s in campaign.stages],
        "warnings": [*campaign.warnings, *warnings],
        "provenance": {"campaign": str(campaign.path.resolve()), "inputs_sha256": file_digests(campaign)},
    }


def has_one_rate(record: CampaignRecord, data: Record) -> bool:
    """Return whether the command of a record has a constant rate."""
    base = TimeBase(data.sample_rate_hz, data.samples, data.time_start_s)
    measured = isinstance(record.command, MeasuredCommand)
    return not measured and len(commanded_rate(record.command.rate, record.time_offset.value, base)) == 1


LONG = "a long record: read block by block in {:.3g} s, kept in a temporary file while mechid runs"


def _record(record: CampaignRecord, campaign: Campaign) -> dict[str, Any]:
    found = _measured_entry(record.data, record) if record.data else _planned_entry(record, campaign)
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
        "test_stand": {key_in_record(q.name): q.value for q in record.overrides if not q.is_free},
        **found,
    }
    return data | {"lines": _lines(data)}


def _measured_entry(data: Record, record: CampaignRecord) -> dict[str, Any]:
    torque = data.channel(record.leading).data
    low, high = extremes(torque)
    # A record may end before its command starts.
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
        "figures": figure_names(record, data),
    }


def _planned_entry(record: CampaignRecord, campaign: Campaign) -> dict[str, Any]:
    """Return the entry of a record without a file."""
    base = time_base(record, campaign)
    return {
        "samples": base.samples,
        "sample_rate_hz": base.sample_rate_hz,
        "start_s": base.start_s,
        "duration_s": base.duration_s,
        "edges": record.command.excitation(base.duration_s).times.size,
        "stepped": True,
        "planned": True,
        "figures": [],
    }


def figure_names(record: CampaignRecord, data: Record) -> list[str]:
    """Return the names of a record's figures: the record over time, then each channel over frequency."""
    # At a constant rate a waterfall would repeat the spectrum.
    kinds = ("spectrum",) if has_one_rate(record, data) else ("spectrum", "waterfall")
    return [record.name, *(f"{key}_{kind}" for key in channel_keys(data) for kind in kinds)]


def _channel(record: Record, channel: Channel) -> dict[str, Any]:
    values = channel.data
    low, high = extremes(values)
    numbers = {
        "samples": record.samples,
        "sample_rate_hz": record.sample_rate_hz,
        "start_s": record.time_start_s,
        "duration_s": record.duration_s,
        "min": low,
        "max": high,
        "mean": mean(values),
        "rms": root_mean_square(values),
        "noise_sigma": record.noise_floor(channel.quantity),
    }
    exact = {key: plain(numbers[key], 9) for key in ("samples", "sample_rate_hz", "start_s", "duration_s")}
    measured = {key: digits(numbers[key], 4) for key in ("min", "max", "mean", "rms", "noise_sigma")}
    row = {"table": record.name, "quantity": channel.quantity, "column": channel.column, "unit": channel.unit}
    return {**row, **numbers, "text": {**exact, **measured}}


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
        base = f"for {data['duration_s']:.9g} s at {data['sample_rate_hz']:.9g} Hz by simulate and design"
        return [*lines, f"planned: it has no file, and counts {base}"]
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


def _named_line(line: NamedLine) -> dict[str, Any]:
    turns = None if line.frequency_hz is not None else line.per_turn
    numbers = {"per_turn": turns, "order": line.order, "frequency_hz": line.frequency_hz}
    text = {key: plain(value, 6) if value is not None else "" for key, value in numbers.items()}
    return {"name": line.name, "words": line.words, **numbers, "text": text}


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
