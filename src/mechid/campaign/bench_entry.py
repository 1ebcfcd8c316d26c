"""``[bench]`` table of a campaign file: the measuring table, its calibration, and where the mechanism stands on it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from mechid.campaign.calibration_entry import read_calibration
from mechid.campaign.campaign import CampaignRecord
from mechid.campaign.place import Place, describe_entry, number, one_of, refuse_unknown_keys, required_entry
from mechid.campaign.table_response_entry import DeclaredResponse, read_table_response
from mechid.command.entry import is_table
from mechid.records import Mounting, Record, Role, move_to_mounting_point
from mechid.records.calibration import Calibration, calibrate
from mechid.records.components import AXES, TORQUE

KEY = "bench"
CALIBRATION, RESPONSE, INTERFACE, USABLE = "calibration", "table_response", "interface_point_m", "usable_band_hz"
KEYS = ("drive_axis", "mounting_point_m", CALIBRATION, RESPONSE, INTERFACE, USABLE)
OF_EMISSION = (RESPONSE, INTERFACE, USABLE)
"""Keys that `mechid emission` alone applies."""
DRIVE_AXES = (*AXES, *(f"-{axis}" for axis in AXES))
EXAMPLE = 'write [bench] with drive_axis = "z" and mounting_point_m = [0.0, 0.0, 0.05]'


@dataclass(frozen=True, kw_only=True, eq=False)
class Bench:
    """Measuring table as declared.

    Attributes
    ----------
    mounting : Mounting or None
        None where no ``[bench]`` is declared.
    calibration : Calibration or None
    response : DeclaredResponse or None
    interface_point_m : (float, float, float) or None
        Point that the moments of an emission are taken about, from the table's reference point.
    usable_band_hz : (float, float) or None
    place : Place
        Of the table.
    """

    place: Place
    mounting: Mounting | None = None
    calibration: Calibration | None = None
    response: DeclaredResponse | None = None
    interface_point_m: tuple[float, float, float] | None = None
    usable_band_hz: tuple[float, float] | None = None

    @property
    def interface(self) -> Mounting | None:
        """Mounting with the moments about the interface point, or about the mounting point where none is declared."""
        if self.mounting is None or self.interface_point_m is None:
            return self.mounting
        return replace(self.mounting, point_m=self.interface_point_m)

    @property
    def files(self) -> tuple[Path, ...]:
        """Files of its calibration and of its response."""
        named = (self.calibration and self.calibration.file, self.response and self.response.file)
        return tuple(path for path in named if path)

    def calibrate_record(self, record: Record) -> Record:
        """Return a record with calibrated loads about the table's reference point.

        Raises
        ------
        RecordError
            The loads need a component that was not recorded.
        """
        if self.calibration is None or self.mounting is None:
            return record
        return calibrate(record, self.calibration, self.mounting)

    def warnings(self) -> Iterator[str]:
        """Yield a warning that names the entries that only `mechid emission` applies, if there are any."""
        values = (self.response, self.interface_point_m, self.usable_band_hz)
        if declared := [key for key, value in zip(OF_EMISSION, values, strict=True) if value is not None]:
            yield (
                f"{self.place}: {', '.join(declared)}: mechid emission alone applies "
                f"{'it' if len(declared) == 1 else 'them'}; here moments are about mounting_point_m, and what the "
                "table adds near its resonances is left in the records"
            )


def read_bench(table: Mapping[str, Any], place: Place, records: Sequence[CampaignRecord], folder: Path) -> Bench:
    """Return the measuring table; without a mounting if no record has a component besides the torque.

    Parameters
    ----------
    table : Mapping
        Content of the campaign file.
    place : Place
        Of the file.
    records : sequence of CampaignRecord
    folder : Path
        Against which the paths of its files are taken.

    Raises
    ------
    InputFileError
        The entry is invalid, or missing although a record has such components; a component is the drive torque itself;
        a force needed to move a moment is not recorded, or a component that the calibration needs.
    """
    bench = _bench(table[KEY], place.key(KEY), folder) if KEY in table else Bench(place=place)
    for index, record in enumerate(records):
        _check(record, bench, place.key("record").item(index).key("channels"))
    _refuse_different(records, place.key("record"))
    return bench


def with_data(record: CampaignRecord, data: Record, bench: Bench) -> CampaignRecord:
    """Attach the samples to a record of the campaign, calibrated, with moments taken about the mounting point."""
    data = bench.calibrate_record(data)
    return replace(record, data=data if bench.mounting is None else move_to_mounting_point(data, bench.mounting))


def _bench(entry: Any, place: Place, folder: Path) -> Bench:
    if not is_table(entry):
        raise place.error(f"{describe_entry(entry)}; {EXAMPLE}")
    refuse_unknown_keys(entry, KEYS, place)
    axis = one_of(required_entry(entry, KEYS[0], place, 'write drive_axis = "z"'), DRIVE_AXES, place.key(KEYS[0]))
    remedy = "write three numbers in m, from the table's reference point: [0.0, 0.0, 0.05]"
    mounting = Mounting(axis, _point(required_entry(entry, KEYS[1], place, remedy), place.key(KEYS[1]), remedy))
    return Bench(
        place=place,
        mounting=mounting,
        calibration=read_calibration(entry[CALIBRATION], place.key(CALIBRATION), folder)
        if CALIBRATION in entry
        else None,
        response=read_table_response(entry[RESPONSE], place.key(RESPONSE), folder) if RESPONSE in entry else None,
        interface_point_m=_point(entry[INTERFACE], place.key(INTERFACE), remedy) if INTERFACE in entry else None,
        usable_band_hz=_band(entry[USABLE], place.key(USABLE)) if USABLE in entry else None,
    )


def _point(entry: Any, place: Place, remedy: str) -> tuple[float, float, float]:
    if not isinstance(entry, list) or len(entry) != 3:
        raise place.error(f"{describe_entry(entry)}; {remedy}")
    x, y, z = (number(value, place.item(k), "m") for k, value in enumerate(entry))
    return x, y, z


def _band(entry: Any, place: Place) -> tuple[float, float]:
    remedy = "write the lowest and the highest frequency in Hz, as [2.0, 800.0]"
    if not isinstance(entry, list) or len(entry) != 2:
        raise place.error(f"{describe_entry(entry)}; {remedy}")
    low, high = (number(value, place.item(k), "Hz") for k, value in enumerate(entry))
    if not 0.0 <= low < high:
        raise place.error(f"found [{low:g}, {high:g}]; {remedy}")
    return low, high


def _side_components(record: CampaignRecord) -> list[str]:
    return [channel.quantity for channel in record.spec.channels if channel.role is Role.SIDE]


def _refuse_different(records: Sequence[CampaignRecord], place: Place) -> None:
    """Refuse records with different components."""
    # The lines of a component are joined over the rate across records, so every record has to contribute to each.
    measured = [(index, side) for index, record in enumerate(records) if (side := _side_components(record))]
    for index, own in measured:
        if other := sorted(set(own) ^ set(measured[0][1])):
            remedy = "give the same in each record that has any"
            raise (
                place.item(index)
                .key("channels")
                .error(f"{', '.join(other)} in one of it and record[{measured[0][0]}] alone; {remedy}")
            )


def _check(record: CampaignRecord, bench: Bench, place: Place) -> None:
    """Refuse components that duplicate the drive torque, or that cannot be calibrated or moved."""
    mounting = bench.mounting
    quantities = tuple(channel.quantity for channel in record.spec.channels)
    if bench.calibration is not None and mounting is not None:
        if bench.calibration.in_volts and not quantities:
            raise place.error('missing; the calibration of [bench] is of voltages, so name each column with unit = "V"')
        # Without channels a record is its torque.
        if lacking := bench.calibration.missing_components(quantities or (TORQUE,), mounting):
            raise place.error(
                f"no {', '.join(lacking)}, which the calibration of [bench] needs for the others; add the channel"
            )
    side = _side_components(record)
    if not side:
        return
    at = place.item(quantities.index(side[0]))
    if mounting is None:
        raise at.error(f"{side[0]} needs the frame of the table and the mounting point in it; {EXAMPLE}")
    outputs = [channel.quantity for channel in record.spec.channels if channel.role is Role.OUTPUT]
    if TORQUE not in outputs:
        raise at.error(f"{side[0]} is evaluated with its phase relative to the drive torque; add a torque channel")
    if mounting.drive_moment in side:
        here = place.item(quantities.index(mounting.drive_moment))
        raise here.error(f'{mounting.drive_moment} is the drive torque; write quantity = "torque"')
    for name, moved in (("mounting", mounting), ("interface", bench.interface or mounting)):
        for quantity, forces in moved.levers(quantities):
            if missing := [force for force in forces if force not in side]:
                needs = f"{quantity} about the {name} point takes {' and '.join(missing)} too"
                remedy = "add the channel, or leave this one out" if quantity != TORQUE else "add the channel"
                raise place.item(quantities.index(quantity)).error(f"{needs}, by the lever arm of [bench]; {remedy}")
