"""A record that is planned: how it would be driven, for how long, and how noisy it would be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mechid.campaign import Campaign, CampaignRecord
from mechid.command import Command, MeasuredCommand
from mechid.errors import UsageError
from mechid.identification.output_error.target import (
    Target,
    TargetChannel,
    latest_of,
    noise_sigma,
    time_offset_of,
)
from mechid.records import read_record
from mechid.simulation.simulator import TimeBase, excitation_over

TORQUE = "torque"
SAMPLE_RATE_HZ, DURATION_S, NOISE_NM = 10_000.0, 1.0, 0.002
"""What is assumed where neither a file nor the user says it."""


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
    sigma: float = NOISE_NM
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
            excitation=excitation_over(self.command, self.base, latest_of(offset)),
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

    A record whose file is there has its length, sample rate and noise floor; one without lasts to the end of its rate
    profile, or `recording.duration_s`.

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
    noise = recording.noise_Nm or (float(np.median(sigmas)) if sigmas else NOISE_NM)
    said = () if recording.noise_Nm or sigmas else (
        f"the noise is assumed, {NOISE_NM:g} N m a sample; write noise_Nm in the design file",)  # fmt: skip
    rate = recording.sample_rate_hz or next((s[0] for s in seen.values() if s), SAMPLE_RATE_HZ)
    found = tuple(_planned(r, seen[r.name], recording, rate, noise) for r in campaign.estimated)
    return found, said


def _planned(
    record: CampaignRecord, seen: tuple[float, float, float] | None, recording: Recording, rate: float, noise: float
) -> PlannedRecord:
    if isinstance(record.command, MeasuredCommand):
        raise UsageError(f'record "{record.name}" is driven by measured channels; a design is made of step commands')
    if record.leading != TORQUE:
        raise UsageError(f'record "{record.name}" measures {record.leading}; a design is made of records of torque')
    match, delay = record.estimated[0], record.time_offset
    asked = (recording.durations_s or {}).get(record.name)
    own_rate, own_duration, own_sigma = seen or (record.spec.sample_rate_hz or rate, None, noise)
    return PlannedRecord(
        name=record.name,
        command=record.command,
        duration_s=asked or own_duration or profile_end_s(record.command) or recording.duration_s,
        sample_rate_hz=recording.sample_rate_hz or own_rate,
        sigma=recording.noise_Nm or own_sigma,
        linear=(2 if match.drift else 1) if match.offset else 0,
        time_offset=(delay.value, delay.min, delay.max) if delay.is_free else None,
    )


def profile_end_s(command: Command) -> float | None:
    """Return the time of the last breakpoint of a command's rate in s, None where the rate is constant."""
    end = command.rate.times_s[-1]
    return end if len(command.rate.times_s) > 1 and end > 0.0 else None


def _measured(record: CampaignRecord) -> tuple[float, float, float] | None:
    """Return sample rate in Hz, duration in s and noise floor in N m of a record's file, None where there is none."""
    data = record.data
    if data is None and record.file is not None and Path(record.file).is_file():
        data = read_record(record.file, record.spec)
    if data is None or record.leading != TORQUE:
        return None
    return data.sample_rate_hz, data.duration_s, noise_sigma(replace(record, data=data), record.estimated[0])
