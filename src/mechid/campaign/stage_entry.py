"""``[[stage]]`` tables of a campaign file: stages of the search chosen by the user."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from mechid.campaign.campaign import CampaignRecord, Stage, parameters_of
from mechid.campaign.place import Place, describe_entry, number, refuse_unknown_keys, required_entry, tables, texts
from mechid.errors import did_you_mean
from mechid.parameter import Parameter, Status
from mechid.plant.mechanism import Mechanism

KEYS = ("records", "window_s", "free")
RECORDS_REMEDY = 'write names of records, as records = ["full_46"]'
FREE_REMEDY = 'write names of parameters to move, as free = ["gear.stiffness"]'
WINDOW_REMEDY = "write from and to in s of record time, as window_s = [0.0, 0.3]"


@dataclass(frozen=True)
class _Known:
    """Records and parameters that a stage can name."""

    records: Mapping[str, CampaignRecord]
    parameters: Mapping[str, Parameter]


def read_stages(
    table: Mapping[str, Any], place: Place, mechanism: Mechanism, records: tuple[CampaignRecord, ...]
) -> tuple[Stage, ...]:
    """Read the stages of a campaign file; empty if mechid plans them.

    Windows are checked against the records' data if these were read.

    Raises
    ------
    InputFileError
        A stage names an unknown record, or an unknown or fixed parameter, or its window is empty.
    """
    known = _Known({r.name: r for r in records}, parameters_of(mechanism, records))
    return tuple(_stage(entry, at, known) for entry, at in tables(table, "stage", place))


def _stage(table: Mapping[str, Any], place: Place, known: _Known) -> Stage:
    refuse_unknown_keys(table, KEYS, place)
    records = _records(table, place.key("records"), known)
    free = texts(required_entry(table, "free", place, FREE_REMEDY), place.key("free"), FREE_REMEDY)
    for index, name in enumerate(free):
        _refuse_not_free(name, records, known, place.key("free").item(index))
    window = _window(table["window_s"], place.key("window_s")) if "window_s" in table else None
    if window:
        _refuse_outside(window, [known.records[name] for name in records], place.key("window_s"))
    return Stage(records, window, free)


def _records(table: Mapping[str, Any], place: Place, known: _Known) -> tuple[str, ...]:
    """Read the records of a stage; by default all records that are fitted."""
    if "records" not in table:
        return tuple(name for name, record in known.records.items() if record.use == "estimate")
    names = texts(table["records"], place, RECORDS_REMEDY)
    for index, name in enumerate(names):
        at = place.item(index)
        if name not in known.records:
            near = did_you_mean(name, known.records) or f"; there are {', '.join(known.records)}"
            raise at.error(f'unknown record "{name}"{near}')
        if known.records[name].use != "estimate":
            raise at.error(f'"{name}" is for validation; take it out, or give that record use = "estimate"')
    return names


def _refuse_not_free(name: str, records: tuple[str, ...], known: _Known, place: Place) -> None:
    free = [other for other, q in known.parameters.items() if q.is_free]
    if name not in known.parameters:
        near = did_you_mean(name, known.parameters) or f"; free are: {', '.join(free) or 'none'}"
        raise place.error(f'unknown parameter "{name}"{near}')
    parameter = known.parameters[name]
    if parameter.status is Status.TIED:
        raise place.error(f'"{name}" is tied to {parameter.tied_to}; free that one, or give it a value of its own')
    if not parameter.is_free:
        remedy = "to free it, write { value = ..., min = ..., max = ... } there"
        raise place.error(f'"{name}" is known, not free; {remedy}, or take it out')
    # A parameter of a record cannot be estimated from the others.
    owner = name.split(".")[1] if name.startswith("record.") else None
    if owner is not None and owner not in records:
        raise place.error(f'"{name}" belongs to a record that is not in this stage; add "{owner}" to its records')


def _window(entry: Any, place: Place) -> tuple[float, float]:
    if not isinstance(entry, list) or len(entry) != 2:
        raise place.error(f"{describe_entry(entry)}; {WINDOW_REMEDY}")
    start, end = (number(value, place.item(index), "s") for index, value in enumerate(entry))
    if start >= end:
        raise place.error(f"from {start:.9g} s to {end:.9g} s is no window; put the earlier time first")
    return start, end


def _refuse_outside(window: tuple[float, float], records: list[CampaignRecord], place: Place) -> None:
    """Refuse a window that contains no sample of one of the records."""
    for record in records:
        data = record.data
        if data is None:
            continue
        first, last = data.time_start_s, data.time_start_s + data.duration_s
        if window[1] < first or window[0] > last:
            span = f'record "{record.name}" goes from {first:.9g} s to {last:.9g} s'
            raise place.error(f"{window[0]:.9g} s to {window[1]:.9g} s is outside; {span}")
