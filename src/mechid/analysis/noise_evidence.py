"""Noise level of a channel as known without a model, and its evidence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from mechid.analysis.settings import RESIDUAL
from mechid.records import Channel
from mechid.signal import noise_floor
from mechid.signal.quiet import QuietStretch, quiet_rms
from mechid.signal.resolution import resolution


@dataclass(frozen=True, kw_only=True)
class NoiseEvidence:
    """What is known of the noise of a channel, in its unit.

    Attributes
    ----------
    sigma : float
        What it is taken to be: the largest that any of the following tells.
    rests_on : str
        ``"floor"``, ``"quiet stretch"`` or ``"resolution"``.
    floor : float
        Of white noise, in the upper part of the band.
    quiet : float or None
        RMS of the quietest stretches in which nothing is driven, with all colour.
    resolution : float
        Step in which the samples are written, 0 where there is none.
    """

    sigma: float
    rests_on: str
    floor: float
    quiet: float | None
    resolution: float


def noise_evidence(channel: Channel, sample_rate_hz: float, quiet: Sequence[QuietStretch]) -> NoiseEvidence:
    """Return what is known of the noise of a channel, with the stretches in which nothing moves."""
    y, step = channel.data, resolution(channel.data)
    floor = noise_floor(y, sample_rate_hz, rejected=channel.bridged)
    quietest = quiet_rms(quiet)
    sigmas = {"floor": floor, "resolution": step / math.sqrt(12.0)}
    if quietest is not None and quietest > RESIDUAL.readings_agree * floor:
        sigmas["quiet stretch"] = quietest
    rests_on = max(sigmas, key=lambda key: sigmas[key])
    return NoiseEvidence(sigma=sigmas[rests_on], rests_on=rests_on, floor=floor, quiet=quietest, resolution=step)
