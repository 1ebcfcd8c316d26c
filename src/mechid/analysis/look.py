"""A record by itself, before any model: how healthy and how noisy it is, what is in it, how it seems to be driven."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechid.analysis.measured_resonances import MeasuredResonance, measured_resonances
from mechid.analysis.order_tracking import ORDERS, OrderLine, order_lines
from mechid.analysis.prediction import Travel
from mechid.analysis.step_rate import SuggestedRate, suggested_rate
from mechid.command import Command, MeasuredCommand, RateProfile
from mechid.identification.computation.parallel import one_core_algebra
from mechid.records import Channel, Record
from mechid.signal import Band, noise_floor, power_density, spectrogram, third_octaves
from mechid.signal.clipping import clipped_runs
from mechid.signal.density import rms_below
from mechid.signal.lines import Line, Prominence, prominence, spectral_lines
from mechid.signal.mains import MainsLine, mains_lines
from mechid.signal.quiet import QuietStretch, quiet_rms, quiet_stretches
from mechid.signal.resolution import resolution
from mechid.signal.runs import Runs, runs_of
from mechid.signal.spectrogram import WINDOWS, usual_window_s
from mechid.signal.spikes import isolated_spikes
from mechid.signal.trend import fit_line
from mechid.simulation.simulator import TimeBase

FloatArray = NDArray[np.float64]
MORE_ORDERS = (0.25, *ORDERS, 6.0, 8.0)
"""A quarter: the currents of a two-phase motor repeat after four full steps."""
QUARTERS = 4
"""A line is looked for at quarters of the step rate."""
NEAR_BINS, NEAR = 0.5, 5e-4
"""A line this near to a multiple of the step rate, in bins or relative, is one."""
BY_CHANCE = 0.2
"""Chance of any line to be that near to a multiple, up to which it tells something."""
RESOLVED = 3.0
"""Standard errors from which a line is told from noise."""
CONSTANT = 0.02
"""Rates that differ by less than this part of the largest are one."""
AGREES = 1.25
"""Two readings of a noise whose ratio is below agree."""


@dataclass(frozen=True, kw_only=True)
class Drive:
    """How a record is said to be driven: its command, and the record time in s at which that starts."""

    command: Command
    time_offset_s: float = 0.0

    @property
    def is_stepped(self) -> bool:
        """Whether it says at which rate the motor steps."""
        return not isinstance(self.command, MeasuredCommand) and any(self.command.rate.rates)


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
        RMS of the quietest stretches, with all colour.
    resolution : float
        Step in which the samples are written, 0 where there is none.
    """

    sigma: float
    rests_on: str
    floor: float
    quiet: float | None
    resolution: float


@dataclass(frozen=True, kw_only=True)
class SeenLine:
    """A line of a channel's spectrum, and what it may be.

    Attributes
    ----------
    line : Line
    order : float or None
        Multiple of a constant step rate.
    mains : MainsLine or None
        Multiple of the mains' frequency.
    """

    line: Line
    order: float | None
    mains: MainsLine | None


@dataclass(frozen=True, kw_only=True)
class StepLine:
    """One order of the step rate, over windows of equal travel.

    Attributes
    ----------
    order : float
    windows : int
    amplitude, sigma : float
        Root of the mean power over the windows, less the noise's, and its standard error; the channel's unit.
    peak_rate, peak_amplitude : float
        Full steps/s in the window where it is largest, and its amplitude there.
    """

    order: float
    windows: int
    amplitude: float
    sigma: float
    peak_rate: float
    peak_amplitude: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Waterfall:
    """Amplitude, (F, C), at frequencies (F,) Hz and record times (C,) s, with the step rate there or NaN, (C,)."""

    time_s: FloatArray
    frequency_hz: FloatArray
    amplitude: FloatArray
    rate: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class ChannelLook:
    """One channel, in its own unit; spectra and RMS are of what is left without its mean."""

    channel: Channel
    mean: float
    rms: float
    drift: float
    gaps: Runs
    clipped: Runs
    spikes: NDArray[np.int64]
    quiet: tuple[QuietStretch, ...]
    noise: NoiseEvidence
    spectrum: Prominence
    density_hz: FloatArray
    density: FloatArray
    bands: tuple[Band, ...]
    below_rms: float
    lines: tuple[SeenLine, ...]
    mains: tuple[SeenLine, ...]
    step_lines: tuple[StepLine, ...]
    over_rate: tuple[OrderLine, ...]
    resonances: tuple[MeasuredResonance, ...]
    waterfall: Waterfall


@dataclass(frozen=True, kw_only=True, eq=False)
class RecordLook:
    """A record: how it is said to be driven, what it suggests itself, and its channels.

    `constant_rate` is the one step rate in full steps/s, as declared, else as suggested; None where it varies or is not
    known.
    """

    record: Record
    declared: Drive | None
    suggested: SuggestedRate | None
    constant_rate: float | None
    base: TimeBase
    channels: tuple[ChannelLook, ...]

    @property
    def rate(self) -> RateProfile | None:
        """The step rate: as declared, else as suggested, else unknown."""
        if self.declared:
            return self.declared.command.rate
        return self.suggested.profile if self.suggested else None


def look_at(record: Record, declared: Drive | None = None) -> RecordLook:
    """Return what a record shows by itself.

    Parameters
    ----------
    record : Record
    declared : Drive or None
        How it is said to be driven; one that says no step rate counts as none.

    Examples
    --------
    >>> from mechid.records import RecordSpec, read_record
    >>> record = read_record(path, RecordSpec(name="a", path="a.csv"))  # doctest: +SKIP
    >>> look_at(record).channels[0].noise.sigma  # doctest: +SKIP
    """
    base = TimeBase(record.sample_rate_hz, record.samples, record.time_start_s)
    declared = declared if declared and declared.is_stepped else None
    spectra = [prominence(c.data, record.sample_rate_hz) for c in record.channels]
    lines = [spectral_lines(spectrum) for spectrum in spectra]
    each = list(zip(record.channels, spectra, lines, strict=True))
    suggestions = (_suggested(c, spectrum, found) for c, spectrum, found in each)
    suggested = next((one for one in suggestions if one), None)
    travel = _travel(declared, suggested, base)
    with one_core_algebra():
        orders = _orders(declared, suggested)
        channels = [_channel(c, spectrum, found, travel, base, orders) for c, spectrum, found in each]
    return RecordLook(
        record=record,
        declared=declared,
        suggested=suggested,
        constant_rate=_constant_rate(travel),
        base=base,
        channels=tuple(channels),
    )


def _suggested(channel: Channel, spectrum: Prominence, lines: Sequence[Line]) -> SuggestedRate | None:
    """Return the rate that a channel suggests without mains hum, or with it where that has the lines of full steps."""
    hum = {round(one.line.frequency_hz / spectrum.bin_hz) for one in mains_lines(spectrum)}
    y = channel.data - channel.data.mean()
    own = suggested_rate(y, spectrum, [one for one in lines if round(one.frequency_hz / spectrum.bin_hz) not in hum])
    if own or not hum:
        return own
    with_hum = suggested_rate(y, spectrum, lines)
    return with_hum if with_hum and with_hum.stepping == "full" else None


def _travel(declared: Drive | None, suggested: SuggestedRate | None, base: TimeBase) -> Travel | None:
    if declared:
        return Travel(declared.command.rate, base, declared.time_offset_s)
    return Travel(suggested.profile, base, base.start_s) if suggested else None


def _orders(declared: Drive | None, suggested: SuggestedRate | None) -> tuple[float, ...]:
    """Return the orders that are tracked: of the microsteps too."""
    steps = declared.command.microsteps if declared else (suggested.microsteps or 1) if suggested else 1
    return (*MORE_ORDERS, float(steps)) if steps > max(MORE_ORDERS) else MORE_ORDERS


def rate_at(travel: Travel, times_s: FloatArray) -> FloatArray:
    """Return the magnitude of a step rate at record times, (C,), full steps/s; 0 before its start."""
    since = times_s - travel.time_offset_s
    rate = np.abs(np.interp(since, travel.rate.times_s, travel.rate.rates))
    return np.asarray(np.where(since < 0.0, 0.0, rate), dtype=np.float64)


def _constant_rate(travel: Travel | None) -> float | None:
    """Return the rate where it is one over the whole record, else None."""
    if travel is None:
        return None
    ends = [travel.base.start_s, travel.base.start_s + travel.base.samples / travel.base.sample_rate_hz]
    inside = [t + travel.time_offset_s for t in travel.rate.times_s if ends[0] < t + travel.time_offset_s < ends[1]]
    rates = rate_at(travel, np.array([max(ends[0], travel.time_offset_s), *inside, ends[1]]))
    return float(rates.max()) if float(np.ptp(rates)) <= CONSTANT * float(rates.max()) else None


def _channel(
    channel: Channel, spectrum: Prominence, lines: Sequence[Line], travel: Travel | None, base: TimeBase,
    orders: Sequence[float],
) -> ChannelLook:  # fmt: skip
    line, fs = fit_line(channel.data, 2), base.sample_rate_hz
    y = channel.data - channel.data.mean()
    frequency, density = power_density(y, fs)
    bands = third_octaves(frequency, density)
    quiet, noise = _noise(channel, fs)
    constant = _constant_rate(travel)
    level = channel.data.copy()
    line.take_from(level)
    tracked = tuple(order_lines((level,), travel, fs, orders)) if travel else ()
    mains = mains_lines(spectrum)
    return ChannelLook(
        channel=channel,
        mean=float(channel.data.mean()),
        rms=float(np.sqrt(np.mean(y**2))),
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
        lines=tuple(_seen(one, mains, constant, spectrum.bin_hz) for one in lines),
        mains=tuple(_seen(one.line, (one,), constant, spectrum.bin_hz) for one in mains),
        step_lines=_step_lines(tracked),
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


def _noise(channel: Channel, sample_rate_hz: float) -> tuple[tuple[QuietStretch, ...], NoiseEvidence]:
    y = channel.data
    quiet, step = quiet_stretches(y, sample_rate_hz), resolution(y)
    floor = noise_floor(y, sample_rate_hz, rejected=channel.bridged)
    quietest = quiet_rms(quiet)
    told = {"floor": floor, "resolution": step / math.sqrt(12.0)}
    if quietest is not None and quietest > AGREES * floor:
        told["quiet stretch"] = quietest
    rests_on = max(told, key=lambda key: told[key])
    return quiet, NoiseEvidence(
        sigma=told[rests_on], rests_on=rests_on, floor=floor, quiet=quietest, resolution=step
    )  # fmt: skip


def _seen(line: Line, mains: Sequence[MainsLine], rate: float | None, bin_hz: float) -> SeenLine:
    """Return a line with what it may be."""
    near = [one for one in mains if abs(one.line.frequency_hz - line.frequency_hz) < bin_hz]
    orders = (_order(line.frequency_hz, rate, parts, bin_hz) for parts in (1, QUARTERS) if rate)
    order = next((order for order in orders if order), None)
    return SeenLine(line=line, order=order, mains=near[0] if near else None)


def _order(frequency_hz: float, rate: float, parts: int, bin_hz: float) -> float | None:
    """Return the order of a line in whole parts of the rate; None where it is none, or may well be so by chance."""
    order = round(parts * frequency_hz / rate) / parts
    near = max(NEAR_BINS * bin_hz, NEAR * frequency_hz)
    is_one = order > 0.0 and abs(order * rate - frequency_hz) <= near
    return order if is_one and 2.0 * near * parts <= BY_CHANCE * rate else None


def _step_lines(tracked: Sequence[OrderLine]) -> tuple[StepLine, ...]:
    by_order: dict[float, list[OrderLine]] = {}
    for line in tracked:
        by_order.setdefault(line.order, []).append(line)
    return tuple(_summed_up(order, by_order[order]) for order in sorted(by_order))


def _summed_up(order: float, lines: Sequence[OrderLine]) -> StepLine:
    """Return an order over its windows.

    The error of the mean power is its scatter over the windows, or that of the noise if that is larger:
    |c + n|^2 has the variance 4 e^2 |c|^2 + 4 e^4 with the error e of each part of n.
    """
    power, error = np.array([line.power() for line in lines]), np.array([line.errors[0] for line in lines])
    mean = float(power.mean())
    size = math.sqrt(max(mean, 0.0))
    by_noise = float(np.mean(4.0 * error**2 * np.maximum(power, 0.0) + 4.0 * error**4)) / power.size
    by_scatter = float(power.var(ddof=1)) / power.size if power.size > 1 else 0.0
    spread = math.sqrt(max(by_noise, by_scatter))
    peak = int(np.argmax(power))
    return StepLine(
        order=order,
        windows=len(lines),
        amplitude=size,
        sigma=min(spread / (2.0 * size), math.sqrt(spread)) if size else math.sqrt(spread),
        peak_rate=lines[peak].rate,
        peak_amplitude=math.sqrt(max(float(power[peak]), 0.0)),
    )


def _waterfall(level: FloatArray, base: TimeBase, travel: Travel | None) -> Waterfall:
    window_s = usual_window_s(base.samples / base.sample_rate_hz)
    time, frequency, amplitude = spectrogram(level, base.sample_rate_hz, window_s, WINDOWS)
    rate = rate_at(travel, time + base.start_s) if travel else np.full(time.size, np.nan)
    return Waterfall(time_s=time + base.start_s, frequency_hz=frequency, amplitude=amplitude, rate=rate)
