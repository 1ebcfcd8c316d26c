"""Time base of a planned record, which has no file yet."""

from __future__ import annotations

from collections.abc import Iterable

from mechid.campaign.campaign import CampaignRecord
from mechid.command import Command, MeasuredCommand
from mechid.command.step_times import StepProfile

SAMPLE_RATE_HZ, DURATION_S = 10_000.0, 1.0
"""Defaults if neither the user, the record, the command nor another record's file gives a value."""


def planned_rate_hz(record: CampaignRecord, known: Iterable[float] = ()) -> float:
    """Return the sample rate in Hz of a planned record: its own entry, else the first known rate of another record.

    Parameters
    ----------
    record : CampaignRecord
    known : iterable of float
        Sample rates in Hz of the records whose files were read.
    """
    return record.spec.sample_rate_hz or next(iter(known), SAMPLE_RATE_HZ)


def planned_duration_s(command: Command, default_s: float = DURATION_S) -> float:
    """Return the duration in s of a planned record: the end of its rate profile, else the default.

    Steps at instants of their own are followed by the default, in which the swing of the last one decays.
    """
    if isinstance(command.rate, StepProfile):
        return command.rate.steps[-1][0] + default_s
    return profile_end_s(command) or default_s


def profile_end_s(command: Command) -> float | None:
    """Return the time in s of the last breakpoint of a rate profile, None for a constant rate."""
    if isinstance(command, MeasuredCommand):
        return None
    end = command.rate.times_s[-1]
    return end if len(command.rate.times_s) > 1 and end > 0.0 else None
