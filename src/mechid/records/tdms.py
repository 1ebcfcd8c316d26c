"""Reader of National Instruments' TDMS files by npTDMS: metadata first, channels on demand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mechid.errors import RecordError
from mechid.records.arrays import ArrayTable, Index, Item, array_table, fact
from mechid.records.clock import round_rate
from mechid.records.table import Clock, Column, Fact
from mechid.records.tdms_segments import Part, first_start, parts_fault, read_parts
from mechid.records.third_party import import_library, wrap_parser_errors

KIND = "a TDMS file"
SCALES_KNOWN = (
    "Polynomial",
    "Linear",
    "RTD",
    "Strain",
    "Table",
    "Thermistor",
    "Thermocouple",
    "Add",
    "Subtract",
    "AdvancedAPI",
)
"""Scalings that npTDMS applies; for any other one it would silently return raw counts."""
NO_DATE = np.datetime64("1904-01-02")
"""Earliest valid start time; TDMS counts from 1904, so an earlier value means that there is none."""
WAVEFORM = "wf_"


def open_tdms(path: Path, label: str) -> ArrayTable:
    """Read the header of the TDMS file at `path`; a channel's path is ``group/channel``.

    The clock is taken from the waveform properties, the unit from ``unit_string``; all other properties are metadata.
    Scalings are applied. A channel whose segments differ in unit, rate or scaling, or are not contiguous in time, has a
    fault that names both values.

    Raises
    ------
    RecordError
        The file is damaged, or its last segment is incomplete.
    """
    nptdms = import_library("nptdms", "npTDMS", label)
    with wrap_parser_errors(label, KIND), path.open("rb") as opened, nptdms.TdmsFile.open(opened) as file:
        _refuse_truncated(file, path, label)
        opened.seek(0)
        parts = read_parts(opened, label) if len(file._reader._segments) > 1 else {}
        items = []
        for group in file.groups():
            levels = (group.properties, file.properties)
            items += [_item(nptdms, path, c, levels, parts.get(c.path, ())) for c in group.channels()]
        metadata = _facts(file.properties)
        for group in file.groups():
            metadata |= {f"{group.name}/{key}": value for key, value in _facts(group.properties).items()}
    return array_table(label, KIND, items, metadata, is_sliced=True)


def _refuse_truncated(file: Any, path: Path, label: str) -> None:
    """Raise an error for a truncated file, which npTDMS would read with no more than a log message."""
    # There is no public attribute for the end of the last segment.
    segments = file._reader._segments
    end = segments[-1].next_segment_pos if segments else 0
    if file.file_status.incomplete_final_segment or end != path.stat().st_size:
        raise RecordError(f"{label}: its last segment is not whole: the recording was cut off; write or copy it anew")


def _item(nptdms: Any, path: Path, channel: Any, levels: Sequence[Mapping[str, Any]], parts: Sequence[Part]) -> Item:
    """Return the item of a channel; `levels` are the properties of its group and of the file."""
    properties, group, name = first_start(parts, channel.properties), channel.group_name, channel.name
    attributes = _facts({key: value for key, value in properties.items() if not key.startswith(WAVEFORM)})
    unit = attributes.pop("unit_string", None)
    column = Column(
        name=name,
        path=f"{group}/{name}",
        unit=str(unit) if unit else None,
        clock=_clock(properties),
        start_time=_start_time(properties),
        fault=_scaling_fault((properties, *levels)) or parts_fault(parts),
        metadata=attributes,
    )

    def load(index: Index) -> Any:
        (rows,) = index
        with path.open("rb") as opened, nptdms.TdmsFile.open(opened) as file:
            return file[group][name][rows]

    shape, dtype = (len(channel),), np.dtype(channel.dtype)
    return Item(column=column, shape=shape, dtype=dtype, load=load, attributes=attributes)


def _clock(properties: Mapping[str, Any]) -> Clock | None:
    """Return the clock of a waveform, or None if the channel is not a waveform."""
    interval = float(properties.get("wf_increment", 0.0))
    if not 0.0 < interval < np.inf or 1.0 / interval == np.inf:
        return None
    return Clock(float(properties.get("wf_start_offset", 0.0)), round_rate(1.0 / interval))


def _start_time(properties: Mapping[str, Any]) -> str | None:
    start = properties.get("wf_start_time")
    return str(start) if isinstance(start, np.datetime64) and start >= NO_DATE else None


def _scaling_fault(levels: Sequence[Mapping[str, Any]]) -> str | None:
    """Return the reason why a channel's scaling cannot be applied, or None."""
    # npTDMS applies the scaling of the first level that states one: channel, group or file.
    properties = next((level for level in levels if level.get("NI_Number_Of_Scales")), levels[0])
    if properties.get("NI_Scaling_Status") == "scaled":
        return None
    kinds = [str(value) for key, value in properties.items() if key.endswith("_Scale_Type")]
    unknown = [kind for kind in kinds if kind not in SCALES_KNOWN]
    return f'its scaling "{unknown[0]}" is unknown; export it scaled' if unknown else None


def _facts(properties: Mapping[str, Any]) -> dict[str, Fact]:
    found = {str(key): fact(value) for key, value in properties.items()}
    return {key: value for key, value in found.items() if value is not None}
