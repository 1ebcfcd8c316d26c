"""The campaign file: it names records, mechanism and stages, and they are read and joined here."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from mechid.campaign.bench_entry import KEY as BENCH
from mechid.campaign.bench_entry import read_bench, with_data
from mechid.campaign.campaign import CAMPAIGN, CLOCK, Campaign, CampaignRecord
from mechid.campaign.diagnose_options import DIAGNOSE, read_considered
from mechid.campaign.identify_options import read_identify_options
from mechid.campaign.measured_input import joined, with_inputs
from mechid.campaign.mechanism_file import mechanism_warnings, read_mechanism
from mechid.campaign.not_filled_in import refuse_empty_commands
from mechid.campaign.own_values import with_own_values
from mechid.campaign.place import Place, refuse_unknown_keys, required, text
from mechid.campaign.record_entry import read_records as read_record_entries
from mechid.campaign.record_tables import OWN, gathered
from mechid.campaign.record_warnings import record_warnings, same_file_warnings
from mechid.campaign.stage_entry import read_stages
from mechid.campaign.start_entry import ESTIMATED, with_starts
from mechid.campaign.stretches import in_stretches
from mechid.campaign.timing_entry import with_clocks
from mechid.campaign.toml_file import read_toml
from mechid.errors import InputFileError
from mechid.plant.mechanism import Mechanism
from mechid.reading.whole import is_file, is_folder
from mechid.records import Mounting, prepare_to_read, read_record

FILE_NAME = "campaign.toml"
KEYS = ("mechanism", "identify", DIAGNOSE, CLOCK.key, BENCH, "record", "stage", CAMPAIGN, OWN)
MECHANISM_REMEDY = 'write the name of the mechanism file, as mechanism = "mechanism.toml"'


def load_campaign(
    path: Path | str, *, read_records: bool = True, need_files: bool | None = None, mechanism_file: Path | None = None
) -> Campaign:
    """Return the campaign that a file describes, its records read.

    Parameters
    ----------
    path : Path
        The campaign file, or the folder that holds ``campaign.toml``.
    read_records : bool
        False leaves the records' files unread, and lets records without a file pass: enough to plan.
    need_files : bool or None
        Whether a record without a file is refused; None refuses it where records are read. Without one it is
        planned: enough to check, to simulate and to design the test.
    mechanism_file : Path or None
        In place of the one that the campaign file names.

    Returns
    -------
    Campaign
        Mechanism, records with their samples in SI units, stages, options, and warnings about what is odd.

    Raises
    ------
    InputFileError
        The campaign or mechanism file is missing or wrong.
    RecordError
        A record's file is missing or cannot be used.
    """
    file = _campaign_file(Path(path))
    table, place = read_toml(file, "campaign"), Place(file.name)
    refuse_unknown_keys(table, KEYS, place)
    table = gathered(table, place)
    options, effects = read_identify_options(table, place), read_considered(table, place)
    mechanism_path = mechanism_file or file.parent / _mechanism(table, place)
    refuse_empty_commands(table, place, mechanism_path)
    need_files = read_records if need_files is None else need_files
    records = read_record_entries(table, place, file.parent, need_files=need_files)
    mounting = read_bench(table, place, records)
    if read_records:
        prepare_to_read(record.file for record in records if record.file)
    mechanism = read_mechanism(mechanism_path)
    mechanism, records = joined(mechanism, records, place)
    records = with_clocks(records, table, place)
    places = [place.key("record").item(index) for index in range(len(records))]
    records = with_own_values(records, table["record"], places, mechanism)
    records = with_starts(records, table["record"], places, mechanism)
    if read_records:
        read_stages(table, place, mechanism, records)  # before the files: they take their time
    read = (_with_data(r, mechanism, mounting) if read_records or _begins_anywhere(r) else r for r in records)
    cut = in_stretches(tuple(read), table["record"], place, staged="stage" in table)
    places = [at for _, _, at in cut]
    records = with_starts([record for record, _, _ in cut], [entry for _, entry, _ in cut], places, mechanism)
    return Campaign(
        path=file,
        mechanism_path=mechanism_path,
        mechanism=mechanism,
        records=records,
        mounting=mounting,
        stages=read_stages(table, place, mechanism, records),
        options=options,
        considered=effects,
        warnings=(*mechanism_warnings(mechanism, mechanism_path.name), *_warnings(records, places)),
    )


def load_records(path: Path | str) -> tuple[CampaignRecord, ...]:
    """Return the records that a campaign file names, read, without its mechanism, which need not be there yet.

    Parameters
    ----------
    path : Path
        The campaign file, or the folder that holds ``campaign.toml``.

    Raises
    ------
    InputFileError
        The campaign file is missing, or a record's table is wrong.
    RecordError
        A record's file is missing or cannot be used.
    """
    file = _campaign_file(Path(path))
    table, place = read_toml(file, "campaign"), Place(file.name)
    refuse_unknown_keys(table, KEYS, place)
    table = gathered(table, place)
    records = read_record_entries(table, place, file.parent, need_files=True)
    mounting = read_bench(table, place, records)
    return tuple(with_data(one, read_record(one.file, one.spec), mounting) for one in records if one.file)


def _campaign_file(path: Path) -> Path:
    if not is_folder(path):
        return path
    if not is_file(path / FILE_NAME):
        raise InputFileError(f'{path}: no {FILE_NAME} in this folder; "mechid new {path}" writes one')
    return path / FILE_NAME


def _mechanism(table: Mapping[str, Any], place: Place) -> str:
    entry = required(table, "mechanism", place, MECHANISM_REMEDY)
    return text(entry, place.key("mechanism"), MECHANISM_REMEDY)


def _with_data(record: CampaignRecord, mechanism: Mechanism, mounting: Mounting | None) -> CampaignRecord:
    if not record.file:
        return record
    data = read_record(record.file, record.spec)
    return with_inputs(with_data(record, data, mounting), data, mechanism)


def _begins_anywhere(record: CampaignRecord) -> bool:
    """Tell of a record that begins where its file alone says."""
    return record.command.start == ESTIMATED and record.file is not None and is_file(record.file)


def _warnings(records: Iterable[CampaignRecord], places: Iterable[Place]) -> tuple[str, ...]:
    each = [line for record, at in zip(records, places, strict=True) for line in record_warnings(record, at)]
    return (*each, *same_file_warnings(tuple(records)))
