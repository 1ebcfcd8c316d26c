"""The noise of each channel of a record: as it was known, and as the fit leaves it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mechid.campaign import CampaignRecord, Match
from mechid.identification.output_error.noise_level import NoiseLevel, NoiseSource, known_noise
from mechid.identification.output_error.target import Target, TargetChannel


@dataclass(frozen=True)
class ChannelNoise:
    """Noise of a channel.

    Attributes
    ----------
    known : NoiseLevel
        Before the fit.
    found : NoiseLevel
        The same, or the residual's RMS where the search raised the level.
    follows : float
        Standard deviation by which it is judged how far the model follows the record, in the SI unit.
    """

    known: NoiseLevel
    found: NoiseLevel
    follows: float


def channel_noises(record: CampaignRecord, targets: Sequence[Target]) -> dict[str, ChannelNoise]:
    """Return the noise of a record's channels by quantity, with the targets as the fit leaves them.

    What is not fitted takes the level to which its quantity was raised in all that is fitted.
    """
    return {match.quantity: _channel_noise(record, match, targets) for match in record.matches}


def _channel_noise(record: CampaignRecord, match: Match, targets: Sequence[Target]) -> ChannelNoise:
    known = known_noise(record, match)
    loudest = max(_like(record, match, targets), key=lambda c: c.raised, default=None)
    if loudest is None or known.rests_on is NoiseSource.DECLARED or loudest.sigma <= known.sigma:
        return ChannelNoise(known, known, known.sigma)
    return ChannelNoise(known, NoiseLevel(loudest.sigma, NoiseSource.RESIDUAL), loudest.raised)


def _like(record: CampaignRecord, match: Match, targets: Sequence[Target]) -> list[TargetChannel]:
    """Return the raised channels whose noise is that of a match: its own, or where it is not fitted all of its kind."""
    fitted = [(t.name, c) for t in targets for c in t.channels if c.quantity == match.quantity]
    alike = [c for name, c in fitted if name == record.name] or [c for _, c in fitted]
    return alike if all(c.raised > 0.0 for c in alike) else []
