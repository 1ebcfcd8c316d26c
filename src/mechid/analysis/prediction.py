"""Prediction of the channels of a record by a fit."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign import CampaignRecord
from mechid.campaign.campaign import key_in_record
from mechid.command import RateProfile, Timing
from mechid.command.edges import steps_travelled
from mechid.identification.output_error.target import Samples, TargetChannel, channel_of, target_of
from mechid.identification.result.finished_fit import record_as_fitted
from mechid.identification.result.fit import Fit
from mechid.signal.remainder import Remainder
from mechid.signal.runs import samples_of
from mechid.signal.series import Series, is_finite, no_samples, stretch_of
from mechid.signal.trend import Line
from mechid.simulation.accuracy import accurate_outputs
from mechid.simulation.simulator import Simulator, TimeBase
from mechid.simulation.start import Start


@dataclass(frozen=True)
class Travel:
    """Travel of a command at each sample in full steps, computed on access."""

    rate: RateProfile
    base: TimeBase
    timing: Timing

    @property
    def size(self) -> int:
        """Number of samples."""
        return self.base.samples

    def __getitem__(self, part: slice, /) -> FloatArray:
        """Return the travel at the samples of a slice."""
        times = self.base.start_s + np.arange(*part.indices(self.size)) / self.base.sample_rate_hz
        return steps_travelled(self.rate, self.timing.command_s(times))


@dataclass(frozen=True, eq=False)
class Prediction:
    """One measured channel over the whole record, with its prediction by a fit.

    Attributes
    ----------
    measured : Series of N samples
        Samples as read, in the SI unit of the quantity.
    removed : Line
        Offset and drift between measurement and model; zero if the campaign keeps them.
    modelled : Series of N samples
        Modelled samples; NaN from the point where the simulation failed, and then `removed` is NaN too.
    travel : Series
        Travel of the command in full steps, N.
    base : TimeBase
    quantity : str
    rejected : (s,) of int
        Indices of excluded samples.
    rest : Prediction or None
        The evaluated part of a held-out record, after the first part, on which its per-record parameters were fitted.
    """

    measured: Series
    removed: Line
    modelled: Series
    travel: Series
    base: TimeBase
    quantity: str = "torque"
    rejected: Samples = field(default_factory=no_samples)
    rest: Prediction | None = None

    @property
    def evaluated_part(self) -> Prediction:
        """The evaluated part: the whole record, without a first part on which nuisance parameters were fitted."""
        return self.rest or self

    @property
    def evaluated_from(self) -> int:
        """First sample of the evaluated part."""
        return self.base.samples - self.evaluated_part.base.samples

    @property
    def level(self) -> Remainder:
        """Measured minus offset and drift, N; unchanged if the simulation failed."""
        return Remainder(self.measured, self.removed if self.finite else Line())

    @property
    def residual(self) -> Remainder:
        """Measured minus model, offset and drift, N; 0 at excluded samples."""
        return Remainder(self.measured, self.removed, self.modelled, self.rejected)

    @property
    def finite(self) -> bool:
        """Whether the simulation reached the end of the record."""
        return math.isfinite(self.removed.offset)


def predict(record: CampaignRecord, fit: Fit) -> dict[str, Prediction]:
    """Predict the channels of a record, as interpreted by the fit; the leading channel first."""
    record = record_as_fitted(record, fit)
    target = target_of(record)
    values = {q.name: fit.parameters[q.name].value if q.name in fit.parameters else q.value for q in record.parameters}
    clock_ppm = values[record.clock.name] if record.clock else 0.0
    timing = Timing(values[record.time_offset.name], clock_ppm, record.clock_reference)
    start = Start({key_in_record(q.name): values[q.name] for q in record.start})
    simulator = Simulator(fit.mechanism.plant, record.command, target.base, known_edges=target.excitation, start=start)
    p = fit.mechanism.kernel_values({q.replaces: values[q.name] for q in record.overrides})
    y, _, _ = accurate_outputs(simulator, p, timing=timing)
    outputs = dict(zip(fit.mechanism.plant.outputs, y, strict=True))
    travel = Travel(record.command.rate, target.base, timing)
    others = [channel_of(record, match) for match in record.matches if match.quantity not in target.quantities]
    own = fit.records.get(record.name)
    # Nuisance parameters of a held-out record were fitted on these samples, which cannot test the prediction.
    begin = own.nuisance.samples if own and own.nuisance else 0
    return {
        channel.quantity: _pair_with_model(
            _without_rejected(channel, fit, record.name), outputs[channel.quantity], travel, target.base, begin
        )
        for channel in (*target.channels, *others)
    }


def _without_rejected(channel: TargetChannel, fit: Fit, record: str) -> TargetChannel:
    """Exclude the samples that the fit rejected from a channel."""
    own = fit.records[record].channels.get(channel.quantity) if record in fit.records else None
    runs = own.rejected_runs if own else ()
    return replace(channel, rejected=np.union1d(channel.rejected, samples_of(runs))) if runs else channel


def _pair_with_model(
    channel: TargetChannel, modelled: Series, travel: Travel, base: TimeBase, evaluated_from: int = 0
) -> Prediction:
    """Pair a channel with its prediction, over the whole record and from the sample `evaluated_from`."""
    removed = Line(math.nan, math.nan)
    if is_finite(modelled):
        removed = channel.line(Remainder(channel.measured, model=modelled), channel.rejected)
    rest = None
    if evaluated_from:
        later = replace(
            channel,
            measured=stretch_of(channel.measured, evaluated_from, base.samples),
            rejected=channel.rejected_within((evaluated_from, base.samples)),
        )
        left = TimeBase(
            base.sample_rate_hz, base.samples - evaluated_from, base.start_s + evaluated_from * base.interval_s
        )
        stretch = stretch_of(modelled, evaluated_from, base.samples)
        rest = _pair_with_model(later, stretch, replace(travel, base=left), left)
    return Prediction(
        measured=channel.measured,
        removed=removed,
        modelled=modelled,
        travel=travel,
        base=base,
        quantity=channel.quantity,
        rejected=channel.rejected,
        rest=rest,
    )
