"""Result of one record: how well the fit predicts it, and how it was taken."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from mechid.identification.output_error.declaration import DECLARED, Reading
from mechid.identification.result.channel_fit import ChannelFit
from mechid.identification.result.nuisance import Nuisance


@dataclass(frozen=True, kw_only=True)
class RecordFit:
    """How well one record is predicted; where it has several channels, its leading one, the torque if it is there.

    Attributes
    ----------
    fit_percent : float
        100 (1 - ||residual|| / ||measured - mean||), offset and drift removed from both.
    residual_rms, noise_sigma : float
        In the channel's SI unit. The noise is that of the record itself, as of `ChannelFit`.
    offset, drift : float or None
        At the first sample, and per second: measured = model + offset + drift t. None where not removed.
    samples : int
        Samples used.
    horizon_s : float
        How far the residual stays within what the noise explains, s from the first sample; a small lack ends it early.
    prefilter_order : int
        Of the autoregressive model that whitened its residual; 0 where none did.
    rejected : int
        Samples that do not count.
    channels : mapping of quantity to ChannelFit
        Each of its channels, the leading one first.
    taken : Reading
        How it was taken, where that is not as the campaign file declares it.
    nuisance : Nuisance or None
        Of a held-out record, what was fitted on its first part; its other figures are of the rest then.
    followed_of_whole : float or None
        Percent of the whole record that the model follows, as of `followed_percent`; None: that of the samples used.
    validation : mapping or None
        The table of that name in estimate.json, of a fit that was read; `mechid.analysis.fit_residuals` reads it.
    """

    name: str
    use: str
    samples: int
    fit_percent: float
    residual_rms: float
    noise_sigma: float
    offset: float | None
    drift: float | None
    horizon_s: float
    prefilter_order: int = 0
    rejected: int = 0
    channels: Mapping[str, ChannelFit] = field(default_factory=dict)
    taken: Reading = DECLARED
    nuisance: Nuisance | None = None
    followed_of_whole: float | None = None
    validation: Mapping[str, Any] | None = field(default=None, compare=False, repr=False)

    @property
    def followed_percent(self) -> float:
        """Share of the whole record in windows that the model follows, of the channel that it follows least."""
        if self.followed_of_whole is not None:
            return self.followed_of_whole
        return min((c.followed_percent for c in self.channels.values()), default=100.0)

    @property
    def residual_over_noise(self) -> float:
        """Ratio of the residual's RMS to the noise as known before the fit, of the leading channel."""
        return self.residual_rms / self.noise_known if self.noise_known > 0.0 else math.inf

    @property
    def lines(self) -> tuple[float, ...]:
        """Frequency in Hz of each line that was removed of the leading channel."""
        channel = next(iter(self.channels.values()), None)
        return tuple(hz for hz, _, _ in channel.lines) if channel else ()

    def residual_of(self, quantity: str) -> float:
        """Return the residual's RMS of a channel, in its SI unit."""
        own = self.channels.get(quantity)
        return own.residual_rms if own else self.residual_rms

    @property
    def noise_rests_on(self) -> str:
        """What the noise of the leading channel rests on, empty where that is not known."""
        return next((c.noise_rests_on for c in self.channels.values()), "")

    @property
    def noise_known(self) -> float:
        """The noise of the leading channel as known before the fit."""
        return next((c.known for c in self.channels.values()), self.noise_sigma)

    def known_noise_of(self, quantity: str) -> float:
        """Return the noise of a channel as known before the fit, in its SI unit."""
        own = self.channels.get(quantity)
        return own.known if own else self.noise_sigma

    def to_dict(self) -> dict[str, object]:
        """Return what estimate.json says of it."""
        return {
            "use": self.use,
            "samples": self.samples,
            "fit_percent": self.fit_percent,
            "residual_rms": self.residual_rms,
            "noise_sigma": self.noise_sigma,
            "offset": self.offset,
            "drift": self.drift,
            "horizon_s": self.horizon_s,
            "prefilter_order": self.prefilter_order,
            "rejected": self.rejected,
            "noise_rests_on": self.noise_rests_on,
            "noise_known": self.noise_known,
            "followed_percent": self.followed_percent,
            "residual_over_noise": self.residual_over_noise,
            "channels": {quantity: asdict(c) for quantity, c in self.channels.items()},
            "taken": self.taken.to_dict(),
            "nuisance": self.nuisance.to_dict() if self.nuisance else None,
        }
