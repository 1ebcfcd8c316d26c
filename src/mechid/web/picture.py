"""Record and model at given parameter values: curves and numbers of one panel of the page."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.fft import prev_fast_len

from mechid.analysis.noise_floor_test import NoiseComparison
from mechid.analysis.order_tracking import ORDERS
from mechid.arrays import FloatArray
from mechid.campaign import Campaign, CampaignRecord, Match
from mechid.campaign.campaign import key_in_record
from mechid.command import Timing
from mechid.identification.output_error.record_parameters import INSTANTS
from mechid.identification.output_error.target import TargetChannel, channel_of, is_clock, latest_of
from mechid.identification.uncertainty.visibility import count_sensitivities
from mechid.plant.mechanism import Mechanism, NamedLine
from mechid.plant.plant import Plant
from mechid.reports.curves import rate_over
from mechid.signal import amplitude_spectrum, effective_samples_of, fit_percent, peak_groups
from mechid.signal.remainder import Remainder
from mechid.signal.series import no_samples
from mechid.signal.trend import Line
from mechid.simulation.accuracy import simulate_accurately
from mechid.simulation.simulator import Run, Simulator, TimeBase
from mechid.simulation.start import Start
from mechid.simulation.time_scale import clock_direction
from mechid.units import SI_UNIT
from mechid.web.knobs import Knob

MOST_BINS = 1500
SHOWN_HZ, ORDERS_SHOWN = 500.0, 6.0
"""Highest frequency of spectra: the 500 Hz of the paper, or a multiple of the step rate if that is larger."""


@dataclass(frozen=True, kw_only=True)
class Numbers:
    """Agreement of the model with a stretch of a record, without offset and drift.

    Attributes
    ----------
    residual : NoiseComparison
        Residual and noise floor of the record, in the unit of the channel.
    fit_percent : float
    offset, drift : float
        Removed offset and drift in N m and N m/s.
    """

    residual: NoiseComparison
    fit_percent: float
    offset: float
    drift: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Picture:
    """Curves of a stretch of a record from its first sample, without offset and drift.

    Attributes
    ----------
    start_s, interval_s : float
    measured, modelled, residual : (n,)
        Curves in N m; the last two are NaN where the simulation failed.
    frequency_hz, measured_spectrum, modelled_spectrum, residual_spectrum : (m,)
        Amplitudes in N m.
    numbers : Numbers
    """

    start_s: float
    interval_s: float
    measured: FloatArray
    modelled: FloatArray
    residual: FloatArray
    frequency_hz: FloatArray
    measured_spectrum: FloatArray
    modelled_spectrum: FloatArray
    residual_spectrum: FloatArray
    numbers: Numbers


@dataclass(frozen=True, kw_only=True)
class Effect:
    """Effect of a small step of a parameter on a record.

    Attributes
    ----------
    words : str
        Description of the step, as "1 %".
    torque : (n,)
        Change of the torque in N m, with offset and drift projected out.
    rms : float
        RMS of the change in N m.
    alone : float
        Standard error of the parameter in its unit, if only this stretch determined it, all other parameters were known
        and the residual were the noise of the record.
    """

    words: str
    torque: FloatArray
    rms: float
    alone: float


@dataclass(frozen=True)
class Stretch:
    """Simulated part of a record: its first `seconds`, with `substeps` integration steps per sample.

    `own` are the values of the per-record parameters, by name.
    """

    seconds: float
    own: Mapping[str, float]
    substeps: int


@dataclass(frozen=True, eq=False)
class Scene:
    """A shown channel of a record, with data prepared once so that a picture takes one simulation.

    `lanes` is the number of sensitivities of the kernel that is already compiled; `named` are the mechanism's lines.
    """

    record: CampaignRecord
    match: Match
    lanes: int
    plant: Plant
    named: tuple[NamedLine, ...] = ()

    @property
    def label(self) -> str:
        """Name of the record, with the quantity unless it is the leading one."""
        own, name = self.match.quantity, self.record.name
        return name if own == self.record.leading else f"{name}: {own}"

    @property
    def unit(self) -> str:
        """SI unit of the quantity."""
        return SI_UNIT[self.match.quantity]

    @cached_property
    def channel(self) -> TargetChannel:
        """The channel with its fit settings."""
        return channel_of(self.record, self.match)

    @cached_property
    def base(self) -> TimeBase:
        """Time base of the record."""
        data = self.record.data
        assert data is not None
        return TimeBase(data.sample_rate_hz, data.samples, data.time_start_s)

    @cached_property
    def simulator(self) -> Simulator:
        """Simulator of the record's command."""
        latest_s = latest_of(self.record.parameters, self.base)
        start = Start({key_in_record(q.name): q.value for q in self.record.start})
        return Simulator(
            self.plant, self.record.command, self.base, capacity=self.lanes, latest_s=latest_s, start=start
        )

    @cached_property
    def largest_rate(self) -> float:
        """Largest magnitude of the commanded rate, full steps/s."""
        return float(np.abs(self.record.command.rate.rates).max())

    @cached_property
    def rate(self) -> FloatArray:
        """Breakpoints of the commanded rate, (R, 2) of s and full steps/s; one row for a constant rate."""
        return rate_over(self.record, self.base)

    @property
    def is_sweep(self) -> bool:
        """Whether the rate varies over the record."""
        return len(self.rate) > 1

    @property
    def marked_hz(self) -> dict[str, list[float]]:
        """Frequencies of the orders of a constant step rate, and of the mechanism's lines, by name.

        Those that follow the step rate are missing for a varying or zero rate.
        """
        steady = len(set(self.record.command.rate.rates)) == 1 and self.largest_rate > 0.0
        rate = self.largest_rate if steady else None
        orders = {f"order {order:g}": [order * rate] for order in ORDERS} if rate else {}
        return orders | {one.name: list(one.lines_hz(rate, self.base.sample_rate_hz)) for one in self.named}

    @cached_property
    def shown_hz(self) -> float:
        """Highest shown frequency of spectra."""
        return min(max(SHOWN_HZ, ORDERS_SHOWN * self.largest_rate), 0.5 * self.base.sample_rate_hz)

    def samples(self, seconds: float) -> int:
        """Return the number of samples of the first `seconds`, at least 2."""
        wanted = round(min(seconds, 1e9) * self.base.sample_rate_hz) + 1
        return min(max(wanted, 2), self.base.samples)

    def steps_needed(self, mechanism: Mechanism) -> int:
        """Return the integration steps per sample for the specified accuracy, determined on the first second."""
        first = replace(
            self.simulator, base=self.base.truncate(self.samples(1.0)), known_edges=self.simulator.excitation
        )
        own = {q.replaces: q.value for q in self.record.overrides}
        return max(simulate_accurately(first, mechanism.kernel_values(own)).substeps // 2, 1)

    def picture(self, mechanism: Mechanism, stretch: Stretch) -> Picture:
        """Simulate a stretch of the record, and compare it with the measurement."""
        n = self.samples(stretch.seconds)
        modelled = np.empty(n)
        for block in self._run(mechanism, stretch, None).blocks():
            modelled[block.start : block.stop] = block.y[:, self._output_index]
        # Offset and drift are fitted to the residual, since the campaign projects them out.
        residual = Remainder(self.channel.measured[:n], model=modelled)[:]
        line = self.channel.line(residual, no_samples()) if np.all(np.isfinite(residual)) else Line()
        removed = line.at(0, n)
        residual -= removed
        measured = self.channel.measured[:n] - removed
        frequency, spectra, share = self._spectra(measured, modelled, residual)
        return Picture(
            start_s=self.base.start_s,
            interval_s=self.base.interval_s,
            measured=measured,
            modelled=modelled,
            residual=residual,
            frequency_hz=frequency,
            measured_spectrum=spectra[0],
            modelled_spectrum=spectra[1],
            residual_spectrum=spectra[2],
            numbers=self._numbers(measured, residual, share, line),
        )

    def effect(self, mechanism: Mechanism, knob: Knob, stretch: Stretch) -> Effect:
        """Compute the effect of a small step of a knob on a stretch of the record, from its exact sensitivity."""
        values = {name: q.value for name, q in mechanism.parameters.items()}
        step, words = knob.step({**values, **stretch.own}.get(knob.name, 0.0))
        slope = self._slope(mechanism, knob.name, stretch)
        slope -= self.channel.line(slope, no_samples()).at(0, slope.size)
        size = float(np.linalg.norm(slope))
        alone = self.channel.sigma / size if size > 0.0 else math.inf
        return Effect(words=words, torque=step * slope, rms=abs(step) * size / math.sqrt(slope.size), alone=alone)

    def _slope(self, mechanism: Mechanism, name: str, stretch: Stretch) -> FloatArray:
        """Return dy/d(value) of a knob, (n,); zero for parameters of other records, or overridden in this one."""
        slope, own = np.zeros(self.samples(stretch.seconds)), {q.name: q for q in self.record.parameters}.get(name)
        replaced = {q.replaces: stretch.own[q.name] for q in self.record.overrides}
        if own is None and (name not in mechanism.parameters or name in replaced):
            return slope
        moves = own.replaces if own else name
        direction = np.zeros(len(self.plant.parameters))
        if moves:
            direction = mechanism.with_values(replaced).kernel_jacobian()[moves]
        elif own and is_clock(own):
            p = mechanism.with_values(replaced).kernel_values()
            direction = clock_direction(self.plant, p, self._timing(stretch))
        for block in self._run(mechanism, stretch, direction).blocks():
            n, lane = block.stop - block.start, block.jacobian[:, self._output_index, 0]
            instants = (
                INSTANTS[own.declaration.key](self.base, block, self._output_index, n) if own and not moves else 0.0
            )
            slope[block.start : block.stop] = instants + lane
        return slope

    @cached_property
    def _output_index(self) -> int:
        return list(self.plant.outputs).index(self.match.quantity)

    def _timing(self, stretch: Stretch) -> Timing:
        record, own = self.record, stretch.own
        clock_ppm = own[record.clock.name] if record.clock else 0.0
        return Timing(own[record.time_offset.name], clock_ppm, record.clock_reference)

    def _run(self, mechanism: Mechanism, stretch: Stretch, direction: FloatArray | None) -> Run:
        """Start a simulation, optionally with the sensitivity to one direction of the kernel parameters."""
        record, own = self.record, stretch.own
        return self.simulator.run(
            mechanism.kernel_values({q.replaces: own[q.name] for q in record.overrides}),
            timing=self._timing(stretch),
            substeps=stretch.substeps,
            samples=self.samples(stretch.seconds),
            directions=None if direction is None else np.ascontiguousarray(direction[:, None]),
        )

    def _spectra(self, *curves: FloatArray) -> tuple[FloatArray, list[FloatArray], float]:
        """Return frequencies and grouped peaks of all spectra, and the share of effective samples of the last curve."""
        # A few samples are dropped at the end: transforms of lengths with a large prime factor take far longer.
        rate, n = self.base.sample_rate_hz, prev_fast_len(curves[0].size, real=True)
        both = [amplitude_spectrum(y[:n], rate) for y in curves]
        frequency = both[0][0]
        kept = max(int(np.searchsorted(frequency, self.shown_hz, side="right")), 2)
        starts = peak_groups(kept, MOST_BINS)
        stops = np.append(starts[1:], kept)
        peaks = [np.maximum.reduceat(y[:kept], starts) for _, y in both]
        return frequency[(starts + stops - 1) // 2], peaks, effective_samples_of(both[-1][1], n) / n

    def _numbers(self, measured: FloatArray, residual: FloatArray, share: float, line: Line) -> Numbers:
        return Numbers(
            residual=NoiseComparison(
                residual_rms=float(np.sqrt(np.mean(residual**2))),
                noise_sigma=self.channel.sigma,
                samples=residual.size,
                effective_samples=share * residual.size,
                floor_samples=self.base.samples,
            ),
            fit_percent=fit_percent(measured, residual),
            offset=line.offset,
            drift=line.slope * self.base.sample_rate_hz,
        )


def scenes_of(campaign: Campaign) -> dict[str, Scene]:
    """Return the channels of a campaign that the model has to explain, by label."""
    lanes, plant, named = count_sensitivities(campaign), campaign.mechanism.plant, campaign.mechanism.named_lines
    read = [r for r in campaign.records if r.data is not None]
    found = [Scene(record, match, lanes, plant, named) for record in read for match in record.matches]
    return {scene.label: scene for scene in found}
