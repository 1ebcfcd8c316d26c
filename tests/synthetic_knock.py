"""A knock on a test bench: half a sine of torque in one record of a synthetic campaign."""

from dataclasses import replace

import numpy as np

from synthetic import NOISE_NM, RATE_HZ

SIGMAS = 30.0


def knock(torque: np.ndarray, at_s: float, lasts_s: float) -> np.ndarray:
    """Return a torque with half a sine of 30 sigmas added."""
    first, count = round(at_s * RATE_HZ), round(lasts_s * RATE_HZ)
    torque = torque.copy()
    torque[first : first + count] += SIGMAS * NOISE_NM * np.sin(np.pi * (np.arange(count) + 0.5) / count)
    return torque


def with_knock(campaign, at_s: float, lasts_s: float):
    """Return a campaign with a knock in its first record."""
    record, *others = campaign.records
    (channel,) = record.data.channels
    data = replace(record.data, channels=(replace(channel, data=knock(channel.data, at_s, lasts_s)),))
    return replace(campaign, records=(replace(record, data=data), *others))
