"""Campaigns made in code: mechanism, commands and records from values and arrays, without files."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mechid.campaign.campaign import Campaign, CampaignRecord, InCode, Use
from mechid.campaign.campaign_builder import KEYS, Sources, build_campaign
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.campaign.place import Place, refuse_unknown_keys
from mechid.campaign.record_entry import read_records
from mechid.command import Command
from mechid.errors import RecordError, UsageError
from mechid.plant.mechanism import Mechanism
from mechid.records import Record
from mechid.records.in_memory import TIME, SampleColumns, columns_of, record_of
from mechid.units import SI_UNIT

NOT_HERE = ("mechanism", "record")
"""Keys of a campaign file that are arguments of `make_campaign`."""
NOT_IN_ENTRIES = ("name", "file", "use", "command", "sample_rate_hz", "channels")
"""Keys of a record that are arguments of `make_record`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RecordEntry:
    """One test run with its samples in memory, not yet part of a campaign; made by `make_record`.

    Parameters
    ----------
    name : str
        Letters, digits, ``_`` and ``-``.
    table : mapping
        Content of the equivalent ``[[record]]`` of campaign.toml.
    samples : SampleColumns or None
        None for a planned record, which has not been measured.
    """

    name: str
    table: Mapping[str, Any]
    samples: SampleColumns | None


def make_mechanism(table: Mapping[str, Any], *, name: str = "mechanism") -> Mechanism:
    """Make a mechanism from the tables of a mechanism file.

    Parameters
    ----------
    table : mapping
        Tables and keys as in docs/files.md, in the plant's units (SI; degrees if a key ends in ``_deg``). A number is
        a known value; ``{"value": ..., "min": ..., "max": ...}`` is estimated, with a prior if it has ``"sigma"``.
        Lists of tables (``[[stepper.detent]]``) are lists of mappings.
    name : str
        Name used in messages.

    Returns
    -------
    Mechanism

    Raises
    ------
    InputFileError
        A key is unknown or missing, or a value is impossible; the message names the place, as for a file.

    Examples
    --------
    >>> import mechid
    >>> drive = mechid.make_mechanism(
    ...     {
    ...         "assembly": "direct_torque_drive",
    ...         "load": {"inertia": {"value": 0.1, "min": 0.01, "max": 1.0}},
    ...         "friction": {"static": 0.02, "coulomb": 0.02, "viscous": 0.001},
    ...     }
    ... )
    >>> [parameter.name for parameter in drive.free]
    ['load.inertia']
    """
    return mechanism_from_table(plain(table), name)


def make_command(  # noqa: PLR0913 - a command has these entries
    stepping: str,
    *,
    rate: float | ArrayLike | None = None,
    step_times: ArrayLike | None = None,
    microsteps: int | None = None,
    start_angle_deg: float = 0.0,
    waveform: str = "cosine",
    table: ArrayLike | str | Path | None = None,
    start: str = "commanded",
    clock_tick_s: float = 0.0,
) -> Command:
    """Make the step command of a stepper motor.

    Parameters
    ----------
    stepping : {"full", "half", "micro"}
    rate : float, (B, 2) array or None
        Full steps/s; or breakpoints of command time in s and full steps/s, interpolated linearly and held outside.
    step_times : (E,) or (E, 2) array
        In place of a rate: the instants of the steps in s, one step each, with 1 or -1 in the second column if the
        direction changes.
    microsteps : int or None
        Microsteps per full step; required for micro stepping only.
    start_angle_deg : float
        Electrical angle in deg held by the coils until the first step.
    waveform : {"cosine", "square"}
    table : (4 n, 2) array, path or None
        Driver's table in place of the waveform, with micro stepping of n: the values of both phases at each microstep
        of an electrical period from angle 0 on, fractions of the peak (-1 and 0 there with a cosine); or its CSV file.
    start : {"commanded", "equilibrium", "estimated"}
    clock_tick_s : float
        Period in s of the driver's step clock; 0 for steps at their exact instants.

    Raises
    ------
    UsageError
        A value is impossible.

    Examples
    --------
    >>> import mechid
    >>> sweep = mechid.make_command("micro", microsteps=16, rate=[[0.0, 0.0], [60.0, 120.0]])
    >>> sweep.rate.at(30.0)
    60.0
    """
    given = {
        "stepping": stepping,
        "start_angle_deg": start_angle_deg,
        "waveform": waveform,
        "start": start,
        "clock_tick_s": clock_tick_s,
    } | ({} if microsteps is None else {"microsteps": microsteps})
    if table is not None:
        is_path = isinstance(table, str | Path)
        given["table"] = str(table) if is_path else plain(np.asarray(table).tolist())
    if step_times is not None:
        given["step_times"] = plain(np.asarray(step_times).tolist())
    if rate is not None:
        found = plain(np.asarray(rate).tolist())
        given["rate_profile" if isinstance(found, list) else "rate"] = found
    return Command.from_entries(given)


def make_record(
    name: str,
    samples: object = None,
    *,
    command: Command | Mapping[str, Any] | None = None,
    time_s: ArrayLike | None = None,
    sample_rate_hz: float | None = None,
    channels: Sequence[Mapping[str, Any]] = (),
    use: Use = "estimate",
    entries: Mapping[str, Any] | None = None,
) -> RecordEntry:
    """Make a record from samples in memory, for `make_campaign`.

    Parameters
    ----------
    name : str
        Letters, digits, ``_`` and ``-``; also used as a file name.
    samples : (n,) array, mapping of str to (n,) array, pandas or xarray object, or None
        The torque in N m; or series by name, in SI units or in the unit at the end of the name (``"torque_mNm"``).
        The index of a pandas object and the dimension coordinate of an xarray object are the time in s; the attribute
        ``units`` of an xarray variable is respected. None makes a planned record.
    command : Command, mapping or None
        Command of `make_command`, or the content of a ``command`` table; None if measured channels drive the record.
    time_s : (n,) array or None
        Record time in s, if the samples contain none.
    sample_rate_hz : float or None
        Replaces times, with the first sample at 0. Times in the samples have to agree with it.
    channels : sequence of mapping
        Quantity and unit of each series, as ``channels`` of a record in campaign.toml. Not needed for series named
        after a quantity (``"torque"``, ``"rotor_angle"``).
    use : {"estimate", "validate"}
    entries : mapping or None
        Further keys of a ``[[record]]``, as ``time_offset_s``, ``offset``, ``conditioning``, ``test_stand``.

    Returns
    -------
    RecordEntry

    Raises
    ------
    UsageError
        An entry is also an argument, or both times and a rate are given.
    RecordError
        The samples are not series.

    Examples
    --------
    >>> import mechid, numpy as np
    >>> torque = np.zeros(1000)
    >>> run = mechid.make_record(
    ...     "full_46", torque, sample_rate_hz=10_000.0, command=mechid.make_command("full", rate=46.0)
    ... )
    >>> run.name
    'full_46'
    """
    for key in entries or {}:
        if key in NOT_IN_ENTRIES:
            raise UsageError(f'record "{name}": entries: {key}: it is an argument of make_record; give it there')
    table: dict[str, Any] = {"name": name, "use": use} | plain(entries or {})
    if command is not None:
        table["command"] = command if isinstance(command, Command) else plain(command)
    if samples is None:
        return RecordEntry(name=name, table=table, samples=None)
    found = columns_of(samples, name)
    if time_s is not None:
        found = replace(found, arrays={**found.arrays, TIME: np.asarray(time_s)})
        if sample_rate_hz is not None:
            raise UsageError(f'record "{name}": time_s and sample_rate_hz are given; keep one of them')
    if sample_rate_hz is not None:
        table["sample_rate_hz"] = float(sample_rate_hz)
    # Series named after a quantity need no channel entry.
    known = [{"quantity": name, "column": name} for name in found.arrays if name in SI_UNIT and name != "time"]
    if chosen := (plain(channels) or known):
        table["channels"] = chosen
    return RecordEntry(name=name, table=table | {"file": name}, samples=found)


def make_campaign(
    mechanism: Mechanism,
    records: Iterable[RecordEntry] | RecordEntry,
    *,
    name: str = "campaign",
    entries: Mapping[str, Any] | None = None,
) -> Campaign:
    """Make a campaign from a mechanism and records in memory.

    Parameters
    ----------
    mechanism : Mechanism
        Mechanism of `make_mechanism`, `load_mechanism` or `catalogue_mechanism`.
    records : iterable of RecordEntry, or one
        Records of `make_record`; no files are needed.
    name : str
        Name used in reports and messages.
    entries : mapping or None
        Other content of campaign.toml: ``stage``, ``identify``, ``diagnose``, ``bench``, ``clock_ppm``,
        ``clock_reference``, ``article``, ``test``, ``instrument``.

    Returns
    -------
    Campaign
        Equal to a campaign of `load_campaign`, but without files; `write_campaign` writes them for use in commands.

    Raises
    ------
    InputFileError
        The inputs are inconsistent; the message names the place, as for a file.
    RecordError
        Samples are unusable.
    UsageError
        An argument has the wrong type.

    Examples
    --------
    >>> import mechid
    >>> command = mechid.make_command("full", rate=46.0, start_angle_deg=45.0)
    >>> planned = mechid.make_record("full_46", command=command)
    >>> campaign = mechid.make_campaign(mechid.catalogue_mechanism(), [planned])
    >>> [record.name for record in campaign.records]
    ['full_46']
    """
    # A tuple, since a generator could be iterated only once.
    records = (records,) if isinstance(records, RecordEntry) else tuple(records)
    _refuse_other("mechanism", [mechanism], Mechanism, "make_mechanism returns")
    _refuse_other("records", records, RecordEntry, "make_record returns, in a list")
    place = Place(name)
    whole = plain(entries or {})
    refuse_unknown_keys(whole, [key for key in KEYS if key not in NOT_HERE], place)
    table = whole | {"record": [dict(record.table) for record in records]}
    held = {record.name: record.samples for record in records}

    def samples(wanted: Sequence[CampaignRecord]) -> Iterator[Record | None]:
        for record in wanted:
            columns = held[record.name]
            yield None if columns is None else record_of(columns, record.spec)

    sources = Sources(Path(), lambda: mechanism, samples, need_files=False)
    made = build_campaign(table, place, sources, path=Path(name) / "campaign", mechanism_path=Path(name) / "mechanism")
    source = InCode(entries=table, samples={name: columns for name, columns in held.items() if columns is not None})
    return replace(made, records=tuple(replace(record, file=None) for record in made.records), source=source)


def _refuse_other(argument: str, found: Iterable[object], kind: type, give: str) -> None:
    """Raise UsageError at the first object of another type, as a path instead of its content."""
    for one in found:
        if not isinstance(one, kind):
            raise UsageError(f"make_campaign: {argument}: found {type(one).__name__}; give what {give}")


def read_single_record(entry: RecordEntry) -> tuple[Record, Command | None]:
    """Return the checked samples of a single record, and its command if it has one.

    Raises
    ------
    InputFileError
        An entry is invalid.
    RecordError
        The record is planned, or its samples are unusable.
    """
    if entry.samples is None:
        raise RecordError(f'record "{entry.name}": it is planned and has no samples')
    # Without a command, one at rest is inserted only to pass the checks; it is not returned.
    commanded = "command" in entry.table
    table = {"record": [dict(entry.table) | ({} if commanded else {"command": {"stepping": "full", "rate": 0.0}})]}
    (record,) = read_records(table, Place(entry.name), Path(), need_files=False)
    return record_of(entry.samples, record.spec), record.command if commanded else None


def plain(value: Any) -> Any:
    """Convert tables, arrays and NumPy scalars to the plain types of a TOML file."""
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    return [plain(entry) for entry in value] if isinstance(value, list | tuple) else value
