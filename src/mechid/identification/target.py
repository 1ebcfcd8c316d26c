"""A record of the campaign becomes something to be matched."""

from __future__ import annotations

import numpy as np

from mechid.campaign import CampaignRecord
from mechid.identification.problem import Target
from mechid.signal import noise_floor
from mechid.simulation.simulator import TimeBase


def target_of(record: CampaignRecord) -> Target:
    """Return a record as a target, with the noise of its high-frequency floor."""
    data = record.data
    assert data is not None
    torque = data.channel("torque").data
    delay = next(p for p in record.parameters if p.name.endswith("time_offset_s"))
    return Target(
        name=record.name,
        measured=torque,
        base=TimeBase(data.sample_rate_hz, data.samples, data.time_start_s),
        command=record.command,
        sigma=max(noise_floor(torque, data.sample_rate_hz), 1e-6 * float(np.std(torque))),
        linear=(2 if record.drift else 1) if record.offset else 0,
        time_offset_s=delay.value,
        time_offset_bounds=(delay.min, delay.max) if delay.is_free else None,
    )
