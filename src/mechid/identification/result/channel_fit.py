"""Fit of one channel of a record: how well the model predicts it, and against which noise."""

from __future__ import annotations

import math
from dataclasses import dataclass

from mechid.signal.runs import Runs


@dataclass(frozen=True, kw_only=True)
class ChannelFit:
    """How well one channel of a record is predicted, in the SI unit `unit`.

    Attributes
    ----------
    use : {"estimate", "validate"}
        Whether it was fitted, or only compared.
    fit_percent : float
        100 (1 - ||residual|| / ||measured - mean||), offset and drift removed from both.
    residual_rms, noise_sigma : float
        The noise is that of the channel itself: declared, or from quiet stretches, its high-frequency floor, its
        resolution; where growth stalled at that level, the residual's RMS.
    offset, drift : float or None
        At the first sample, and per second: measured = model + offset + drift t. None where not removed.
    quantisation : float
        Resolution as declared, 0 where it is not.
    prefilter_order : int
        Of the autoregressive model that whitened its residual; 0 where none did.
    rejected : int
        Samples that do not count, of those used.
    rejected_runs : tuple of (int, int)
        All samples that do not count, bridged gaps and spikes: first and last-plus-one of each run.
    noise_rests_on : str
        A `NoiseSource`'s words; empty in files of versions before it was written.
    noise_known : float or None
        The noise as known before the fit, the same as `noise_sigma` unless that rests on the residual; None as above.
    followed_percent : float
        Share of the samples used that lie in windows of 50 ms that the model follows (`signal.following`).
    lost_at_s : float or None
        Record time at which the first window begins that it does not follow; None where it follows all.
    worst_at_s, worst : float
        Where the residual is largest beside what is allowed there, and how many times that it is.
    out_of_step_at_s : float or None
        Record time at which an angle has left the one modelled by two full steps; None where it has not.
    lines : tuple of (float, float, float)
        Lines that were removed, such as mains hum: Hz, amplitude, phase in rad of the cosine at the first sample.
    """

    unit: str
    use: str
    fit_percent: float
    residual_rms: float
    noise_sigma: float
    offset: float | None
    drift: float | None
    quantisation: float = 0.0
    prefilter_order: int = 0
    rejected: int = 0
    rejected_runs: Runs = ()
    noise_rests_on: str = ""
    noise_known: float | None = None
    followed_percent: float = 100.0
    lost_at_s: float | None = None
    worst_at_s: float = 0.0
    worst: float = 0.0
    out_of_step_at_s: float | None = None
    lines: tuple[tuple[float, float, float], ...] = ()

    @property
    def known(self) -> float:
        """The noise as known before the fit."""
        return self.noise_sigma if self.noise_known is None else self.noise_known

    @property
    def residual_over_noise(self) -> float:
        """Ratio of the residual's RMS to the noise: that known before the fit, or the level raised above it."""
        level = max(self.known, self.noise_sigma)
        return self.residual_rms / level if level > 0.0 else math.inf

    @property
    def followed(self) -> bool:
        """Whether the model follows it to its end."""
        return self.lost_at_s is None and self.out_of_step_at_s is None
