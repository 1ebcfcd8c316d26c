"""Builder of a campaign from the tables of its file: records, mechanism, stages and options."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mechid.campaign.bench_entry import KEY as BENCH
from mechid.campaign.bench_entry import Bench, read_bench, with_data
from mechid.campaign.campaign import CAMPAIGN, CLOCK, Campaign, CampaignRecord
from mechid.campaign.declared_test import KEYS as OF_TEST
from mechid.campaign.declared_test import read_declared_test
from mechid.campaign.diagnose_options import DIAGNOSE, read_considered
from mechid.campaign.identify_options import read_identify_options
from mechid.campaign.measured_input import assign_channels, with_inputs
from mechid.campaign.mechanism_file import mechanism_warnings
from mechid.campaign.phases_entry import with_phases
from mechid.campaign.place import Place, flag
from mechid.campaign.record_entry import read_records
from mechid.campaign.record_tables import OWN, merge_tables
from mechid.campaign.record_values import with_record_values
from mechid.campaign.record_warnings import record_warnings, same_file_warnings
from mechid.campaign.stage_entry import read_stages
from mechid.campaign.start_entry import ESTIMATED, with_starts
from mechid.campaign.stretches import cut_into_stretches
from mechid.campaign.timing_entry import REFERENCE, read_clock_reference, with_clocks
from mechid.plant.mechanism import Mechanism
from mechid.reading.whole import is_file
from mechid.records import Record

SYNTHETIC = "synthetic"
"""Key of the flag for simulated records."""
OF_EMISSION = ("requirement", "background")
"""Tables that `mechid emission` reads."""
KEYS = (
    *("mechanism", SYNTHETIC, "identify", DIAGNOSE, CLOCK.key, REFERENCE, BENCH, "record", "stage", CAMPAIGN, OWN),
    *OF_EMISSION,
    *OF_TEST,
)


@dataclass(frozen=True)
class Sources:
    """Sources of the mechanism and the samples that a campaign names.

    Parameters
    ----------
    folder : Path
        Base of relative paths.
    mechanism : callable
        Makes the mechanism; called after the records' tables have been checked.
    samples : callable
        Returns the samples of the given records in order, None for a record without samples.
    need_files : bool
        Whether a record without a file is refused.
    read_records : bool
        False reads samples only of records whose estimated start depends on them.
    """

    folder: Path
    mechanism: Callable[[], Mechanism]
    samples: Callable[[Sequence[CampaignRecord]], Iterable[Record | None]]
    need_files: bool = True
    read_records: bool = True


def build_campaign(
    table: Mapping[str, Any], place: Place, sources: Sources, *, path: Path, mechanism_path: Path
) -> Campaign:
    """Build a campaign from the table of its file.

    Parameters
    ----------
    table : Mapping
        Content of ``campaign.toml``, with only known keys.
    place : Place
        Place of the file, for messages.
    sources : Sources
    path, mechanism_path : Path
        Paths stored in the campaign.

    Raises
    ------
    InputFileError
        The table or the mechanism is invalid.
    RecordError
        A record's samples are missing or unusable.
    """
    table = merge_tables(table, place)
    options, effects = read_identify_options(table, place), read_considered(table, place)
    test = read_declared_test(table, place, sources.folder)
    records = read_records(table, place, sources.folder, need_files=sources.need_files)
    bench = read_bench(table, place, records, sources.folder)
    # The mechanism is made only after the records' tables, whose errors are reported first.
    mechanism, records = assign_channels(sources.mechanism(), records, place)
    records = with_clocks(with_phases(records, mechanism, place), table, place)
    places = [place.key("record").item(index) for index in range(len(records))]
    records = with_record_values(records, table["record"], places, mechanism)
    # Before the samples are read, which takes longest, so that errors in the tables are reported at once.
    records = with_starts(records, table["record"], places, mechanism)
    if sources.read_records:
        read_stages(table, place, mechanism, records)
    read = _with_data(records, mechanism, bench, sources)
    # The stretches need initial states of their own, so these are added again after the cut.
    cut = cut_into_stretches(read, table["record"], place, staged="stage" in table)
    places = [at for _, _, at in cut]
    records = with_starts([record for record, _, _ in cut], [entry for _, entry, _ in cut], places, mechanism)
    return Campaign(
        path=path,
        mechanism_path=mechanism_path,
        mechanism=mechanism,
        records=records,
        mounting=bench.mounting,
        stages=read_stages(table, place, mechanism, records),
        options=options,
        considered=effects,
        test=test,
        clock_reference=read_clock_reference(table, place),
        synthetic=flag(table.get(SYNTHETIC, False), place.key(SYNTHETIC)),
        warnings=(
            *mechanism_warnings(mechanism, mechanism_path.name),
            *bench.warnings(),
            *_warnings(records, places),
        ),
    )


def _with_data(
    records: Sequence[CampaignRecord], mechanism: Mechanism, bench: Bench, sources: Sources
) -> tuple[CampaignRecord, ...]:
    wanted = [r for r in records if sources.read_records or _has_estimated_start(r)]
    found = {id(r): data for r, data in zip(wanted, sources.samples(wanted), strict=True) if data is not None}
    return tuple(
        with_inputs(with_data(r, found[id(r)], bench), found[id(r)], mechanism) if id(r) in found else r
        for r in records
    )


def _has_estimated_start(record: CampaignRecord) -> bool:
    """Return whether the start of a record is estimated from its samples."""
    return record.command.start == ESTIMATED and record.file is not None and is_file(record.file)


def _warnings(records: Iterable[CampaignRecord], places: Iterable[Place]) -> tuple[str, ...]:
    each = [line for record, at in zip(records, places, strict=True) for line in record_warnings(record, at)]
    return (*each, *same_file_warnings(tuple(records)))
