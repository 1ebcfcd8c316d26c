"""What is to be matched: a record of the campaign with its measured channels, each in its own noise."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mechid.campaign import CampaignRecord, Match
from mechid.campaign.campaign import TIME_OFFSET, is_of_start, record_parameter_name
from mechid.command import Command, Excitation
from mechid.identification.output_error.noise_level import NoiseSource, known_noise, rounding
from mechid.parameter import Parameter, Status
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
        Those among them that were never measured, or are burn-in.
    rounding : float
        Standard deviation of a uniform error of the resolution q that is declared, q/sqrt(12); 0 where none is.
    rests_on : NoiseSource
        What `sigma` rests on.
    raised : float
        Level to which the search raised the noise to follow the record, 0 where it did not.
    """

    quantity: str
    measured: FloatArray
    sigma: float
    linear: int = 2
    prefilter: Autoregression | None = None
    rejected: Samples = field(default_factory=no_samples)
    rounding: float = 0.0
    bridged: Samples = field(default_factory=no_samples)
    rests_on: NoiseSource = NoiseSource.FLOOR
    raised: float = 0.0

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
    own : tuple of Parameter
        What is the record's own, known and free: its time offset, values of its test stand, states of its start.
    burn_in : int
        Samples at its beginning that do not count.
    """

    name: str
    channels: tuple[TargetChannel, ...]
    base: TimeBase
    command: Command
    excitation: Excitation
    own: tuple[Parameter, ...] = ()
    burn_in: int = 0

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

    @property
    def moved(self) -> tuple[Parameter, ...]:
        """Its own parameters that are free."""
        return tuple(q for q in self.own if q.is_free)

    @property
    def begins_in_motion(self) -> bool:
        """Whether its run begins within its command, in a state that is to be found."""
        return self.command.begun_s > 0.0 and any(map(is_of_start, self.moved))

    @property
    def time_offset(self) -> Parameter:
        """Record time in s at which its command starts; 0 where none is its own."""
        return next(filter(is_time_offset, self.own), time_offset_of(self.name, 0.0))

    @property
    def latest_s(self) -> float:
        """The largest |time offset| that it may come to, s."""
        return latest_of(self.time_offset)

    def with_time_offset(self, offset: Parameter) -> Target:
        """Return the target with another time offset."""
        return replace(self, own=(offset, *(q for q in self.own if not is_time_offset(q))))

    def holding(self, values: Mapping[str, float]) -> Target:
        """Return the target with those of its own parameters known that have a value here, by dotted name."""
        held = (replace(q, value=values[q.name], status=Status.KNOWN) if q.name in values else q for q in self.own)
        return replace(self, own=tuple(held))

    @property
    def settled(self) -> Target:
        """The target with all of its own parameters known, at their values."""
        return self.holding({q.name: q.value for q in self.own})

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
    """Return a record as a target, each channel with the noise that is known of it."""
    data = record.data
    assert data is not None
    base = TimeBase(data.sample_rate_hz, data.samples, data.time_start_s)
    return Target(
        name=record.name,
        channels=tuple(channel_of(record, match) for match in record.estimated),
        base=base,
        command=record.command,
        excitation=excitation_over(record.command, base, latest_of(record.time_offset)),
        own=record.parameters,
        burn_in=burn_in_of(record),
    )


def burn_in_of(record: CampaignRecord) -> int:
    """Return how many samples at a record's beginning are simulated and do not count."""
    assert record.data is not None
    return math.ceil(record.burn_in_s * record.data.sample_rate_hz - 1e-6)


def is_time_offset(parameter: Parameter) -> bool:
    """Tell whether a parameter of a record's own is its time offset."""
    return parameter.declaration.key == TIME_OFFSET.key


def latest_of(offset: Parameter) -> float:
    """Return the largest |time offset| in reach of a known or free one, s."""
    return max(abs(offset.min), abs(offset.max)) if offset.is_free else abs(offset.value)


def time_offset_of(record: str, value: float, bounds: Sequence[float] = ()) -> Parameter:
    """Return a record's time offset, s; with a lower and an upper bound it is free."""
    name, status = record_parameter_name(record, TIME_OFFSET.key), Status.FREE if bounds else Status.KNOWN
    least, most = bounds or (-math.inf, math.inf)
    return Parameter(name=name, value=value, declaration=TIME_OFFSET, min=least, max=most, status=status)


def channel_of(record: CampaignRecord, match: Match) -> TargetChannel:
    """Return one channel of a record as it is to be matched."""
    assert record.data is not None
    channel = record.data.channel(match.quantity)
    known = known_noise(record, match)
    left_out = np.union1d(np.arange(burn_in_of(record)), channel.bridged)
    return TargetChannel(
        quantity=match.quantity,
        measured=channel.data,
        sigma=known.sigma,
        rests_on=known.rests_on,
        linear=(2 if match.drift else 1) if match.offset else 0,
        rounding=rounding(record, match),
        rejected=left_out,
        bridged=left_out,
    )
