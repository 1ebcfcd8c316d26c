"""A record of the campaign becomes something to be matched."""

from __future__ import annotations

import numpy as np

from mechid.campaign import CampaignRecord
from mechid.identification.problem import Target
from mechid.signal import noise_floor
from mechid.simulation.simulator import TimeBase, excitation_over


def target_of(record: CampaignRecord) -> Target:
    """Return a record as a target, with the noise of its high-frequency floor."""
    data = record.data
    assert data is not None
    delay = record.time_offset
    latest_s = max(abs(delay.min), abs(delay.max)) if delay.is_free else abs(delay.value)
    base = TimeBase(data.sample_rate_hz, data.samples, data.time_start_s)
    return Target(
        name=record.name,
        measured=data.channel(record.quantity).data,
        base=base,
        command=record.command,
        excitation=excitation_over(record.command, base, latest_s),
        sigma=noise_sigma(record),
        linear=(2 if record.drift else 1) if record.offset else 0,
        time_offset_s=delay.value,
        time_offset_bounds=(delay.min, delay.max) if delay.is_free else None,
    )


def noise_sigma(record: CampaignRecord) -> float:
    """Return the noise of a record, in its quantity's unit: its high-frequency floor, or hardly anything."""
    assert record.data is not None
    measured = record.data.channel(record.quantity).data
    return max(noise_floor(measured, record.data.sample_rate_hz), 1e-6 * float(np.std(measured)))
