"""What is to be matched: a record of the campaign with its measured channels, each in its own noise."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mechid.campaign import CampaignRecord, Match
from mechid.command import Command, Excitation
from mechid.parameter import Parameter
from mechid.signal import noise_floor
from mechid.signal.autoregression import Autoregression
from mechid.signal.series import no_samples
from mechid.simulation.simulator import TimeBase, excitation_over

FloatArray = NDArray[np.float64]
Samples = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class TargetChannel:
    """One measured channel to be matched.

    Attributes
    ----------
    quantity : str
        One of those that the plant measures.
    measured : (n,)
        In the quantity's SI unit.
    sigma : float
        Standard deviation of its noise.
    linear : int
        0: nothing is projected out, 1: offset, 2: offset and drift.
    prefilter : Autoregression or None
        Model of its noise where that is whitened before it is weighted.
    rejected : (s,) of int
        Samples that do not count, ascending: those bridged, and spikes.
    bridged : (b,) of int
        Those among them that were never measured.
    rounding : float
        Standard deviation of a uniform error of the resolution q that is declared, q/sqrt(12); 0 where none is.
    """

    quantity: str
    measured: FloatArray
    sigma: float
    linear: int = 2
    prefilter: Autoregression | None = None
    rejected: Samples = field(default_factory=no_samples)
    rounding: float = 0.0
    bridged: Samples = field(default_factory=no_samples)

    @property
    def scale(self) -> float:
        """Standard deviation of what is left of the noise behind the prefilter."""
        return self.prefilter.sigma if self.prefilter else self.sigma

    @property
    def rounded(self) -> float:
        """Share of the noise's variance that is rounding; none of it behind a prefilter, which takes it for colour."""
        return 0.0 if self.prefilter else min((self.rounding / self.sigma) ** 2, 1.0)

    @property
    def order(self) -> int:
        """Number of past samples that the prefilter remembers."""
        return self.prefilter.order if self.prefilter else 0

    def rejected_within(self, window: tuple[int, int]) -> Samples:
        """Return the samples of a window, counted from its first, that do not count."""
        return self.rejected[(self.rejected >= window[0]) & (self.rejected < window[1])] - window[0]

    def first(self, samples: int) -> TargetChannel:
        """Return the first samples alone."""
        rejected, bridged = (some[some < samples] for some in (self.rejected, self.bridged))
        return replace(self, measured=self.measured[:samples], rejected=rejected, bridged=bridged)


@dataclass(frozen=True, eq=False)
class Target:
    """One record to be matched: a run of the model, and the channels that it has to explain.

    Attributes
    ----------
    name : str
    channels : tuple of TargetChannel
        The leading one first: the torque where it is among them.
    base : TimeBase
    command : Command
    excitation : Excitation
        Its step edges, also for the largest time offset in reach. They are large: worked out once, held once.
    time_offset_s : float
        Known time offset, s; where it is free, its start.
    time_offset_bounds : (float, float) or None
        Bounds where it is free.
    stand : tuple of Parameter
        Its own parameters of the test stand, known and free.
    """

    name: str
    channels: tuple[TargetChannel, ...]
    base: TimeBase
    command: Command
    excitation: Excitation
    time_offset_s: float = 0.0
    time_offset_bounds: tuple[float, float] | None = None
    stand: tuple[Parameter, ...] = ()

    @property
    def samples(self) -> int:
        """Number of samples of each channel."""
        return self.base.samples

    @property
    def leading(self) -> TargetChannel:
        """The first channel."""
        return self.channels[0]

    @cached_property
    def quantities(self) -> tuple[str, ...]:
        """What its channels measure."""
        return tuple(channel.quantity for channel in self.channels)

    @cached_property
    def moved(self) -> tuple[Parameter, ...]:
        """Its own parameters of the test stand that are free."""
        return tuple(q for q in self.stand if q.is_free)

    def each(self, change: Callable[[TargetChannel], TargetChannel]) -> Target:
        """Return the target with every channel changed; the same one where none is."""
        channels = tuple(map(change, self.channels))
        unchanged = all(a is b for a, b in zip(channels, self.channels, strict=True))
        return self if unchanged else replace(self, channels=channels)

    def beginning(self, samples: int) -> Target:
        """Return the first samples of all channels."""
        base = self.base.first(samples)
        return replace(self.each(lambda channel: channel.first(base.samples)), base=base)


def target_of(record: CampaignRecord) -> Target:
    """Return a record as a target, each channel with the noise of its high-frequency floor."""
    data = record.data
    assert data is not None
    delay = record.time_offset
    latest_s = max(abs(delay.min), abs(delay.max)) if delay.is_free else abs(delay.value)
    base = TimeBase(data.sample_rate_hz, data.samples, data.time_start_s)
    return Target(
        name=record.name,
        channels=tuple(channel_of(record, match) for match in record.estimated),
        base=base,
        command=record.command,
        excitation=excitation_over(record.command, base, latest_s),
        time_offset_s=delay.value,
        time_offset_bounds=(delay.min, delay.max) if delay.is_free else None,
        stand=record.test_stand,
    )


def channel_of(record: CampaignRecord, match: Match) -> TargetChannel:
    """Return one channel of a record as it is to be matched."""
    assert record.data is not None
    channel = record.data.channel(match.quantity)
    return TargetChannel(
        quantity=match.quantity,
        measured=channel.data,
        sigma=noise_sigma(record, match),
        linear=(2 if match.drift else 1) if match.offset else 0,
        rounding=_rounding(record, match),
        rejected=channel.bridged,
        bridged=channel.bridged,
    )


def noise_sigma(record: CampaignRecord, match: Match) -> float:
    """Return the noise of a channel in its SI unit: the one declared, that of its quiet stretches, or its floor.

    A floor is never below that of the resolution that is declared: where a signal stands still or runs slowly, its
    rounding has no high frequencies, and is there all the same.
    """
    assert record.data is not None
    channel = record.data.channel(match.quantity)
    least = max(1e-6 * float(np.std(channel.data)), _rounding(record, match))
    if match.noise_sigma is not None:
        return max(abs(channel.scale) * match.noise_sigma, least)
    quiet = record.data.quiet_rms(match.quantity)
    if quiet is not None:
        return max(quiet, least)
    return max(noise_floor(channel.data, record.data.sample_rate_hz, rejected=channel.bridged), least)


def _rounding(record: CampaignRecord, match: Match) -> float:
    assert record.data is not None
    return abs(record.data.channel(match.quantity).scale) * match.quantisation / math.sqrt(12.0)
