"""Planned record of a design: command, duration, sample rate and expected noise."""

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
    """Record that could be taken.

    Parameters
    ----------
    name : str
        Suitable as a file name.
    command : Command
    duration_s : float
    sample_rate_hz : float
    sigma : float
        Standard deviation of white noise, N m.
    linear : int
        0: nothing is projected out, 1: offset, 2: offset and drift.
    time_offset : (float, float, float) or None
        Value and bounds in s if it would be estimated.
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
        """Time base of its samples, both ends included."""
        return TimeBase(self.sample_rate_hz, round(self.sample_rate_hz * self.duration_s) + 1)

    def target(self) -> Target:
        """Return the record as a target of the identification; its measured values do not matter and are zero."""
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
    """Recording conditions; None takes those of the campaign's own files.

    Parameters
    ----------
    noise_Nm, sample_rate_hz : float or None
    duration_s : float
        Duration of a record at constant rate that has no file.
    durations_s : mapping of record to float
    """

    noise_Nm: float | None = None
    sample_rate_hz: float | None = None
    duration_s: float = DURATION_S
    durations_s: Mapping[str, float] | None = None


def planned_records(campaign: Campaign, recording: Recording) -> tuple[tuple[PlannedRecord, ...], tuple[str, ...]]:
    """Return the campaign's records as planned ones, and lines on the assumptions made.

    An existing file determines length, sample rate and noise floor; a record without one is planned
    (`campaign.planned_record`). A record whose file does not exist yet, as in the campaign that a design proposes, is
    planned too, with a line that says so, since the name may be wrong.

    Raises
    ------
    UsageError
        There is no record to estimate from, or one is driven by measured channels or measures no torque.
    RecordError
        An existing file cannot be used.
    """
    if not campaign.estimated:
        raise UsageError(f'{campaign.path}: no record has use = "estimate"; write down what is planned')
    seen = {r.name: _file_properties(r) for r in campaign.estimated}
    sigmas = [sigma for _, _, sigma in filter(None, seen.values())]
    # The median of the measured floors: one noisy record does not set that of all planned ones.
    noise = recording.noise_Nm or (float(np.median(sigmas)) if sigmas else DESIGN.noise_nm)
    said = (
        ()
        if recording.noise_Nm or sigmas
        else (f"the noise is assumed, {DESIGN.noise_nm:g} N m a sample; write noise_Nm in the design file",)
    )
    rates = [s[0] for s in seen.values() if s]
    found = tuple(_plan(r, seen[r.name], recording, rates, noise) for r in campaign.estimated)
    return found, (*said, *_missing_files(campaign))


def _missing_files(campaign: Campaign) -> tuple[str, ...]:
    """Return a line for each record whose file does not exist."""
    absent = [r for r in campaign.estimated if r.data is None and r.file is not None and not is_file(Path(r.file))]
    return tuple(f'record "{r.name}": {r.spec.path} is not there: it counts as planned' for r in absent)


def _plan(
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
    requested_s = (recording.durations_s or {}).get(record.name)
    planned = planned_rate_hz(record, rates), planned_duration_s(record.command, recording.duration_s), noise
    own_rate, own_duration, own_sigma = seen or planned
    return PlannedRecord(
        name=record.name,
        command=record.command,
        duration_s=requested_s or own_duration,
        sample_rate_hz=recording.sample_rate_hz or own_rate,
        sigma=recording.noise_Nm or own_sigma,
        linear=(2 if match.drift else 1) if match.offset else 0,
        time_offset=(delay.value, delay.min, delay.max) if delay.is_free else None,
    )


def _file_properties(record: CampaignRecord) -> tuple[float, float, float] | None:
    """Return sample rate in Hz, duration in s and noise floor in N m of a record's file, None without a file."""
    data = record.data
    if data is None and record.file is not None and is_file(Path(record.file)):
        data = read_record(record.file, record.spec)
    if data is None or record.leading != TORQUE:
        return None
    return data.sample_rate_hz, data.duration_s, known_noise(replace(record, data=data), record.estimated[0]).sigma
