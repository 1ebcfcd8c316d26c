"""Reader of the campaign file, which names the records, the mechanism and the stages."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from mechid.campaign.bench_entry import read_bench, with_data
from mechid.campaign.campaign import Campaign, CampaignRecord
from mechid.campaign.campaign_builder import KEYS, SYNTHETIC, Sources, build_campaign
from mechid.campaign.mechanism_file import load_mechanism
from mechid.campaign.place import Place, refuse_unknown_keys, required_entry, text
from mechid.campaign.record_entry import read_records as read_record_entries
from mechid.campaign.record_tables import merge_tables
from mechid.campaign.toml_file import read_toml
from mechid.campaign.unfinished_template import refuse_empty_commands
from mechid.errors import InputFileError
from mechid.plant.chopper import TABLE as CHOPPER
from mechid.plant.gear_mesh import TABLE as MESHES
from mechid.plant.mechanism import NamedLine
from mechid.reading.whole import is_file, is_folder
from mechid.records import Record, prepare_to_read, read_record

FILE_NAME = "campaign.toml"
TRUTH_NAME = "truth.json"
"""True values of synthetic records; a campaign file in the same folder counts as synthetic unless it says otherwise."""
MECHANISM_REMEDY = 'write the name of the mechanism file, as mechanism = "mechanism.toml"'


def load_campaign(
    path: Path | str,
    *,
    read_records: bool = True,
    need_files: bool | None = None,
    mechanism_file: Path | str | None = None,
) -> Campaign:
    """Load a campaign from its file, including the samples of its records.

    Parameters
    ----------
    path : Path
        The campaign file, or the folder that holds ``campaign.toml``.
    read_records : bool
        False skips the records' files and accepts records without a file, which is enough for planning.
    need_files : bool or None
        Whether every record needs a file; None requires one if records are read. A record without a file is
        planned: it can be checked, simulated and used in a test design.
    mechanism_file : Path, str or None
        Replaces the mechanism file named in the campaign file.

    Returns
    -------
    Campaign
        Mechanism, records with their samples in SI units, stages, options, and warnings about suspicious inputs.

    Raises
    ------
    InputFileError
        The campaign or mechanism file is missing or invalid.
    RecordError
        A record's file is missing or cannot be used.

    Examples
    --------
    >>> import mechid
    >>> mechid.load_campaign("bench").records[0].name  # doctest: +SKIP
    'full_46'
    """
    file = find_campaign_file(Path(path))
    table, place = read_toml(file, "campaign"), Place(file.name)
    refuse_unknown_keys(table, KEYS, place)
    mechanism_path = file.parent / _mechanism(table, place) if mechanism_file is None else Path(mechanism_file)
    # Before the mechanism is read, so that an unfinished template is reported in one message.
    refuse_empty_commands(table, place, mechanism_path)
    need_files = read_records if need_files is None else need_files
    sources = Sources(file.parent, lambda: load_mechanism(mechanism_path), _read, need_files, read_records)
    if SYNTHETIC not in table and is_synthetic(table, file):
        table = {**table, SYNTHETIC: True}
    return build_campaign(table, place, sources, path=file, mechanism_path=mechanism_path)


def load_records(path: Path | str) -> tuple[CampaignRecord, ...]:
    """Load the records of a campaign file without its mechanism, whose file may not exist yet.

    Parameters
    ----------
    path : Path
        The campaign file, or the folder that holds ``campaign.toml``.

    Raises
    ------
    InputFileError
        The campaign file is missing, or a record's table is invalid.
    RecordError
        A record's file is missing or cannot be used.
    """
    file = find_campaign_file(Path(path))
    table, place = read_toml(file, "campaign"), Place(file.name)
    refuse_unknown_keys(table, KEYS, place)
    table = merge_tables(table, place)
    records = read_record_entries(table, place, file.parent, need_files=True)
    bench = read_bench(table, place, records, file.parent)
    read = [with_data(one, read_record(one.file, one.spec), bench) for one in records if one.file]
    return tuple(_with_warnings(one, bench.warnings() if k == 0 else ()) for k, one in enumerate(read))


def load_phases(path: Path | str) -> int:
    """Load the number of phases of the motor of a campaign file's mechanism; 2 without the mechanism's file.

    Raises
    ------
    InputFileError
        The campaign file is missing or invalid.
    """
    file = find_campaign_file(Path(path))
    mechanism = read_toml(file, "campaign").get("mechanism")
    if not isinstance(mechanism, str) or not is_file(file.parent / mechanism):
        return 2
    stepper = read_toml(file.parent / mechanism, "mechanism").get("stepper")
    stated = stepper.get("phases", 2) if isinstance(stepper, Mapping) else 2
    return 3 if stated == 3 else 2


def load_named_lines(path: Path | str) -> tuple[NamedLine, ...]:
    """Load the lines that the mechanism of a campaign file names: those of its tooth meshes and of its chopper's clock.

    None if the mechanism's file does not exist yet; it is read only if it states one, since equations take seconds.

    Raises
    ------
    InputFileError
        The campaign file is missing or invalid, or the mechanism file that states such a line is.
    """
    file = find_campaign_file(Path(path))
    mechanism = read_toml(file, "campaign").get("mechanism")
    if not isinstance(mechanism, str) or not is_file(file.parent / mechanism):
        return ()
    read = read_toml(file.parent / mechanism, "mechanism")
    parts = (name.split(".") for name in (MESHES, CHOPPER))
    stated = any(isinstance(read.get(table), Mapping) and key in read[table] for table, key in parts)
    return load_mechanism(file.parent / mechanism).named_lines if stated else ()


def _with_warnings(record: CampaignRecord, warnings: Iterable[str]) -> CampaignRecord:
    assert record.data is not None
    return replace(record, data=replace(record.data, warnings=(*record.data.warnings, *warnings)))


def find_campaign_file(path: Path) -> Path:
    """Return the campaign file that a path names, or that lies in the folder that it names.

    Raises
    ------
    InputFileError
        The folder holds none.
    """
    if not is_folder(path):
        return path
    if not is_file(path / FILE_NAME):
        raise InputFileError(f'{path}: no {FILE_NAME} in this folder; "mechid new {path}" writes one')
    return path / FILE_NAME


def is_synthetic(table: Mapping[str, Any], file: Path) -> bool:
    """Whether a campaign file says that its records were simulated, or has the values beside it that made them."""
    return bool(table[SYNTHETIC]) if SYNTHETIC in table else is_file(file.parent / TRUTH_NAME)


def _mechanism(table: Mapping[str, Any], place: Place) -> str:
    entry = required_entry(table, "mechanism", place, MECHANISM_REMEDY)
    return text(entry, place.key("mechanism"), MECHANISM_REMEDY)


def _read(records: Sequence[CampaignRecord]) -> Iterator[Record | None]:
    """Yield the samples of each record, None for records without a file."""
    # The reading process starts now, with the libraries of all files, and is ready when the first file is opened.
    prepare_to_read(record.file for record in records if record.file)
    for record in records:
        yield read_record(record.file, record.spec) if record.file else None
