"""Division of a record into consecutive stretches, each a record with its own start.

A chaotic motion amplifies any difference, so that even a perfect model can follow it for a limited time only. Stretches
shorter than that time can be followed, each from its own initial state.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from mechid.campaign.campaign import CAMPAIGN, CampaignRecord, key_in_record, record_parameter_name
from mechid.campaign.place import Place, number
from mechid.campaign.start_entry import ESTIMATED
from mechid.campaign.start_entry import KEY as START_STATE
from mechid.command import MeasuredCommand
from mechid.parameter import Parameter
from mechid.records import Record
from mechid.signal.series import Series, stretch_of
from mechid.signal.stored_series import is_long

KEY = "stretch_s"
LEAST = 64
"""Least number of samples in a stretch."""
Entries = list[tuple[CampaignRecord, Mapping[str, Any], Place]]
"""Records, each with its table in the campaign file and the place of the table."""


def read_stretch(table: Mapping[str, Any], place: Place) -> float:
    """Read the length in s of the stretches of a record; 0 keeps it whole."""
    if KEY not in table:
        return 0.0
    seconds = number(table[KEY], place.key(KEY), "s")
    if seconds <= 0.0:
        raise place.key(KEY).error(f"found {seconds:.9g}; write the length of a stretch in s, above 0")
    return seconds


def cut_into_stretches(
    records: Sequence[CampaignRecord], entries: Sequence[Mapping[str, Any]], place: Place, *, staged: bool
) -> Entries:
    """Cut records into their stretches, and pair each with its table.

    Stretch k of a record is named ``<name>_<k>``, counted from 1. The first starts like the record, the others in
    motion.

    Parameters
    ----------
    records : sequence of CampaignRecord
    entries : sequence of Mapping
        Their tables in the campaign file.
    place : Place
        Place of that file.
    staged : bool
        Whether the file has stages; these name whole records.

    Raises
    ------
    InputFileError
        A stretch is too short or has the name of another record, or the file has stages.
    """
    cut: Entries = []
    for index, (record, entry) in enumerate(zip(records, entries, strict=True)):
        at = place.key("record").item(index)
        if not record.stretch_s or record.data is None:
            cut.append((record, entry, at))
            continue
        if staged:
            raise at.key(KEY).error("stages name whole records; leave the stages out, or the stretches")
        cut += [(one, _entry_of(one, entry), at) for one in _cut_record(record, record.data, at.key(KEY))]
    _refuse_same_names(cut)
    return cut


def _entry_of(stretch: CampaignRecord, entry: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the table of a stretch, without initial states if the stretch starts at rest."""
    return entry if stretch.command.start == ESTIMATED else {k: v for k, v in entry.items() if k != START_STATE}


def _cut_record(record: CampaignRecord, data: Record, place: Place) -> list[CampaignRecord]:
    # The margin keeps rounding from adding a stretch; the samples bound the count if the length is tiny.
    count = max(math.ceil(min(data.duration_s / record.stretch_s, data.samples) - 1e-6), 1)
    if data.samples < count * LEAST:
        least = f"{LEAST / data.sample_rate_hz:.6g} s"
        raise place.error(f"found {record.stretch_s:.9g}; a stretch has {LEAST} samples at least, here {least}")
    # Equal lengths, so that no short remainder is left at the end.
    edges = np.linspace(0, data.samples, count + 1).round().astype(int).tolist()
    return [_stretch(record, data, k, *edges[k : k + 2]) for k in range(count)]


def _stretch(record: CampaignRecord, data: Record, k: int, first: int, stop: int) -> CampaignRecord:
    name = f"{record.name}_{k + 1}"
    channels = tuple(
        replace(
            c,
            data=_part(c.data, first, stop),
            bridged=c.bridged[(c.bridged >= first) & (c.bridged < stop)] - first,
        )
        for c in data.channels
    )
    start_s = data.time_start_s + first / data.sample_rate_hz
    part = replace(data, name=name, time_start_s=start_s, channels=channels, warnings=data.warnings if k == 0 else ())
    # Only the first stretch starts like the record; the others are cut out of the motion.
    command = record.command if k == 0 else replace(record.command, start=ESTIMATED)
    if isinstance(command, MeasuredCommand):
        own = {c.quantity: c.data[:] for c in part.inputs}
        inputs = tuple(replace(c, samples=own[c.quantity]) for c in command.channels)
        command = command.driven_by(inputs, data.sample_rate_hz, start_s)
    return replace(
        record,
        name=name,
        data=part,
        command=command,
        burn_in_s=record.burn_in_s if k == 0 else 0.0,
        parameters=tuple(_rename_parameter(q, name) for q in record.parameters),
    )


def _part(series: Series, first: int, stop: int) -> Series:
    """Return part of a series, in memory if it is short enough."""
    part = stretch_of(series, first, stop)
    return part if is_long(part.size) else np.ascontiguousarray(part[:])


def _rename_parameter(parameter: Parameter, record: str) -> Parameter:
    """Rename a per-record parameter for another record; a shared parameter keeps its name."""
    if parameter.name.startswith(f"{CAMPAIGN}."):
        return parameter
    return replace(parameter, name=record_parameter_name(record, key_in_record(parameter.name)))


def _refuse_same_names(entries: Entries) -> None:
    seen: dict[str, CampaignRecord] = {}
    for record, _, place in entries:
        if record.name in seen:
            raise place.key("name").error(f'"{record.name}" is also the name of a stretch; give it another one')
        seen[record.name] = record
