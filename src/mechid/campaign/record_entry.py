"""Reader of ``[[record]]`` tables of a campaign file: file, channels, command and per-record parameters."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

from mechid.campaign.calibration_entry import reads_volts
from mechid.campaign.campaign import INSTANTS, TIME_OFFSET, USES, CampaignRecord, record_parameter_name
from mechid.campaign.channel_entry import TORQUE, read_channels, read_matches, read_time
from mechid.campaign.conditioning_entry import read_conditioning
from mechid.campaign.parameter_entry import read_parameter
from mechid.campaign.place import (
    Place,
    describe_entry,
    flag,
    number,
    one_of,
    refuse_unknown_keys,
    required_entry,
    tables,
    text,
    texts,
)
from mechid.campaign.start_entry import BURN_IN, read_burn_in
from mechid.campaign.start_entry import KEY as START_STATE
from mechid.campaign.stretches import KEY as STRETCH
from mechid.campaign.stretches import read_stretch
from mechid.command import Command, MeasuredCommand
from mechid.command.entry import is_table
from mechid.command.stepping import STARTS, Start
from mechid.errors import InputFileError, UsageError
from mechid.parameter import Declaration, Parameter
from mechid.plant.tables import MOTOR_OF_RECORD
from mechid.records import RecordSpec, Role

NAME = re.compile(r"[A-Za-z0-9_-]+")
OWN_KEYS = (*(declaration.key for declaration in INSTANTS), *MOTOR_OF_RECORD)
EXTERNAL_FILES = "external_files"
FILE_KEYS = (EXTERNAL_FILES, "sample_rate_hz", "time", "channels", "conditioning")
BEGIN_KEYS = (START_STATE, BURN_IN, STRETCH)
KEYS = ("name", "file", "use", "command", *FILE_KEYS, "offset", "drift", "test_stand", *BEGIN_KEYS, *OWN_KEYS)
TOP_KEYS = ("mechanism", "identify", "stage")
EXTERNAL_REMEDY = 'write the names as they stand in the file, as external_files = ["part_1.h5"]'
COMMAND_FILES = ("step_times", "table")
"""Entries of a command that may name a file whose digest a fit keeps; those of rate tables are not in older fits."""
START_KEYS = ("start_angle_deg", "start")
COMMAND_REMEDY = 'write how the motor was driven, as command = { stepping = "full", rate = 46.0 }'

# The time before a record is simulated too: 2e8 samples at 10 kHz. The upper limit admits times since year 0.
LEAST_OFFSET_S, LARGEST_OFFSET_S = -2e4, 1e11
"""Limits of a time offset in s."""


def read_records(
    table: Mapping[str, Any], place: Place, folder: Path, *, need_files: bool
) -> tuple[CampaignRecord, ...]:
    """Read the records of a campaign file, without their samples.

    Parameters
    ----------
    table : Mapping
        Content of the campaign file.
    place : Place
        Place of the file.
    folder : Path
        Base of relative paths.
    need_files : bool
        Whether a record without a file is refused.

    Raises
    ------
    InputFileError
        There is no record, or one is invalid.
    """
    entries = tables(table, "record", place)
    if not entries:
        raise place.error("no record; write one [[record]] table for each measured file")
    in_volts = reads_volts(table)
    records = tuple(_record(entry, at, folder, need_file=need_files, in_volts=in_volts) for entry, at in entries)
    _refuse_same_names(records, [at for _, at in entries])
    return records


def _record(table: Mapping[str, Any], place: Place, folder: Path, *, need_file: bool, in_volts: bool) -> CampaignRecord:
    _refuse_unknown(table, place)
    name = _name(required_entry(table, "name", place, 'write a name, as name = "full_46"'), place.key("name"))
    file = _file(table, place, needed=need_file)
    spec = _spec(table, name, (file or "", in_volts), place)
    if file is None and any(channel.role is Role.INPUT for channel in spec.channels):
        raise place.key("file").error('missing; channels of role = "input" drive the record, name the file they are in')
    use = one_of(table.get("use", "estimate"), USES, place.key("use"))
    projections = {key: flag(table[key], place.key(key)) for key in ("offset", "drift") if key in table}
    return CampaignRecord(
        name=name,
        use="estimate" if use == "estimate" else "validate",
        command=_command(table, spec, place, folder),
        command_files=_command_files(table.get("command"), folder),
        spec=spec,
        file=folder / file if file else None,
        matches=read_matches(table.get("channels"), place.key("channels"), own=projections),
        parameters=(_time_offset(table, name, place),),
        burn_in_s=read_burn_in(table, place),
        stretch_s=read_stretch(table, place),
    )


def _command(table: Mapping[str, Any], spec: RecordSpec, place: Place, folder: Path) -> Command:
    """Read the step command; if measured channels drive the record, only the settings of its start."""
    if all(channel.role is not Role.INPUT for channel in spec.channels):
        entry = required_entry(table, "command", place, COMMAND_REMEDY)
        if isinstance(entry, Command):
            return entry
        return Command.from_table(entry, str(place.key("command")), folder)
    entry, at = table.get("command", {}), place.key("command")
    if not is_table(entry):
        raise at.error(f"{describe_entry(entry)}; write a table, as {{ start_angle_deg = 45.0 }}, or leave it out")
    for key in entry:
        if key not in START_KEYS:
            inputs = ", ".join(c.quantity for c in spec.channels if c.role is Role.INPUT)
            raise at.key(key).error(f'the record is driven by its channels of role = "input" ({inputs}); leave one out')
    start = one_of(entry.get("start", STARTS[0]), STARTS, at.key("start"))
    angle = number(entry.get("start_angle_deg", 0.0), at.key("start_angle_deg"), "deg")
    try:
        return MeasuredCommand(start_angle_deg=angle, start=cast(Start, start))
    except UsageError as error:
        raise InputFileError(f"{at}.{error}") from error


def _command_files(entry: Any, folder: Path) -> tuple[Path, ...]:
    """Return the files that a step command names, which it has read."""
    found = (entry.get(key) for key in COMMAND_FILES) if is_table(entry) else ()
    return tuple(folder / name for name in found if isinstance(name, str))


def _refuse_unknown(table: Mapping[str, Any], place: Place) -> None:
    """Refuse unknown keys; a key of the whole file belongs to the record if written below a ``[[record]]``."""
    for key in TOP_KEYS:
        if key in table:
            raise place.key(key).error(f"{key} is no key of a record; write it above the first [[record]]")
    refuse_unknown_keys(table, KEYS, place)


def _name(entry: Any, place: Place) -> str:
    remedy = "write letters, digits, _ and - only: it becomes a file name"
    name = text(entry, place, remedy)
    if not NAME.fullmatch(name):
        raise place.error(f"{describe_entry(name)}; {remedy}")
    return name


def _file(table: Mapping[str, Any], place: Place, *, needed: bool) -> str | None:
    if "file" in table or needed:
        remedy = 'write the name of the measured file, as file = "full_46.csv"'
        return text(required_entry(table, "file", place, remedy), place.key("file"), remedy)
    return None


def _spec(table: Mapping[str, Any], name: str, source: tuple[str, bool], place: Place) -> RecordSpec:
    """Return the declaration of a record; `source` is its file, and whether its loads are in volts."""
    file, in_volts = source
    channels = read_channels(table.get("channels"), place.key("channels"), in_volts=in_volts)
    quantities = [channel.quantity for channel in channels] or [TORQUE]
    return RecordSpec(
        name=name,
        path=file,
        sample_rate_hz=_rate(table, place.key("sample_rate_hz")),
        channels=channels,
        time=read_time(table.get("time"), place.key("time")),
        external_files=_external_files(table, place.key(EXTERNAL_FILES)),
        conditioning=read_conditioning(table.get("conditioning"), place.key("conditioning"), quantities),
    )


def _external_files(table: Mapping[str, Any], place: Place) -> tuple[str, ...]:
    return texts(table[EXTERNAL_FILES], place, EXTERNAL_REMEDY) if EXTERNAL_FILES in table else ()


def _rate(table: Mapping[str, Any], place: Place) -> float | None:
    if "sample_rate_hz" not in table:
        return None
    rate = number(table["sample_rate_hz"], place, "Hz")
    if rate <= 0.0:
        raise place.error(f"found {rate:.9g}; write the samples per second, above 0")
    return rate


def _time_offset(table: Mapping[str, Any], name: str, place: Place) -> Parameter:
    """Read the start of the command; refuse impossible clock times, and offsets that take hours to simulate."""
    own = _own_parameter(table, name, TIME_OFFSET, place)
    if not LEAST_OFFSET_S <= own.value <= LARGEST_OFFSET_S:
        raise place.key(TIME_OFFSET.key).error(
            f"found {own.value:.9g}; write seconds of the record's clock, from {LEAST_OFFSET_S:g} to "
            f"{LARGEST_OFFSET_S:g}; where the command began earlier, give its rate from a later instant on"
        )
    return own


def _own_parameter(table: Mapping[str, Any], record: str, declaration: Declaration, place: Place) -> Parameter:
    entry = table.get(declaration.key, declaration.default)
    name = record_parameter_name(record, declaration.key)
    return read_parameter(entry, name, declaration, place.key(declaration.key))


def _refuse_same_names(records: tuple[CampaignRecord, ...], places: list[Place]) -> None:
    """Refuse equal names, also those that differ only in case."""
    seen: dict[str, int] = {}
    for index, record in enumerate(records):
        # Some file systems ignore case, and names become file names.
        earlier = seen.setdefault(record.name.casefold(), index)
        if earlier != index:
            how = "also" if records[earlier].name == record.name else "but for capitals"
            raise (
                places[index]
                .key("name")
                .error(f'"{record.name}" is {how} the name of record[{earlier}]; give each record its own')
            )
