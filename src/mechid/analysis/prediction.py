"""A record beside what a fit predicts of it."""

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
from mechid.identification.result.as_fitted import record_as_fitted
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
    """Full steps that a command has travelled at each sample, worked out where they are looked at."""

    rate: RateProfile
    base: TimeBase
    timing: Timing

    @property
    def size(self) -> int:
        """Number of samples."""
        return self.base.samples

    def __getitem__(self, part: slice, /) -> FloatArray:
        """Return those of a slice."""
        times = self.base.start_s + np.arange(*part.indices(self.size)) / self.base.sample_rate_hz
        return steps_travelled(self.rate, self.timing.command_s(times))


@dataclass(frozen=True, eq=False)
class Prediction:
    """One measured channel over the whole of its record, and what the fit says of it.

    Attributes
    ----------
    measured : Series of N samples
        As it was read, in its quantity's SI unit.
    removed : Line
        Offset and drift between it and the model; none where the campaign keeps them.
    modelled : Series of N samples
        NaN from where the simulation failed, and `removed` is NaN then too.
    travel : Series
        Full steps that the command has travelled, N.
    base : TimeBase
    quantity : str
    rejected : (s,) of int
        Samples that do not count.
    rest : Prediction or None
        The same from behind the first part of a held-out record, on which what it has of its own was fitted.
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
    def judged(self) -> Prediction:
        """The part by which the record is judged: all of it, but for a first part on which its nuisance was fitted."""
        return self.rest or self

    @property
    def judged_from(self) -> int:
        """The first sample of that part."""
        return self.base.samples - self.judged.base.samples

    @property
    def level(self) -> Remainder:
        """Measured less offset and drift, N; less nothing where the simulation failed."""
        return Remainder(self.measured, self.removed if self.finite else Line())

    @property
    def residual(self) -> Remainder:
        """Measured less model less offset and drift, N; 0 at samples that do not count."""
        return Remainder(self.measured, self.removed, self.modelled, self.rejected)

    @property
    def finite(self) -> bool:
        """Whether the simulation came to the record's end."""
        return math.isfinite(self.removed.offset)


def predict(record: CampaignRecord, fit: Fit) -> dict[str, Prediction]:
    """Return the channels of a record, as the fit took it, beside the prediction of that fit; the leading one first."""
    record = record_as_fitted(record, fit)
    target = target_of(record)
    values = {q.name: fit.parameters[q.name].value if q.name in fit.parameters else q.value for q in record.parameters}
    clock_ppm = values[record.clock.name] if record.clock else 0.0
    timing = Timing(values[record.time_offset.name], clock_ppm, record.clock_reference)
    start = Start({key_in_record(q.name): values[q.name] for q in record.start})
    simulator = Simulator(fit.mechanism.plant, record.command, target.base, known_edges=target.excitation, start=start)
    p = fit.mechanism.kernel_values({q.replaces: values[q.name] for q in record.replaced})
    y, _, _ = accurate_outputs(simulator, p, timing=timing)
    outputs = dict(zip(fit.mechanism.plant.outputs, y, strict=True))
    travel = Travel(record.command.rate, target.base, timing)
    others = [channel_of(record, match) for match in record.matches if match.quantity not in target.quantities]
    own = fit.records.get(record.name)
    begin = own.nuisance.samples if own and own.nuisance else 0
    return {
        channel.quantity: _beside(
            _as_counted(channel, fit, record.name), outputs[channel.quantity], travel, target.base, begin
        )
        for channel in (*target.channels, *others)
    }


def _as_counted(channel: TargetChannel, fit: Fit, record: str) -> TargetChannel:
    """Return a channel without the samples that the fit rejected."""
    own = fit.records[record].channels.get(channel.quantity) if record in fit.records else None
    runs = own.rejected_runs if own else ()
    return replace(channel, rejected=np.union1d(channel.rejected, samples_of(runs))) if runs else channel


def _beside(
    channel: TargetChannel, modelled: Series, travel: Travel, base: TimeBase, judged_from: int = 0
) -> Prediction:
    """Return a channel beside its prediction, and the same of the samples from the one on by which it is judged."""
    removed = Line(math.nan, math.nan)
    if is_finite(modelled):
        removed = channel.line(Remainder(channel.measured, model=modelled), channel.rejected)
    rest = None
    if judged_from:
        later = replace(
            channel,
            measured=stretch_of(channel.measured, judged_from, base.samples),
            rejected=channel.rejected_within((judged_from, base.samples)),
        )
        left = TimeBase(base.sample_rate_hz, base.samples - judged_from, base.start_s + judged_from * base.interval_s)
        stretch = stretch_of(modelled, judged_from, base.samples)
        rest = _beside(later, stretch, replace(travel, base=left), left)
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
