"""Noise level of a channel before any fit, and its source."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from mechid.campaign import CampaignRecord, Match
from mechid.identification.output_error.settings import PROBLEM
from mechid.signal.moments import standard_deviation

SMALLEST, LARGEST = 1e-150, 1e150
"""Levels in any unit whose squares are ordinary numbers."""


class NoiseSource(StrEnum):
    """Source of a noise level; the value is the text in reports."""

    DECLARED = "declared"
    QUIET = "quiet stretch"
    FLOOR = "high-frequency floor"
    RESOLUTION = "resolution"
    RESIDUAL = "residual"


@dataclass(frozen=True)
class NoiseLevel:
    """Standard deviation of a channel's noise in its SI unit, and its source."""

    sigma: float
    rests_on: NoiseSource


def known_noise(record: CampaignRecord, match: Match) -> NoiseLevel:
    """Return the noise of a channel: declared, measured in quiet stretches, or its high-frequency floor.

    It is at least the noise of the declared resolution: where a signal is constant or slow, its rounding error has no
    high frequencies, but exists all the same.
    """
    assert record.data is not None
    channel = record.data.channel(match.quantity)
    own, resolution = _own_level(record, match), rounding_sigma(record, match)
    source = NoiseSource.RESOLUTION if resolution > own.sigma else own.rests_on
    least = max(PROBLEM.least_noise_share * standard_deviation(channel.data), resolution, SMALLEST)
    return NoiseLevel(min(max(own.sigma, least), LARGEST), source)


def _own_level(record: CampaignRecord, match: Match) -> NoiseLevel:
    """Return the declared or measured noise of a channel."""
    assert record.data is not None
    channel = record.data.channel(match.quantity)
    if match.noise_sigma is not None:
        return NoiseLevel(abs(channel.scale) * match.noise_sigma, NoiseSource.DECLARED)
    quiet = record.data.quiet_rms(match.quantity)
    if quiet is not None:
        return NoiseLevel(quiet, NoiseSource.QUIET)
    return NoiseLevel(record.data.noise_floor(match.quantity), NoiseSource.FLOOR)


def rounding_sigma(record: CampaignRecord, match: Match) -> float:
    """Return the standard deviation of the rounding error of the declared resolution, SI; 0 if none is declared."""
    assert record.data is not None
    return abs(record.data.channel(match.quantity).scale) * match.quantisation / math.sqrt(12.0)
