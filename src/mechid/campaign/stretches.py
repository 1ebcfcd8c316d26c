"""A record in stretches: each a record of its own, which begins where the one before it ends.

A motion that forgets its start, because it multiplies any difference, is followed for some time only, however good the
model. Stretches shorter than that are followed, each from a start of its own.
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
from mechid.signal.stored import is_long

KEY = "stretch_s"
LEAST = 64
"""Samples that a stretch has at least."""
Entries = list[tuple[CampaignRecord, Mapping[str, Any], Place]]
"""Records, each with its table in the campaign file and where that stands."""


def read_stretch(table: Mapping[str, Any], place: Place) -> float:
    """Return the length in s of the stretches in which a record is followed, 0 where it is followed as a whole."""
    if KEY not in table:
        return 0.0
    seconds = number(table[KEY], place.key(KEY), "s")
    if seconds <= 0.0:
        raise place.key(KEY).error(f"found {seconds:.9g}; write the length of a stretch in s, above 0")
    return seconds


def in_stretches(
    records: Sequence[CampaignRecord], entries: Sequence[Mapping[str, Any]], place: Place, *, staged: bool
) -> Entries:
    """Return the records with their tables, those that are to be followed in stretches cut into them.

    Stretch k of a record is ``<name>_<k>``, from 1 on. The first begins as the record does, the others in motion.

    Parameters
    ----------
    records : sequence of CampaignRecord
    entries : sequence of Mapping
        Their tables in the campaign file.
    place : Place
        Of that file.
    staged : bool
        Whether the file has stages, which name records.

    Raises
    ------
    InputFileError
        A stretch is too short, has the name of another record, or there are stages.
    """
    out: Entries = []
    for index, (record, entry) in enumerate(zip(records, entries, strict=True)):
        at = place.key("record").item(index)
        if not record.stretch_s or record.data is None:
            out.append((record, entry, at))
            continue
        if staged:
            raise at.key(KEY).error("stages name whole records; leave the stages out, or the stretches")
        out += [(one, _entry_of(one, entry), at) for one in _cut(record, record.data, at.key(KEY))]
    _refuse_same_names(out)
    return out


def _entry_of(stretch: CampaignRecord, entry: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return what a record's table says of a stretch: one that begins at rest has no states of its own."""
    return entry if stretch.command.start == ESTIMATED else {k: v for k, v in entry.items() if k != START_STATE}


def _cut(record: CampaignRecord, data: Record, place: Place) -> list[CampaignRecord]:
    count = max(math.ceil(min(data.duration_s / record.stretch_s, data.samples) - 1e-6), 1)
    if data.samples < count * LEAST:
        least = f"{LEAST / data.sample_rate_hz:.6g} s"
        raise place.error(f"found {record.stretch_s:.9g}; a stretch has {LEAST} samples at least, here {least}")
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
        parameters=tuple(_renamed(q, name) for q in record.parameters),
    )


def _part(series: Series, first: int, stop: int) -> Series:
    """Return a stretch of a series: in memory where it is short enough for that."""
    part = stretch_of(series, first, stop)
    return part if is_long(part.size) else np.ascontiguousarray(part[:])


def _renamed(parameter: Parameter, record: str) -> Parameter:
    """Return a record's own parameter as that of another record; one that all records share as it is."""
    if parameter.name.startswith(f"{CAMPAIGN}."):
        return parameter
    return replace(parameter, name=record_parameter_name(record, key_in_record(parameter.name)))


def _refuse_same_names(entries: Entries) -> None:
    seen: dict[str, CampaignRecord] = {}
    for record, _, place in entries:
        if record.name in seen:
            raise place.key("name").error(f'"{record.name}" is also the name of a stretch; give it another one')
        seen[record.name] = record
