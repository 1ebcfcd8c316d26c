"""Background records: what the bench measures while the mechanism exports nothing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign.calibration_entry import reads_volts
from mechid.campaign.campaign import CampaignRecord
from mechid.campaign.channel_entry import read_channels, read_time
from mechid.campaign.place import Place, one_of, positive_number, refuse_unknown_keys, required_entry, tables, text
from mechid.campaign.record_entry import NAME
from mechid.emissions.interface import Interface
from mechid.emissions.lines import Lines, find_lines, mains_of
from mechid.emissions.settings import EMISSION
from mechid.emissions.spectra import Spectra, channel_spectra
from mechid.errors import RecordError
from mechid.records import Mounting, Record, RecordSpec, read_record
from mechid.signal.settings import HUM
from mechid.specification.requirement import direction_of
from mechid.specification.settings import SPECIFICATION

KEY = "background"
KEYS = ("name", "file", "state", "channels", "sample_rate_hz", "time")
OFF, HOLDING, EMPTY = "off", "holding", "empty"
STATES = (OFF, HOLDING, EMPTY)
SAME_RATE = 1e-4
"""Relative difference of two sample rates that are one: clocks of recorders differ by less."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Background:
    """One background record.

    Attributes
    ----------
    name : str
    state : str
        ``"off"``, ``"holding"`` or ``"empty"``.
    record : Record
        In SI, moments about the mounting point.
    mounting : Mounting or None
    """

    name: str
    state: str
    record: Record
    mounting: Mounting | None
    # Each record asks for them; windows of one length are transformed once.
    _spectra: dict[tuple[str, int], Spectra] = field(default_factory=dict)
    _lines: dict[tuple[str, int], Lines] = field(default_factory=dict)

    def samples(self, direction: str) -> FloatArray | None:
        """Return the samples of a direction; None where it was not measured."""
        for channel in self.record.channels:
            if direction_of(channel.quantity, self.mounting) == direction:
                return channel.data[:]
        return None

    def spectra(self, direction: str, length: int) -> Spectra | None:
        """Return the spectra of a direction by windows of so many samples; they are kept.

        Raises
        ------
        RecordError
            It is shorter than a window, or other records use another sample rate.
        """
        key = (direction, length)
        if key not in self._spectra:
            y = self.samples(direction)
            if y is None:
                return None
            rate = self.record.sample_rate_hz
            if y.size < length:
                raise RecordError(
                    f'background "{self.name}": lasts {y.size / rate:.3g} s, shorter than a window of '
                    f"{length / rate:.3g} s; record at least {SPECIFICATION.window_s:g} s, or as long as the "
                    "longest run"
                )
            self._spectra[key] = channel_spectra(y, rate, length)
        return self._spectra[key]

    def lines(self, direction: str, length: int) -> Lines | None:
        """Return the lines of a direction; they are kept."""
        key = (direction, length)
        if key not in self._lines:
            spectra = self.spectra(direction, length)
            if spectra is None:
                return None
            self._lines[key] = find_lines(spectra)
        return self._lines[key]

    def refuse_other_clock(self, record: Record) -> None:
        """Refuse a run with another sample rate than the background's."""
        own, other = self.record.sample_rate_hz, record.sample_rate_hz
        if abs(own - other) > SAME_RATE * other:
            raise RecordError(
                f'background "{self.name}": sampled at {own:.9g} Hz, record "{record.name}" at {other:.9g} Hz; '
                "record the background with the settings of the runs"
            )

    def refuse_motion(self, rate: float, record: str, direction: str, length: int) -> None:
        """Refuse a background with lines at the orders of a step rate.

        Raises
        ------
        RecordError
            The mechanism was moving.
        """
        spectra, lines = self.spectra(direction, length), self.lines(direction, length)
        if spectra is None or lines is None or not abs(rate) > 0.0:
            return
        # Lines of the mains are in a background at rest too, and may coincide with an order.
        own = lines.frequency_hz[np.isnan(mains_of(lines.frequency_hz, spectra))]
        reach = EMISSION.near_bins * spectra.bin_hz
        wanted = abs(rate) * np.arange(1, EMISSION.moving_orders + 1)
        # an order at a multiple of a grid shows nothing, even where the grid itself is too weak to be recognised
        for grid in HUM.mains_hz:
            wanted = wanted[
                np.abs(wanted - grid * np.round(wanted / grid)) > 2.0 * spectra.bin_hz + HUM.wander * wanted
            ]
        found = [f for f in wanted if np.any(np.abs(own - f) <= reach)]
        # so many lines would be near any frequencies
        by_chance = min(own.size * 2.0 * reach / (0.5 * spectra.sample_rate_hz), 1.0) * wanted.size
        if len(found) >= EMISSION.moving_least + round(4.0 * by_chance):
            where = ", ".join(f"{f:.4g}" for f in found)
            raise RecordError(
                f'background "{self.name}": was recorded in motion: {direction} has lines at {where} Hz, orders of '
                f'{abs(rate):.4g} steps/s as in record "{record}"; record it with the motor at rest'
            )


def read_backgrounds(
    table: Mapping[str, Any],
    place: Place,
    folder: Path,
    records: Sequence[CampaignRecord],
    interface: Interface,
) -> tuple[Background, ...]:
    """Return the background records of a campaign file, read.

    Parameters
    ----------
    table : mapping
        Content of the file.
    place : Place
        Of the file.
    folder : Path
        Against which relative paths are taken.
    records : sequence of CampaignRecord
        A background that names no channels, sample rate or time has those of the first record.
    interface : Interface
        Its loads are made of the channels as those of the runs are.

    Raises
    ------
    InputFileError
        An entry is wrong.
    RecordError
        A file is missing or cannot be used.
    """
    made: list[Background] = []
    in_volts = reads_volts(table)
    for entry, at in tables(table, KEY, place):
        spec, state = _spec(entry, at, records, in_volts=in_volts)
        if spec.name in {one.name for one in made}:
            raise at.key("name").error(f'"{spec.name}" stands here twice; give each background its own name')
        record = interface.load(read_record(folder / spec.path, spec))
        made.append(Background(name=spec.name, state=state, record=record, mounting=interface.mounting))
    return tuple(made)


def _spec(
    entry: Mapping[str, Any], place: Place, records: Sequence[CampaignRecord], *, in_volts: bool
) -> tuple[RecordSpec, str]:
    refuse_unknown_keys(entry, KEYS, place)
    remedy = 'write letters, digits, _ and - only, as name = "motor_off"'
    name = text(required_entry(entry, "name", place, remedy), place.key("name"), remedy)
    if not NAME.fullmatch(name):
        raise place.key("name").error(f'found "{name}"; {remedy}')
    file_remedy = 'write the name of the measured file, as file = "motor_off.csv"'
    file = text(required_entry(entry, "file", place, file_remedy), place.key("file"), file_remedy)
    state = required_entry(
        entry, "state", place, 'write state = "off" (motor unpowered), "holding" or "empty" (table alone)'
    )
    first = records[0].spec
    rate = first.sample_rate_hz
    if "sample_rate_hz" in entry:
        rate = positive_number(entry["sample_rate_hz"], place.key("sample_rate_hz"), "Hz")
    spec = RecordSpec(
        name=name,
        path=file,
        sample_rate_hz=rate,
        channels=read_channels(entry.get("channels"), place.key("channels"), in_volts=in_volts) or first.channels,
        time=read_time(entry.get("time"), place.key("time")) or first.time,
    )
    return spec, one_of(state, STATES, place.key("state"))


def choose_background(backgrounds: Sequence[Background], direction: str) -> Background | None:
    """Return the background that is subtracted in a direction; None where none measured it.

    The bench alone comes first: a motor that holds its position exports the noise of its driver, which belongs to the
    mechanism.
    """
    measured = [one for one in backgrounds if one.samples(direction) is not None]
    # Among equal states the longest record: more windows make narrower bounds.
    return min(measured, key=lambda one: (one.state == HOLDING, -one.record.samples), default=None)
