"""A record that is planned: how it would be driven, for how long, and how noisy it would be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mechid.campaign import Campaign, CampaignRecord
from mechid.campaign.planned_record import DURATION_S, SAMPLE_RATE_HZ, planned_duration_s, planned_rate_hz
from mechid.command import Command, MeasuredCommand
from mechid.designs.settings import DESIGN
from mechid.errors import UsageError
from mechid.identification.output_error.noise_level import known_noise
from mechid.identification.output_error.target import Target, TargetChannel, latest_of, time_offset_of
from mechid.reading.whole import is_file
from mechid.records import read_record
from mechid.simulation.simulator import TimeBase, excitation_over

TORQUE = "torque"


@dataclass(frozen=True, kw_only=True)
class PlannedRecord:
    """A record that could be taken.

    Parameters
    ----------
    name : str
        Fit for a file name.
    command : Command
    duration_s : float
    sample_rate_hz : float
    sigma : float
        Standard deviation of white noise, N m.
    linear : int
        0: nothing is projected out of it, 1: offset, 2: offset and drift.
    time_offset : (float, float, float) or None
        Value and bounds in s where it would be estimated.
    """

    name: str
    command: Command
    duration_s: float
    sample_rate_hz: float = SAMPLE_RATE_HZ
    sigma: float = DESIGN.noise_nm
    linear: int = 2
    time_offset: tuple[float, float, float] | None = None

    @property
    def base(self) -> TimeBase:
        """Its samples, both ends included."""
        return TimeBase(self.sample_rate_hz, round(self.sample_rate_hz * self.duration_s) + 1)

    def target(self) -> Target:
        """Return it as the identification would match it; what would be measured does not matter, it is zero."""
        value, *bounds = self.time_offset or (0.0,)
        offset = time_offset_of(self.name, value, bounds)
        return Target(
            name=self.name,
            channels=(TargetChannel(TORQUE, np.broadcast_to(0.0, (self.base.samples,)), self.sigma, self.linear),),
            base=self.base,
            command=self.command,
            excitation=excitation_over(self.command, self.base, latest_of((offset,), self.base)),
            own=(offset,),
        )


@dataclass(frozen=True, kw_only=True)
class Recording:
    """How records would be taken. None where the campaign's own files are to say it.

    Parameters
    ----------
    noise_Nm, sample_rate_hz : float or None
    duration_s : float
        Of a record at constant rate that has no file.
    durations_s : mapping of record to float
    """

    noise_Nm: float | None = None
    sample_rate_hz: float | None = None
    duration_s: float = DURATION_S
    durations_s: Mapping[str, float] | None = None


def planned_records(campaign: Campaign, recording: Recording) -> tuple[tuple[PlannedRecord, ...], tuple[str, ...]]:
    """Return the campaign's records as planned ones, and what had to be assumed.

    A record whose file is there has its length, sample rate and noise floor; one without is planned
    (`campaign.planned_record`). So is one whose file is not there yet, as in the campaign that a design proposes; that
    is said, since the name may be wrong.

    Raises
    ------
    UsageError
        There is no record to be estimated from, or one is driven by measured channels or measures no torque.
    RecordError
        A file that is there cannot be used.
    """
    if not campaign.estimated:
        raise UsageError(f'{campaign.path}: no record has use = "estimate"; write down what is planned')
    seen = {r.name: _measured(r) for r in campaign.estimated}
    sigmas = [sigma for _, _, sigma in filter(None, seen.values())]
    noise = recording.noise_Nm or (float(np.median(sigmas)) if sigmas else DESIGN.noise_nm)
    said = (
        ()
        if recording.noise_Nm or sigmas
        else (f"the noise is assumed, {DESIGN.noise_nm:g} N m a sample; write noise_Nm in the design file",)
    )
    rates = [s[0] for s in seen.values() if s]
    found = tuple(_planned(r, seen[r.name], recording, rates, noise) for r in campaign.estimated)
    return found, (*said, *_not_there(campaign))


def _not_there(campaign: Campaign) -> tuple[str, ...]:
    """Name the records whose file is not there."""
    absent = [r for r in campaign.estimated if r.data is None and r.file is not None and not is_file(Path(r.file))]
    return tuple(f'record "{r.name}": {r.spec.path} is not there: it counts as planned' for r in absent)


def _planned(
    record: CampaignRecord,
    seen: tuple[float, float, float] | None,
    recording: Recording,
    rates: Sequence[float],
    noise: float,
) -> PlannedRecord:
    if isinstance(record.command, MeasuredCommand):
        raise UsageError(f'record "{record.name}" is driven by measured channels; a design is made of step commands')
    if record.leading != TORQUE:
        raise UsageError(f'record "{record.name}" measures {record.leading}; a design is made of records of torque')
    match, delay = record.estimated[0], record.time_offset
    asked = (recording.durations_s or {}).get(record.name)
    planned = planned_rate_hz(record, rates), planned_duration_s(record.command, recording.duration_s), noise
    own_rate, own_duration, own_sigma = seen or planned
    return PlannedRecord(
        name=record.name,
        command=record.command,
        duration_s=asked or own_duration,
        sample_rate_hz=recording.sample_rate_hz or own_rate,
        sigma=recording.noise_Nm or own_sigma,
        linear=(2 if match.drift else 1) if match.offset else 0,
        time_offset=(delay.value, delay.min, delay.max) if delay.is_free else None,
    )


def _measured(record: CampaignRecord) -> tuple[float, float, float] | None:
    """Return sample rate in Hz, duration in s and noise floor in N m of a record's file, None where there is none."""
    data = record.data
    if data is None and record.file is not None and is_file(Path(record.file)):
        data = read_record(record.file, record.spec)
    if data is None or record.leading != TORQUE:
        return None
    return data.sample_rate_hz, data.duration_s, known_noise(replace(record, data=data), record.estimated[0]).sigma
