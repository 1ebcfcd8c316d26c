"""Model-free estimate of the noise level of a channel."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from mechid.analysis.settings import RESIDUAL
from mechid.records import Channel
from mechid.signal import noise_floor
from mechid.signal.quiet_stretches import QuietStretch, quiet_rms
from mechid.signal.resolution import resolution


@dataclass(frozen=True, kw_only=True)
class NoiseEvidence:
    """Noise level of a channel in its unit, with the evidence for it.

    Attributes
    ----------
    sigma : float
        The noise level: the largest of the following estimates.
    rests_on : str
        ``"floor"``, ``"quiet stretch"`` or ``"resolution"``.
    floor : float
        Level of white noise, from the upper part of the band.
    quiet : float or None
        RMS of the quietest stretches without motion, including coloured noise.
    resolution : float
        Quantisation step of the samples, 0 if none is found.
    """

    sigma: float
    rests_on: str
    floor: float
    quiet: float | None
    resolution: float


def noise_evidence(channel: Channel, sample_rate_hz: float, quiet: Sequence[QuietStretch]) -> NoiseEvidence:
    """Estimate the noise level of a channel from its spectrum, its resolution and stretches without motion."""
    y, step = channel.data, resolution(channel.data)
    floor = noise_floor(y, sample_rate_hz, rejected=channel.bridged)
    quietest = quiet_rms(quiet)
    # The error of uniform quantisation has the standard deviation step / sqrt(12).
    sigmas = {"floor": floor, "resolution": step / math.sqrt(12.0)}
    if quietest is not None and quietest > RESIDUAL.readings_agree * floor:
        sigmas["quiet stretch"] = quietest
    rests_on = max(sigmas, key=lambda key: sigmas[key])
    return NoiseEvidence(sigma=sigmas[rests_on], rests_on=rests_on, floor=floor, quiet=quietest, resolution=step)
