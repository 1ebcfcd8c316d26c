"""Model discrepancy beyond noise on held-out records: overall, and line by line."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from mechid.analysis.fit_residuals import FitResiduals
from mechid.analysis.validation import TORQUE
from mechid.arrays import FloatArray
from mechid.budgets.settings import RESIDUALS
from mechid.identification.output_error.noise_level import NoiseSource
from mechid.identification.result.record_result import RecordFit


@dataclass(frozen=True)
class Discrepancy:
    """Relative errors of the modelled torque.

    Attributes
    ----------
    overall : float
        Relative error of the torque.
    orders : mapping of float to float
        Relative error of single lines, by their multiple of the step rate.
    of_profiles_alone : bool
        Whether `residual_source` already accounts for the errors of lines, so that the discrepancy applies to profiles
        only.
    """

    overall: float = 0.0
    orders: Mapping[float, float] = field(default_factory=dict)
    of_profiles_alone: bool = False

    def of_lines(self, orders: FloatArray) -> FloatArray:
        """Return the relative error of lines at multiples of the step rate, (n,): measured if known, else overall."""
        if self.of_profiles_alone:
            return np.zeros(orders.size)
        return np.array([self.orders.get(float(q), self.overall) for q in orders], dtype=np.float64)


def discrepancy_of(residuals: FitResiduals, *, of_profiles_alone: bool = False) -> Discrepancy:
    """Return the discrepancy of the validation records or, without any, of all fitted records.

    A record that was left out because it contradicted the others is not used: it may itself be wrong. The errors of
    single lines come from the validation of the records, if available.
    """
    records = {name: r for name, r in residuals.fit.records.items() if not r.reading.left_out}
    held_out = {name: r for name, r in records.items() if r.use == "validate"}
    judged = held_out or records
    missed = {name: (1.0 - _number(r.fit_percent) / 100.0) ** 2 * _beyond_noise(r) for name, r in judged.items()}
    if not missed:
        return Discrepancy(of_profiles_alone=of_profiles_alone)
    seen = [name for name, share in missed.items() if share > 0.0]
    overall = float(np.sqrt(np.mean(list(missed.values()))))
    return Discrepancy(overall, _line_errors(residuals, seen, len(missed)), of_profiles_alone)


def _beyond_noise(record: RecordFit) -> float:
    """Return the share of the residual power that is not noise, 0 if within three standard errors of none.

    Only noise that was known before the fit counts: a noise level derived from the residual would explain any misfit.
    """
    rests_on_residual = record.noise_rests_on == NoiseSource.RESIDUAL
    noise = _number(record.noise_known if rests_on_residual else record.noise_sigma)
    residual = _number(record.residual_rms)
    if residual <= noise:
        return 0.0
    share = 1.0 - (noise / residual) ** 2
    return share if share > 3.0 * RESIDUALS.noise_error / np.sqrt(max(record.samples, 1)) else 0.0


def _number(value: float) -> float:
    """Return a value of a record, 0 if its simulation failed."""
    return value if math.isfinite(value) else 0.0


def _line_errors(residuals: FitResiduals, seen: list[str], judged: int) -> dict[float, float]:
    """Return the relative error of each order, RMS over records; records within their noise contribute zero."""
    squares: dict[float, list[float]] = {}
    for name in seen:
        summary = residuals.summaries.get(name)
        for order in summary.channels[TORQUE].orders if summary and TORQUE in summary.channels else ():
            if order.amplitude_error_percent is not None:
                # A small phase error moves the line's tip by its angle, at right angles to the amplitude error.
                phase = np.radians(order.phase_error_deg or 0.0)
                squares.setdefault(order.order, []).append((order.amplitude_error_percent / 100.0) ** 2 + phase**2)
    # Records within their noise have no lines here, yet count in the mean.
    share = len(seen) / judged
    return {order: float(np.sqrt(np.mean(values) * share)) for order, values in squares.items()}
