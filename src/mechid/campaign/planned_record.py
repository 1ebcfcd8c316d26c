"""A record that has no file: it is planned. What its time base is then, for all who look at it before it is taken."""

from __future__ import annotations

from collections.abc import Iterable

from mechid.campaign.campaign import CampaignRecord
from mechid.command import Command, MeasuredCommand

SAMPLE_RATE_HZ, DURATION_S = 10_000.0, 1.0
"""What is assumed where neither the user, the record, the command nor another record's file says it."""


def planned_rate_hz(record: CampaignRecord, known: Iterable[float] = ()) -> float:
    """Return the sample rate in Hz of a record without a file: its own key's, else the first that is known of others.

    Parameters
    ----------
    record : CampaignRecord
    known : iterable of float
        Sample rates in Hz of the campaign's records whose files were read.
    """
    return record.spec.sample_rate_hz or next(iter(known), SAMPLE_RATE_HZ)


def planned_duration_s(command: Command, usual_s: float = DURATION_S) -> float:
    """Return how long a record without a file lasts: to the end of its rate profile, else as usual."""
    return profile_end_s(command) or usual_s


def profile_end_s(command: Command) -> float | None:
    """Return the time of the last breakpoint of a command's rate in s, None where the rate is constant."""
    if isinstance(command, MeasuredCommand):
        return None
    end = command.rate.times_s[-1]
    return end if len(command.rate.times_s) > 1 and end > 0.0 else None
