"""Estimated start of a record, with its initial states as per-record parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from mechid.campaign.campaign import START, CampaignRecord, record_parameter_name
from mechid.campaign.parameter_entry import read_parameter
from mechid.campaign.place import Place, describe_entry, number, refuse_unknown_keys
from mechid.command import MeasuredCommand, Timing
from mechid.command.entry import is_table
from mechid.command.stepping import Start
from mechid.parameter import Declaration, Parameter, Status
from mechid.plant.mechanism import Mechanism

KEY, BURN_IN = "start_state", "burn_in_s"
ESTIMATED: Start = "estimated"
EXAMPLE = "{ rate = { value = 0.0, min = -2.0, max = 2.0 }, current_a = 0.0 }"
SIGMA_SHARE = 0.5
"""Standard deviation of the default prior of an initial state, relative to its typical size."""
RATE = f"{START}.rate"


def with_starts(
    records: Sequence[CampaignRecord],
    entries: Sequence[Mapping[str, Any]],
    places: Sequence[Place],
    mechanism: Mechanism,
) -> tuple[CampaignRecord, ...]:
    """Add the initial states to the parameters of records with an estimated start.

    If the command begins before the first sample, the record starts in motion at the commanded rate.

    Parameters
    ----------
    records : sequence of CampaignRecord
    entries : sequence of Mapping
        Their tables in the campaign file.
    places : sequence of Place
        Places of the tables.
    mechanism : Mechanism

    Raises
    ------
    InputFileError
        A state is unknown to the mechanism, its value or bounds are impossible, or the start is not estimated; or the
        burn-in covers the whole record.
    """
    for record, at in zip(records, places, strict=True):
        _refuse_whole_burn_in(record, at.key(BURN_IN))
    return tuple(
        _with_start(record, entry.get(KEY), mechanism, at.key(KEY))
        for record, entry, at in zip(records, entries, places, strict=True)
    )


def read_burn_in(table: Mapping[str, Any], place: Place) -> float:
    """Read the initial time in s that is simulated but excluded from the fit."""
    seconds = number(table.get(BURN_IN, 0.0), place.key(BURN_IN), "s")
    if seconds < 0.0:
        raise place.key(BURN_IN).error(f"found {seconds:.9g}; write a time of 0 s or more")
    return seconds


def _refuse_whole_burn_in(record: CampaignRecord, place: Place) -> None:
    if record.data is not None and record.burn_in_s >= record.data.duration_s:
        raise place.error(
            f"found {record.burn_in_s:.9g}, but the record lasts {record.data.duration_s:.9g} s; write a shorter time"
        )


def _with_start(record: CampaignRecord, entry: Any, mechanism: Mechanism, place: Place) -> CampaignRecord:
    # Applied twice, before and after the cut into stretches: earlier initial states are replaced.
    others = tuple(q for q in record.parameters if q not in record.start)
    if record.command.start != ESTIMATED:
        if entry is not None:
            raise place.error(f'there is no estimated start; write start = "{ESTIMATED}" in command')
        return record
    if entry is not None and not is_table(entry):
        raise place.error(f"{describe_entry(entry)}; write a table, as {EXAMPLE}")
    record = _begin_in_motion(record)
    declared = mechanism.plant.starts
    keys = {name.removeprefix(f"{START}."): name for name in declared}
    given = entry or {}
    refuse_unknown_keys(given, tuple(keys), place)
    full_step = 2.0 * math.pi / mechanism.full_steps / (mechanism.electrical_periods or math.inf)
    own = []
    for key, name in keys.items():
        full = record_parameter_name(record.name, name)
        if key in given:
            own.append(read_parameter(given[key], full, declared[name], place.key(key)))
        else:
            value = record.command.start_rate * full_step if name == RATE else 0.0
            own.append(_default_state(value, full, declared[name], mechanism.size(declared[name])))
    if not any(q.is_free for q in own):
        raise place.error(f"nothing says how far the start may be off; give the states to be estimated, as {EXAMPLE}")
    return replace(record, parameters=(*others, *own))


def _begin_in_motion(record: CampaignRecord) -> CampaignRecord:
    """Start the command of a record at its first sample, if it is in motion there."""
    if record.data is None or isinstance(record.command, MeasuredCommand):
        return record
    offset, clock = record.time_offset, record.clock
    # The latest offset and the slowest clock give the earliest command time, which covers every start the fit can try.
    latest_s = offset.max if offset.is_free else offset.value
    slowest_ppm = 0.0 if clock is None else clock.min if clock.is_free else clock.value
    earliest = Timing(latest_s, slowest_ppm)
    return replace(record, command=record.command.begin_at(earliest.command_s(record.data.time_start_s)))


def _default_state(value: float, name: str, declaration: Declaration, size: float | None) -> Parameter:
    """Return a free initial state with a default prior; a known one if its typical size is unknown."""
    if size is None or declaration.typical is None:
        return Parameter(name=name, value=value, declaration=declaration)
    _, least, most = declaration.typical
    return Parameter(
        name=name,
        value=value,
        declaration=declaration,
        min=value + least * size,
        max=value + most * size,
        sigma=SIGMA_SHARE * size,
        status=Status.FREE,
    )
