"""Target of a fit: a record of the campaign with its measured channels, each in its own noise."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from mechid.arrays import IntArray
from mechid.campaign import CampaignRecord, Match
from mechid.campaign.campaign import CLOCK, TIME_OFFSET, is_of_start, record_parameter_name
from mechid.command import ClockReference, Command, Excitation
from mechid.command.timing import PPM
from mechid.identification.output_error.noise_level import NoiseSource, known_noise, rounding
from mechid.parameter import Parameter, Status
from mechid.signal.autoregression import Autoregression
from mechid.signal.series import Series, no_samples, stretch_of
from mechid.signal.trend import Line, fit_line
from mechid.simulation.simulator import TimeBase, excitation_over

Samples = IntArray


@dataclass(frozen=True, eq=False)
class TargetChannel:
    """One measured channel to be matched.

    Attributes
    ----------
    quantity : str
        One of those that the plant measures.
    measured : Series of n samples
        In the quantity's SI unit.
    sigma : float
        Standard deviation of its noise.
    linear : int
        0: nothing is projected out, 1: offset, 2: offset and drift.
    prefilter : Autoregression or None
        Model of its noise where that is whitened before it is weighted.
    rejected : (s,) of int
        Samples that do not count, ascending: those bridged, spikes, and those masked.
    bridged : (b,) of int
        Those among them that were never measured, or are burn-in.
    masked : (m,) of int
        Those among them that the search left out, as the model follows the record around them and not there.
    rounding : float
        Standard deviation of a uniform error of the resolution q that is declared, q/sqrt(12); 0 where none is.
    rests_on : NoiseSource
        What `sigma` rests on.
    raised : float
        Level to which the search raised the noise to follow the record, 0 where it did not.
    turns : tuple of float
        Lines that are projected out too, such as mains hum, in turns a sample.
    """

    quantity: str
    measured: Series
    sigma: float
    linear: int = 2
    prefilter: Autoregression | None = None
    rejected: Samples = field(default_factory=no_samples)
    rounding: float = 0.0
    bridged: Samples = field(default_factory=no_samples)
    masked: Samples = field(default_factory=no_samples)
    rests_on: NoiseSource = NoiseSource.FLOOR
    raised: float = 0.0
    turns: tuple[float, ...] = ()

    @property
    def removed(self) -> int:
        """Number of columns that are projected out."""
        return self.linear + 2 * len(self.turns)

    def line(self, series: Series, rejected: Samples) -> Line:
        """Return what is projected out of a series of it."""
        return fit_line(series, self.linear, rejected, self.turns)

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
        measured = stretch_of(self.measured, 0, samples)
        rejected, bridged, masked = (some[some < samples] for some in (self.rejected, self.bridged, self.masked))
        return replace(self, measured=measured, rejected=rejected, bridged=bridged, masked=masked)


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
        Its step edges, also for the largest time offset and clock in reach. They are large: worked out once, held once.
    own : tuple of Parameter
        What is the record's own, known and free: its time offset, its clock, values of the mechanism, states of its
        start. What several targets have under one name is one parameter that they share.
    burn_in : int
        Samples at its beginning that do not count.
    clock_reference : {"recorder", "driver"}
        Whose time is the true one, where the two clocks differ.
    """

    name: str
    channels: tuple[TargetChannel, ...]
    base: TimeBase
    command: Command
    excitation: Excitation
    own: tuple[Parameter, ...] = ()
    burn_in: int = 0
    clock_reference: ClockReference = "recorder"

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
    def clocks(self) -> tuple[Parameter, ...]:
        """By how many ppm the driver's clock runs faster than the recorder's: what all share and its own, which add."""
        return tuple(filter(is_clock, self.own))

    @property
    def latest_s(self) -> float:
        """The largest |time offset| that it may come to, a clock's at its end among them, s."""
        return latest_of(self.own, self.base)

    def with_own(self, *own: Parameter) -> Target:
        """Return the target with further parameters of its own, its edges as far as these reach."""
        other = replace(self, own=(*self.own, *own))
        if other.latest_s == self.latest_s:
            return other
        return replace(other, excitation=excitation_over(self.command, self.base, other.latest_s))

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
        base = self.base.truncate(samples)
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
        excitation=excitation_over(record.command, base, latest_of(record.parameters, base)),
        own=record.parameters,
        burn_in=burn_in_of(record),
        clock_reference=record.clock_reference,
    )


def burn_in_of(record: CampaignRecord) -> int:
    """Return how many samples at a record's beginning are simulated and do not count."""
    assert record.data is not None
    return math.ceil(record.burn_in_s * record.data.sample_rate_hz - 1e-6)


def is_time_offset(parameter: Parameter) -> bool:
    """Tell whether a parameter of a record's own is its time offset."""
    return parameter.declaration.key == TIME_OFFSET.key


def is_clock(parameter: Parameter) -> bool:
    """Tell whether a parameter of a record's own is its clock's."""
    return parameter.declaration.key == CLOCK.key


def latest_of(own: Iterable[Parameter], base: TimeBase) -> float:
    """Return how far a record's own parameters, known and free, may shift it at most, s."""
    end_s = abs(base.start_s) + base.samples * base.interval_s
    shifts = {TIME_OFFSET.key: 1.0, CLOCK.key: PPM * end_s}
    return sum(_largest(q) * shifts.get(q.declaration.key, 0.0) for q in own)


def _largest(parameter: Parameter) -> float:
    return max(abs(parameter.min), abs(parameter.max)) if parameter.is_free else abs(parameter.value)


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
        turns=tuple(hz / record.data.sample_rate_hz for hz in match.lines_hz),
        rounding=rounding(record, match),
        rejected=left_out,
        bridged=left_out,
    )
