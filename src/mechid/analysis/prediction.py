"""A record beside what a fit predicts of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechid.campaign import CampaignRecord
from mechid.command.edges import steps_travelled
from mechid.identification.declaration import taken_record
from mechid.identification.fit import Fit
from mechid.identification.target import target_of
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
        As it was read, N m.
    removed : (N,)
        Offset and drift between it and the model, N m; zeros where the campaign keeps them.
    modelled : (N,)
        N m; NaN from where the simulation failed, and `removed` is NaN then too.
    travel : (N,)
        Full steps that the command has travelled.
    base : TimeBase
    """

    measured: FloatArray
    removed: FloatArray
    modelled: FloatArray
    travel: FloatArray
    base: TimeBase

    @property
    def residual(self) -> FloatArray:
        """Measured less model less offset and drift, (N,) N m."""
        return self.measured - self.removed - self.modelled

    @property
    def finite(self) -> bool:
        """Whether the simulation came to the record's end."""
        return bool(np.all(np.isfinite(self.modelled)))


def as_fitted(record: CampaignRecord, fit: Fit) -> CampaignRecord:
    """Return a record of the campaign with the sign, command and use that a fit took it to have."""
    own = fit.records.get(record.name)
    return taken_record(record, own.taken) if own else record


def predict(record: CampaignRecord, fit: Fit) -> Prediction:
    """Return the torque of a record, as the fit took it, beside the prediction of that fit."""
    record = as_fitted(record, fit)
    target = target_of(record)
    own = fit.parameters.get(record.time_offset.name)
    offset_s = own.value if own else record.time_offset.value
    simulator = Simulator(fit.mechanism.plant, record.command, target.base, latest_s=abs(offset_s))
    modelled = simulate_accurately(simulator, fit.mechanism.kernel_values(), time_offset_s=offset_s).torque
    residual = target.measured - modelled
    finite = bool(np.all(np.isfinite(residual)))
    return Prediction(
        measured=target.measured,
        removed=fit_line(residual, target.linear).at(0, residual.size) if finite else np.full(residual.size, np.nan),
        modelled=modelled,
        travel=steps_travelled(record.command.rate, target.base.times - offset_s),
        base=target.base,
    )
