"""The campaign file: it names records, mechanism and stages, and they are read and joined here."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from mechid.campaign.bench_entry import read_bench, with_data
from mechid.campaign.campaign import Campaign, CampaignRecord
from mechid.campaign.joined_campaign import KEYS, SYNTHETIC, Sources, joined_campaign
from mechid.campaign.mechanism_file import load_mechanism
from mechid.campaign.not_filled_in import refuse_empty_commands
from mechid.campaign.place import Place, refuse_unknown_keys, required, text
from mechid.campaign.record_entry import read_records as read_record_entries
from mechid.campaign.record_tables import gathered
from mechid.campaign.toml_file import read_toml
from mechid.errors import InputFileError
from mechid.reading.whole import is_file, is_folder
from mechid.records import Record, prepare_to_read, read_record

FILE_NAME = "campaign.toml"
TRUTH_NAME = "truth.json"
"""The values that synthetic records were made with; a campaign file beside it that does not say `synthetic` is so."""
MECHANISM_REMEDY = 'write the name of the mechanism file, as mechanism = "mechanism.toml"'


def load_campaign(
    path: Path | str,
    *,
    read_records: bool = True,
    need_files: bool | None = None,
    mechanism_file: Path | str | None = None,
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
    mechanism_file : Path, str or None
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
    refuse_empty_commands(table, place, mechanism_path)
    need_files = read_records if need_files is None else need_files
    sources = Sources(file.parent, lambda: load_mechanism(mechanism_path), _read, need_files, read_records)
    if SYNTHETIC not in table and is_synthetic(table, file):
        table = {**table, SYNTHETIC: True}
    return joined_campaign(table, place, sources, path=file, mechanism_path=mechanism_path)


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
    file = find_campaign_file(Path(path))
    table, place = read_toml(file, "campaign"), Place(file.name)
    refuse_unknown_keys(table, KEYS, place)
    table = gathered(table, place)
    records = read_record_entries(table, place, file.parent, need_files=True)
    mounting = read_bench(table, place, records)
    return tuple(with_data(one, read_record(one.file, one.spec), mounting) for one in records if one.file)


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
    entry = required(table, "mechanism", place, MECHANISM_REMEDY)
    return text(entry, place.key("mechanism"), MECHANISM_REMEDY)


def _read(records: Sequence[CampaignRecord]) -> Iterator[Record | None]:
    """Yield what the records' files hold, None of those that have none; who reads them is made ready for all."""
    prepare_to_read(record.file for record in records if record.file)
    for record in records:
        yield read_record(record.file, record.spec) if record.file else None
