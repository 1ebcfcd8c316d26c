"""A record beside the model at some values: the curves and the numbers that one panel of the page shows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.fft import prev_fast_len

from mechid.analysis.against_noise import AgainstNoise
from mechid.analysis.order_tracking import ORDERS
from mechid.arrays import FloatArray
from mechid.campaign import Campaign, CampaignRecord, Match
from mechid.campaign.campaign import key_in_record
from mechid.command import Timing
from mechid.identification.output_error.record_parameters import INSTANTS
from mechid.identification.output_error.target import TargetChannel, channel_of, is_clock, latest_of
from mechid.identification.uncertainty.visibility import count_sensitivities
from mechid.plant.mechanism import Mechanism
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
"""A spectrum is shown up to the paper's 500 Hz, or so many times the step rate."""


@dataclass(frozen=True, kw_only=True)
class Numbers:
    """How well the model matches a stretch of a record, offset and drift removed.

    Attributes
    ----------
    residual : AgainstNoise
        The residual beside the record's noise floor, in the channel's unit.
    fit_percent : float
    offset, drift : float
        What was removed, N m and N m/s.
    """

    residual: AgainstNoise
    fit_percent: float
    offset: float
    drift: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Picture:
    """The curves of a stretch of a record, from its first sample on; offset and drift removed.

    Attributes
    ----------
    start_s, interval_s : float
    measured, modelled, residual : (n,)
        N m; the last two are NaN where the simulation failed.
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
    """What a small step of a parameter does to a record.

    Attributes
    ----------
    words : str
        The step, as "1 %".
    torque : (n,)
        Change of the torque, N m, offset and drift projected out.
    rms : float
        Of it, N m.
    alone : float
        The step's size over this record's information: the standard error, in the parameter's unit, that the stretch
        would leave it if all other parameters were known and the residual were the record's noise.
    """

    words: str
    torque: FloatArray
    rms: float
    alone: float


@dataclass(frozen=True)
class Stretch:
    """What of a record is simulated, and how: its first `seconds`, at its own values, in so many steps a sample.

    `own` are the values of the record's parameters, by name.
    """

    seconds: float
    own: Mapping[str, float]
    substeps: int


@dataclass(frozen=True, eq=False)
class Scene:
    """A channel of a record that is looked at: what is prepared once, so that a picture takes one simulation.

    `lanes` is the number of sensitivities whose kernel is there already.
    """

    record: CampaignRecord
    match: Match
    lanes: int
    plant: Plant

    @property
    def label(self) -> str:
        """The record's name, with the quantity where it is not the leading one."""
        own, name = self.match.quantity, self.record.name
        return name if own == self.record.leading else f"{name}: {own}"

    @property
    def unit(self) -> str:
        """SI unit of the quantity."""
        return SI_UNIT[self.match.quantity]

    @cached_property
    def channel(self) -> TargetChannel:
        """The channel as it is matched."""
        return channel_of(self.record, self.match)

    @cached_property
    def base(self) -> TimeBase:
        """The record's sample instants."""
        data = self.record.data
        assert data is not None
        return TimeBase(data.sample_rate_hz, data.samples, data.time_start_s)

    @cached_property
    def simulator(self) -> Simulator:
        """What simulates the record's command."""
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
        """The commanded rate over the record, (R, 2) of s and full steps/s, linear between; one row is a constant."""
        return rate_over(self.record, self.base)

    @property
    def is_sweep(self) -> bool:
        """Whether the rate varies over the record."""
        return len(self.rate) > 1

    @property
    def orders_hz(self) -> list[float]:
        """Frequencies of the orders of a constant step rate; none of a varying rate, or of none."""
        steady = len(set(self.record.command.rate.rates)) == 1 and self.largest_rate > 0.0
        return [order * self.largest_rate for order in ORDERS] if steady else []

    @cached_property
    def shown_hz(self) -> float:
        """Up to which frequency spectra are shown."""
        return min(max(SHOWN_HZ, ORDERS_SHOWN * self.largest_rate), 0.5 * self.base.sample_rate_hz)

    def samples(self, seconds: float) -> int:
        """Return the number of samples of the first `seconds`, at least 2."""
        wanted = round(min(seconds, 1e9) * self.base.sample_rate_hz) + 1
        return min(max(wanted, 2), self.base.samples)

    def steps_needed(self, mechanism: Mechanism) -> int:
        """Return the steps a sample that the promised accuracy takes, judged on the record's first second."""
        first = replace(
            self.simulator, base=self.base.truncate(self.samples(1.0)), known_edges=self.simulator.excitation
        )
        own = {q.replaces: q.value for q in self.record.replaced}
        return max(simulate_accurately(first, mechanism.kernel_values(own)).substeps // 2, 1)

    def picture(self, mechanism: Mechanism, stretch: Stretch) -> Picture:
        """Return a stretch of the record beside the model."""
        n = self.samples(stretch.seconds)
        modelled = np.empty(n)
        for block in self._run(mechanism, stretch, None).blocks():
            modelled[block.start : block.stop] = block.y[:, self._output]
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
        """Return what a small step of a knob does to a stretch of the record, by its exact sensitivity."""
        values = {name: q.value for name, q in mechanism.parameters.items()}
        step, words = knob.step({**values, **stretch.own}.get(knob.name, 0.0))
        slope = self._slope(mechanism, knob.name, stretch)
        slope -= self.channel.line(slope, no_samples()).at(0, slope.size)
        size = float(np.linalg.norm(slope))
        alone = self.channel.sigma / size if size > 0.0 else math.inf
        return Effect(words=words, torque=step * slope, rms=abs(step) * size / math.sqrt(slope.size), alone=alone)

    def _slope(self, mechanism: Mechanism, name: str, stretch: Stretch) -> FloatArray:
        """Return dy/d(value) of a knob, (n,); zeros of what is another record's own, or has another value in this."""
        slope, own = np.zeros(self.samples(stretch.seconds)), {q.name: q for q in self.record.parameters}.get(name)
        replaced = {q.replaces: stretch.own[q.name] for q in self.record.replaced}
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
            n, lane = block.stop - block.start, block.jacobian[:, self._output, 0]
            instants = INSTANTS[own.declaration.key](self.base, block, self._output, n) if own and not moves else 0.0
            slope[block.start : block.stop] = instants + lane
        return slope

    @cached_property
    def _output(self) -> int:
        return list(self.plant.outputs).index(self.match.quantity)

    def _timing(self, stretch: Stretch) -> Timing:
        record, own = self.record, stretch.own
        clock_ppm = own[record.clock.name] if record.clock else 0.0
        return Timing(own[record.time_offset.name], clock_ppm, record.clock_reference)

    def _run(self, mechanism: Mechanism, stretch: Stretch, direction: FloatArray | None) -> Run:
        """Begin a simulation, with the sensitivity to one direction of the kernel's parameters where it is wanted."""
        record, own = self.record, stretch.own
        return self.simulator.run(
            mechanism.kernel_values({q.replaces: own[q.name] for q in record.replaced}),
            timing=self._timing(stretch),
            substeps=stretch.substeps,
            samples=self.samples(stretch.seconds),
            directions=None if direction is None else np.ascontiguousarray(direction[:, None]),
        )

    def _spectra(self, *curves: FloatArray) -> tuple[FloatArray, list[FloatArray], float]:
        """Return the peak of each group of bins up to the shown frequency, of each curve.

        And what share of the last curve's samples is effective, which its whole spectrum says.

        The last few samples are left out, since lengths with a large prime factor take many times as long.
        """
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
            residual=AgainstNoise(
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
    lanes, plant = count_sensitivities(campaign), campaign.mechanism.plant
    read = [r for r in campaign.records if r.data is not None]
    found = [Scene(record, match, lanes, plant) for record in read for match in record.matches]
    return {scene.label: scene for scene in found}
