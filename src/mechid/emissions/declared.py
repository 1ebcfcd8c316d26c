"""Emission campaign: the records of a campaign file one by one, its backgrounds and its requirements."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from mechid.budgets.budget_file import KEYS as BUDGET_KEYS
from mechid.campaign.bench_entry import read_bench
from mechid.campaign.campaign import CampaignRecord
from mechid.campaign.campaign_builder import KEYS
from mechid.campaign.campaign_file import find_campaign_file, is_synthetic, load_named_lines
from mechid.campaign.declared_test import DeclaredTest, read_declared_test
from mechid.campaign.place import Place, refuse_unknown_keys
from mechid.campaign.record_entry import read_records
from mechid.campaign.record_tables import merge_tables
from mechid.campaign.toml_file import read_toml
from mechid.emissions.background import Background, read_backgrounds
from mechid.emissions.interface import Interface
from mechid.errors import InputFileError, did_you_mean
from mechid.plant.mechanism import NamedLine
from mechid.records import Mounting, prepare_to_read, read_record
from mechid.records.formats import digest_of
from mechid.specification.requirement import QUANTITY_OF, Requirement, direction_of
from mechid.specification.requirement_entry import KEY as REQUIREMENT
from mechid.specification.requirement_entry import MASK_FILE, read_requirements


@dataclass(frozen=True, kw_only=True, eq=False)
class Declared:
    """Records, backgrounds and requirements of an emission verdict.

    Attributes
    ----------
    path : Path
        Campaign file.
    records : tuple of CampaignRecord
        Not read yet.
    interface : Interface
        What makes loads of the records' channels.
    backgrounds : tuple of Background
    requirements : tuple of Requirement
    synthetic : bool
    test : DeclaredTest
        Statements on the test.
    named : tuple of NamedLine
        Lines that the mechanism names, if its file is there.
    inputs : mapping of str to str
        SHA-256 of the files of campaign, requirements and masks, by name.
    """

    path: Path
    records: tuple[CampaignRecord, ...]
    interface: Interface
    backgrounds: tuple[Background, ...]
    requirements: tuple[Requirement, ...]
    synthetic: bool
    test: DeclaredTest
    named: tuple[NamedLine, ...]
    inputs: Mapping[str, str]

    def read(self) -> Iterator[CampaignRecord]:
        """Yield the records with their samples, one at a time: all of them would not fit into memory."""
        prepare_to_read(record.file for record in self.records if record.file)
        for record in self.records:
            if record.file:
                yield replace(record, data=self.interface.load(read_record(record.file, record.spec)))

    @property
    def mounting(self) -> Mounting | None:
        """Drive axis, and the point that moments are about."""
        return self.interface.mounting

    def own_direction(self, requirement: Requirement) -> str:
        """Return the direction under which the records have a requirement's channel."""
        quantity = QUANTITY_OF[requirement.direction]
        return direction_of(quantity, self.mounting) or requirement.direction


def load_declared(path: Path, requirements: Path | None) -> Declared:
    """Return records, backgrounds and requirements; the mechanism file need not be there.

    Parameters
    ----------
    path : Path
        Campaign file or its folder.
    requirements : Path or None
        File with the ``[[requirement]]`` tables, in place of those of the campaign file.

    Raises
    ------
    InputFileError
        A file is missing or wrong, or a requirement asks for a direction that no record has.
    RecordError
        A background is missing or cannot be used.
    """
    file = find_campaign_file(path)
    table, place = read_toml(file, "campaign"), Place(file.name)
    refuse_unknown_keys(table, KEYS, place)
    records = read_records(merge_tables(table, place), place, file.parent, need_files=True)
    interface = Interface(read_bench(table, place, records, file.parent))
    asked, own, at = file, table, place
    if requirements is not None:
        asked, own, at = requirements, read_toml(requirements), Place(requirements.name)
        # The file may be a budget's, which holds the whole specification.
        refuse_unknown_keys(own, BUDGET_KEYS, at)
    wanted = read_requirements(own, at, asked.parent)
    _refuse_unmeasured(wanted, records, interface, at)
    return Declared(
        path=file,
        records=records,
        interface=interface,
        backgrounds=read_backgrounds(table, place, file.parent, records, interface),
        requirements=wanted,
        synthetic=is_synthetic(table, file),
        test=read_declared_test(table, place, file.parent),
        named=load_named_lines(file),
        inputs={
            file.name: digest_of(file),
            asked.name: digest_of(asked),
            **_mask_digests(own, asked.parent),
            **{path.name: digest_of(path) for path in interface.bench.files},
        },
    )


def _mask_digests(table: Mapping[str, Any], folder: Path) -> dict[str, str]:
    names = [entry[MASK_FILE] for entry in table.get(REQUIREMENT, ()) if MASK_FILE in entry]
    return {name: digest_of(folder / name) for name in names}


def _refuse_unmeasured(
    wanted: tuple[Requirement, ...], records: tuple[CampaignRecord, ...], interface: Interface, place: Place
) -> None:
    mounting = interface.mounting
    measured = {direction_of(quantity, mounting) for record in records for quantity in _quantities(record)}
    for k, one in enumerate(wanted):
        if direction_of(QUANTITY_OF[one.direction], mounting) not in measured:
            known = sorted(filter(None, measured))
            near = did_you_mean(one.direction, known) or f"; they have {', '.join(known)}"
            raise InputFileError(
                f'{place.key(REQUIREMENT).item(k).key("direction")}: no record measures "{one.direction}"{near}, '
                "or add the channel to the records"
            )
        own = direction_of(QUANTITY_OF[one.direction], mounting) or one.direction
        if not interface.band_hz(own)[1] > 0.0:
            raise InputFileError(
                f"{place.key(REQUIREMENT).item(k).key('direction')}: table_response has no response of {own}, or of a "
                "force that its moment takes; measure it, or leave the requirement out"
            )


def _quantities(record: CampaignRecord) -> list[str]:
    return [channel.quantity for channel in record.spec.channels] or ["torque"]
