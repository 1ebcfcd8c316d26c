"""Target of a fit: a record of the campaign with its measured channels and their noise."""

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
from mechid.identification.output_error.noise_level import NoiseSource, known_noise, rounding_sigma
from mechid.parameter import Parameter, Status
from mechid.signal.autoregression import Autoregression
from mechid.signal.series import Series, no_samples, stretch_of
from mechid.signal.trend import Line, fit_line
from mechid.simulation.simulator import TimeBase, excitation_over

Samples = IntArray


@dataclass(frozen=True, eq=False)
class TargetChannel:
    """Measured channel to be matched.

    Attributes
    ----------
    quantity : str
        One of the quantities that the plant measures.
    measured : Series of n samples
        In the quantity's SI unit.
    sigma : float
        Standard deviation of its noise.
    linear : int
        0: nothing is projected out, 1: offset, 2: offset and drift.
    prefilter : Autoregression or None
        Model of its noise, if the noise is whitened before it is weighted.
    rejected : (s,) of int
        Excluded samples, ascending: bridged ones, spikes and masked ones.
    bridged : (b,) of int
        Rejected samples that were never measured, or are burn-in.
    masked : (m,) of int
        Rejected samples that the search excluded, because the model follows the record around them but not there.
    rounding : float
        Standard deviation q/sqrt(12) of the rounding error of a declared resolution q; 0 if none is declared.
    rests_on : NoiseSource
        Source of `sigma`.
    raised : float
        Level to which the search raised the noise to follow the record, 0 if it did not.
    turns : tuple of float
        Frequencies of lines that are projected out too, such as mains hum, in turns per sample.
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
    def projected_columns(self) -> int:
        """Number of columns that are projected out."""
        return self.linear + 2 * len(self.turns)

    def line(self, series: Series, rejected: Samples) -> Line:
        """Return the projected offset, drift and lines of a series of this channel."""
        return fit_line(series, self.linear, rejected, self.turns)

    @property
    def scale(self) -> float:
        """Standard deviation of the noise after the prefilter."""
        return self.prefilter.sigma if self.prefilter else self.sigma

    @property
    def rounding_share(self) -> float:
        """Share of the noise variance that is rounding error.

        0 with a prefilter, which models the rounding error as coloured noise.
        """
        return 0.0 if self.prefilter else min((self.rounding / self.sigma) ** 2, 1.0)

    @property
    def order(self) -> int:
        """Number of past samples that the prefilter remembers."""
        return self.prefilter.order if self.prefilter else 0

    def rejected_within(self, window: tuple[int, int]) -> Samples:
        """Return the rejected samples of a window, counted from its first sample."""
        return self.rejected[(self.rejected >= window[0]) & (self.rejected < window[1])] - window[0]

    def truncate(self, samples: int) -> TargetChannel:
        """Return the channel with its first samples only."""
        measured = stretch_of(self.measured, 0, samples)
        rejected, bridged, masked = (some[some < samples] for some in (self.rejected, self.bridged, self.masked))
        return replace(self, measured=measured, rejected=rejected, bridged=bridged, masked=masked)


@dataclass(frozen=True, eq=False)
class Target:
    """Record to be matched: a run of the model, and the channels that it must explain.

    Attributes
    ----------
    name : str
    channels : tuple of TargetChannel
        The leading one first: the torque if it is among them.
    base : TimeBase
    command : Command
    excitation : Excitation
        Step edges, also for the largest time offset and clock error in reach. They are large, so they are computed and
        stored once.
    own : tuple of Parameter
        Record parameters, known and free: time offset, clock, values of the mechanism, start states. A parameter that
        several targets have under one name is shared by them.
    burn_in : int
        Number of samples at the beginning that are not compared.
    clock_reference : {"recorder", "driver"}
        Clock that shows the true time, if the two clocks differ.
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
        """First channel."""
        return self.channels[0]

    @cached_property
    def quantities(self) -> tuple[str, ...]:
        """Quantities of its channels."""
        return tuple(channel.quantity for channel in self.channels)

    @property
    def free_parameters(self) -> tuple[Parameter, ...]:
        """Free record parameters."""
        return tuple(q for q in self.own if q.is_free)

    @property
    def begins_in_motion(self) -> bool:
        """Whether the run begins within the command, in a state that is to be found."""
        return self.command.begun_s > 0.0 and any(map(is_of_start, self.free_parameters))

    @property
    def time_offset(self) -> Parameter:
        """Record time in s at which the command starts; 0 if the record has no time offset of its own."""
        return next(filter(is_time_offset, self.own), time_offset_of(self.name, 0.0))

    @property
    def clocks(self) -> tuple[Parameter, ...]:
        """Excess of the driver's clock over the recorder's in ppm: the shared and the record's own one, which add."""
        return tuple(filter(is_clock, self.own))

    @property
    def latest_s(self) -> float:
        """Largest absolute time offset in reach, including the clock's at the end of the record, s."""
        return latest_of(self.own, self.base)

    def add_parameters(self, *own: Parameter) -> Target:
        """Return the target with further record parameters, and step edges for their whole range."""
        other = replace(self, own=(*self.own, *own))
        if other.latest_s == self.latest_s:
            return other
        return replace(other, excitation=excitation_over(self.command, self.base, other.latest_s))

    def with_time_offset(self, offset: Parameter) -> Target:
        """Return the target with another time offset."""
        return replace(self, own=(offset, *(q for q in self.own if not is_time_offset(q))))

    def fix_parameters(self, values: Mapping[str, float]) -> Target:
        """Return the target with the named record parameters fixed at `values`."""
        held = (replace(q, value=values[q.name], status=Status.KNOWN) if q.name in values else q for q in self.own)
        return replace(self, own=tuple(held))

    @property
    def with_fixed_parameters(self) -> Target:
        """The target with all record parameters fixed at their values."""
        return self.fix_parameters({q.name: q.value for q in self.own})

    def map_channels(self, change: Callable[[TargetChannel], TargetChannel]) -> Target:
        """Return the target with a function applied to every channel; the target itself if nothing changes."""
        channels = tuple(map(change, self.channels))
        unchanged = all(a is b for a, b in zip(channels, self.channels, strict=True))
        return self if unchanged else replace(self, channels=channels)

    def truncate(self, samples: int) -> Target:
        """Return the target with the first samples of all channels only."""
        base = self.base.truncate(samples)
        return replace(self.map_channels(lambda channel: channel.truncate(base.samples)), base=base)


def target_of(record: CampaignRecord) -> Target:
    """Return a record as a target, with the known noise of each channel."""
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
    """Return the number of samples at a record's beginning that are simulated but not compared."""
    assert record.data is not None
    return math.ceil(record.burn_in_s * record.data.sample_rate_hz - 1e-6)


def is_time_offset(parameter: Parameter) -> bool:
    """Tell whether a record parameter is its time offset."""
    return parameter.declaration.key == TIME_OFFSET.key


def is_clock(parameter: Parameter) -> bool:
    """Tell whether a record parameter is a clock error."""
    return parameter.declaration.key == CLOCK.key


def latest_of(own: Iterable[Parameter], base: TimeBase) -> float:
    """Return the largest shift of a record by its parameters, known and free, s."""
    end_s = abs(base.start_s) + base.samples * base.interval_s
    shifts = {TIME_OFFSET.key: 1.0, CLOCK.key: PPM * end_s}
    return sum(_largest(q) * shifts.get(q.declaration.key, 0.0) for q in own)


def _largest(parameter: Parameter) -> float:
    return max(abs(parameter.min), abs(parameter.max)) if parameter.is_free else abs(parameter.value)


def time_offset_of(record: str, value: float, bounds: Sequence[float] = ()) -> Parameter:
    """Return a record's time offset, s, which is free if it has a lower and an upper bound."""
    name, status = record_parameter_name(record, TIME_OFFSET.key), Status.FREE if bounds else Status.KNOWN
    least, most = bounds or (-math.inf, math.inf)
    return Parameter(name=name, value=value, declaration=TIME_OFFSET, min=least, max=most, status=status)


def channel_of(record: CampaignRecord, match: Match) -> TargetChannel:
    """Return a channel of a record as a channel to be matched."""
    assert record.data is not None
    channel = record.data.channel(match.quantity)
    known = known_noise(record, match)
    # The burn-in counts as bridged, so that lifting masks can never let it count again.
    left_out = np.union1d(np.arange(burn_in_of(record)), channel.bridged)
    return TargetChannel(
        quantity=match.quantity,
        measured=channel.data,
        sigma=known.sigma,
        rests_on=known.rests_on,
        linear=(2 if match.drift else 1) if match.offset else 0,
        turns=tuple(hz / record.data.sample_rate_hz for hz in match.lines_hz),
        rounding=rounding_sigma(record, match),
        rejected=left_out,
        bridged=left_out,
    )
