"""A record beside what a fit predicts of it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from mechid.campaign import CampaignRecord
from mechid.campaign.campaign import mechanism_name
from mechid.command.edges import steps_travelled
from mechid.identification.output_error.declaration import taken_record
from mechid.identification.output_error.target import Samples, TargetChannel, channel_of, target_of
from mechid.identification.result.fit import Fit
from mechid.signal.runs import samples_of
from mechid.signal.trend import fit_line
from mechid.simulation.accuracy import simulate_accurately
from mechid.simulation.simulator import Simulator, TimeBase

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Prediction:
    """One measured channel over the whole of its record, and what the fit says of it.

    Attributes
    ----------
    measured : (N,)
        As it was read, in its quantity's SI unit.
    removed : (N,)
        Offset and drift between it and the model; zeros where the campaign keeps them.
    modelled : (N,)
        NaN from where the simulation failed, and `removed` is NaN then too.
    travel : (N,)
        Full steps that the command has travelled.
    base : TimeBase
    quantity : str
    rejected : (s,) of int
        Samples that do not count.
    """

    measured: FloatArray
    removed: FloatArray
    modelled: FloatArray
    travel: FloatArray
    base: TimeBase
    quantity: str = "torque"
    rejected: Samples = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    @property
    def residual(self) -> FloatArray:
        """Measured less model less offset and drift, (N,); 0 at samples that do not count."""
        r = self.measured - self.removed - self.modelled
        r[self.rejected] = 0.0
        return r

    @property
    def finite(self) -> bool:
        """Whether the simulation came to the record's end."""
        return bool(np.all(np.isfinite(self.modelled)))


def as_fitted(record: CampaignRecord, fit: Fit) -> CampaignRecord:
    """Return a record of the campaign with the sign, command and use that a fit took it to have."""
    own = fit.records.get(record.name)
    return taken_record(record, own.taken) if own else record


def predict(record: CampaignRecord, fit: Fit) -> dict[str, Prediction]:
    """Return the channels of a record, as the fit took it, beside the prediction of that fit; the leading one first."""
    record = as_fitted(record, fit)
    target = target_of(record)
    values = {q.name: fit.parameters[q.name].value if q.name in fit.parameters else q.value for q in record.parameters}
    offset_s = values[record.time_offset.name]
    stand = {mechanism_name(q.name): values[q.name] for q in record.test_stand}
    simulator = Simulator(fit.mechanism.plant, record.command, target.base, latest_s=abs(offset_s))
    trajectory = simulate_accurately(simulator, fit.mechanism.kernel_values(stand), time_offset_s=offset_s)
    travel = steps_travelled(record.command.rate, target.base.times - offset_s)
    others = [channel_of(record, match) for match in record.matches if match.quantity not in target.quantities]
    return {
        channel.quantity: _beside(
            _as_counted(channel, fit, record.name), trajectory.values[channel.quantity], travel, target.base
        )
        for channel in (*target.channels, *others)
    }


def _as_counted(channel: TargetChannel, fit: Fit, record: str) -> TargetChannel:
    """Return a channel without the samples that the fit rejected."""
    own = fit.records[record].channels.get(channel.quantity) if record in fit.records else None
    runs = own.rejected_runs if own else ()
    return replace(channel, rejected=np.union1d(channel.rejected, samples_of(runs))) if runs else channel


def _beside(channel: TargetChannel, modelled: FloatArray, travel: FloatArray, base: TimeBase) -> Prediction:
    residual = channel.measured - modelled
    removed = np.full(residual.size, np.nan)
    if np.all(np.isfinite(residual)):
        removed = fit_line(residual, channel.linear, channel.rejected).at(0, residual.size)
    return Prediction(
        measured=channel.measured,
        removed=removed,
        modelled=modelled,
        travel=travel,
        base=base,
        quantity=channel.quantity,
        rejected=channel.rejected,
    )
