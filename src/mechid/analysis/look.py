"""Model-free examination of a record: data quality, noise, spectral lines, resonances and step rate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from mechid.analysis.attributed_lines import AttributedLine, attribute_line
from mechid.analysis.commanded_rate import commanded_rate
from mechid.analysis.measured_resonances import MeasuredResonance, measured_resonances
from mechid.analysis.named_orders import named_orders
from mechid.analysis.noise_evidence import NoiseEvidence, noise_evidence
from mechid.analysis.order_tracking import ORDERS, OrderLine, order_lines
from mechid.analysis.prediction import Travel
from mechid.analysis.settings import ORDER
from mechid.analysis.step_lines import NamedStepLine, StepLine, average_named, average_orders
from mechid.arrays import FloatArray, IntArray
from mechid.command import Command, MeasuredCommand, RateProfile, Timing
from mechid.identification.computation.parallel import one_core_algebra
from mechid.plant.mechanism import NamedLine
from mechid.records import Channel, Record
from mechid.records.step_rate import SuggestedRate, suggest_rate_without_hum
from mechid.signal import Band, power_density, third_octaves
from mechid.signal.clipping import clipped_runs
from mechid.signal.density import rms_below
from mechid.signal.lines import Line, Prominence, prominence, spectral_lines
from mechid.signal.mains import mains_lines
from mechid.signal.moments import mean, root_mean_square
from mechid.signal.quiet_stretches import QuietStretch, quiet_stretches
from mechid.signal.remainder import Remainder
from mechid.signal.runs import Runs, runs_of
from mechid.signal.series import Series
from mechid.signal.spectrogram import WINDOWS, spectrogram, usual_window_s
from mechid.signal.spikes import isolated_spikes
from mechid.signal.trend import Line as Trend
from mechid.signal.trend import fit_line
from mechid.simulation.simulator import TimeBase

MORE_ORDERS = (0.25, *ORDERS, 6.0, 8.0)
"""Orders of the step rate; a quarter, since the currents of a two-phase motor repeat after four full steps."""
SIXTHS = (1.0 / 6.0, 1.0 / 3.0, *ORDERS, 6.0, 8.0)
"""The same for three phases, whose currents repeat after six."""
DEFAULT_MICROSTEPS = 16


@dataclass(frozen=True, kw_only=True)
class Drive:
    """Declared drive of a record: its command, the record time in s at which that starts, and the mechanism's lines.

    `named` are the lines that the mechanism names, such as those of its tooth meshes.
    """

    command: Command
    time_offset_s: float = 0.0
    named: tuple[NamedLine, ...] = ()

    @property
    def is_stepped(self) -> bool:
        """Whether the command gives a step rate."""
        return not isinstance(self.command, MeasuredCommand) and any(self.command.rate.rates)


@dataclass(frozen=True, kw_only=True, eq=False)
class Waterfall:
    """Amplitude, (F, C), at frequencies (F,) Hz and record times (C,) s; step rate at these times or NaN, (C,)."""

    time_s: FloatArray
    frequency_hz: FloatArray
    amplitude: FloatArray
    rate: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class ChannelLook:
    """Examination of one channel, in its own unit; spectra and RMS exclude the mean."""

    channel: Channel
    mean: float
    rms: float
    drift: float
    gaps: Runs
    clipped: Runs
    spikes: IntArray
    quiet: tuple[QuietStretch, ...]
    noise: NoiseEvidence
    spectrum: Prominence
    density_hz: FloatArray
    density: FloatArray
    bands: tuple[Band, ...]
    below_rms: float
    lines: tuple[AttributedLine, ...]
    mains: tuple[AttributedLine, ...]
    step_lines: tuple[StepLine, ...]
    named_lines: tuple[NamedStepLine, ...]
    over_rate: tuple[OrderLine, ...]
    resonances: tuple[MeasuredResonance, ...]
    waterfall: Waterfall


@dataclass(frozen=True, kw_only=True, eq=False)
class RecordLook:
    """Examination of a record: declared drive, suggested step rate and channels.

    `constant_rate` is the step rate in full steps/s, declared or else suggested; None if it varies or is unknown.
    """

    record: Record
    declared: Drive | None
    suggested: SuggestedRate | None
    constant_rate: float | None
    base: TimeBase
    channels: tuple[ChannelLook, ...]

    @property
    def rate(self) -> RateProfile | None:
        """The declared step rate, else the suggested one; None if unknown."""
        if self.declared:
            return self.declared.command.rate
        return self.suggested.profile if self.suggested else None


def look_at(record: Record, declared: Drive | None = None) -> RecordLook:
    """Examine a record without a model.

    Parameters
    ----------
    record : Record
    declared : Drive or None
        Declared drive; ignored if it gives no step rate.

    Examples
    --------
    >>> from mechid.records import RecordSpec, read_record
    >>> record = read_record(path, RecordSpec(name="a", path="a.csv"))  # doctest: +SKIP
    >>> look_at(record).channels[0].noise.sigma  # doctest: +SKIP
    """
    # Extreme sample values overflow in the spectra, whose values are then not finite; no warning is needed.
    with one_core_algebra(), np.errstate(all="ignore"):
        return _look_at(record, declared)


def _look_at(record: Record, declared: Drive | None) -> RecordLook:
    base = TimeBase(record.sample_rate_hz, record.samples, record.time_start_s)
    declared = declared if declared and declared.is_stepped else None
    spectra = [prominence(c.data, record.sample_rate_hz) for c in record.channels]
    lines = [spectral_lines(spectrum) for spectrum in spectra]
    each = list(zip(record.channels, spectra, lines, strict=True))
    torque_first = sorted(each, key=lambda one: one[0].quantity != "torque")
    suggestions = (suggest_rate_without_hum(c.data, spectrum, found) for c, spectrum, found in torque_first)
    suggested = next((one for one in suggestions if one), None)
    travel = _travel(declared, suggested, base)
    steps = _microsteps(declared, suggested)
    named = declared.named if declared else ()
    period = declared.command.full_steps if declared else ORDER.quarters
    channels = [_channel(c, spectrum, found, travel, base, (steps, period), named) for c, spectrum, found in each]
    return RecordLook(
        record=record,
        declared=declared,
        suggested=suggested,
        constant_rate=_constant_rate(travel),
        base=base,
        channels=tuple(channels),
    )


def _travel(declared: Drive | None, suggested: SuggestedRate | None, base: TimeBase) -> Travel | None:
    if declared:
        return Travel(declared.command.rate, base, Timing(declared.time_offset_s))
    return Travel(suggested.profile, base, Timing(base.start_s)) if suggested else None


def _microsteps(declared: Drive | None, suggested: SuggestedRate | None) -> int:
    """Return the microsteps per full step: declared, else suggested, else the default."""
    if declared:
        return declared.command.microsteps
    return (suggested.microsteps if suggested else None) or DEFAULT_MICROSTEPS


def rate_at(travel: Travel, times_s: FloatArray) -> FloatArray:
    """Return the magnitude of the step rate at record times, (C,), full steps/s; 0 before the start."""
    since = travel.timing.command_s(times_s)
    rate = np.abs(np.interp(since, travel.rate.times_s, travel.rate.rates))
    return np.asarray(np.where(since < 0.0, 0.0, rate), dtype=np.float64)


def _constant_rate(travel: Travel | None) -> float | None:
    """Return the magnitude of a constant rate, None if the rate varies over the record."""
    if travel is None:
        return None
    rate = commanded_rate(travel.rate, travel.timing.offset_s, travel.base)
    return abs(float(rate[0, 1])) if len(rate) == 1 else None


def _channel(
    channel: Channel,
    spectrum: Prominence,
    lines: Sequence[Line],
    travel: Travel | None,
    base: TimeBase,
    steps_and_period: tuple[int, int],
    named: Sequence[NamedLine],
) -> ChannelLook:
    """Examine a channel; the driver's microsteps a full step and full steps an electrical period give its orders."""
    (steps, period), fs = steps_and_period, base.sample_rate_hz
    line = fit_line(channel.data, 2)
    middle = mean(channel.data)
    y = Remainder(channel.data, Trend(middle))
    frequency, density = power_density(y, fs)
    bands = third_octaves(frequency, density)
    quiet = quiet_stretches(channel.data, fs)
    noise = noise_evidence(channel, fs, [one for one in quiet if _is_at_rest(one, travel, steps)])
    constant = _constant_rate(travel)
    level = Remainder(channel.data, line)
    usual = SIXTHS if period == 6 else MORE_ORDERS
    orders = (*usual, float(steps)) if steps > max(usual) else usual
    # Orders are defined by the travel, so without a rate there are none.
    tracked = tuple(order_lines((level,), travel, fs, orders)) if travel else ()
    mains = mains_lines(spectrum)
    attribute = partial(
        attribute_line, rate=constant, bin_hz=spectrum.bin_hz, sample_rate_hz=fs, named=named, parts=period
    )
    return ChannelLook(
        channel=channel,
        mean=middle,
        rms=root_mean_square(y),
        drift=line.slope * fs,
        gaps=runs_of(channel.bridged),
        clipped=clipped_runs(channel.data),
        spikes=isolated_spikes(y, noise.sigma),
        quiet=quiet,
        noise=noise,
        spectrum=spectrum,
        density_hz=frequency,
        density=density,
        bands=bands,
        below_rms=rms_below(frequency, density, bands),
        lines=tuple(attribute(one, mains) for one in lines),
        mains=tuple(attribute(one.line, (one,)) for one in mains),
        step_lines=average_orders(tracked),
        named_lines=average_named(named_orders(level, travel, fs, named, usual).lines, named) if travel else (),
        over_rate=() if constant else tracked,
        resonances=measured_resonances(
            () if constant else tracked,
            frequency,
            density,
            lines=lines,
            spacing_hz=constant or 0.0,
        ),
        waterfall=_waterfall(level, base, travel),
    )


def _is_at_rest(stretch: QuietStretch, travel: Travel | None, steps: int) -> bool:
    """Return whether no step falls into a stretch, at `steps` per full step; True if no rate is known."""
    if travel is None:
        return True
    ends = travel[stretch.first : stretch.stop : stretch.stop - stretch.first - 1]
    return bool(ends[-1] - ends[0] < 1.0 / steps)


def _waterfall(level: Series, base: TimeBase, travel: Travel | None) -> Waterfall:
    window_s = usual_window_s(base.samples / base.sample_rate_hz)
    time, frequency, amplitude = spectrogram(level, base.sample_rate_hz, window_s, WINDOWS)
    rate = rate_at(travel, time + base.start_s) if travel else np.full(time.size, np.nan)
    return Waterfall(time_s=time + base.start_s, frequency_hz=frequency, amplitude=amplitude, rate=rate)
