"""Model error beyond noise on held-out records: overall, and line by line."""

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
    """Relative errors of the model's torque.

    Attributes
    ----------
    overall : float
        Share of the torque that is missed.
    orders : mapping of float to float
        The same of single lines, by their multiple of the step rate.
    of_profiles_alone : bool
        Whether what is missed of lines is known otherwise (`residual_source`), so that it counts for profiles alone.
    """

    overall: float = 0.0
    orders: Mapping[float, float] = field(default_factory=dict)
    of_profiles_alone: bool = False

    def of_lines(self, orders: FloatArray) -> FloatArray:
        """Return the relative error of lines at multiples of the step rate, (n,): their own where seen."""
        if self.of_profiles_alone:
            return np.zeros(orders.size)
        return np.array([self.orders.get(float(q), self.overall) for q in orders], dtype=np.float64)


def discrepancy_of(residuals: FitResiduals, *, of_profiles_alone: bool = False) -> Discrepancy:
    """Return what validation records (without any: all that were fitted) say of the model.

    A record that contradicted the others and was left out is none of them: it may be wrong itself. Single lines are
    those of the records' validation, where there is one.
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
    """Return the share of the residual's power that is no noise, 0 within three standard errors of none.

    Noise is what was known of it before the fit: a level that rests on the residual excuses nothing.
    """
    rests_on_residual = record.noise_rests_on == NoiseSource.RESIDUAL
    noise = _number(record.noise_known if rests_on_residual else record.noise_sigma)
    residual = _number(record.residual_rms)
    if residual <= noise:
        return 0.0
    share = 1.0 - (noise / residual) ** 2
    return share if share > 3.0 * RESIDUALS.noise_error / np.sqrt(max(record.samples, 1)) else 0.0


def _number(value: float) -> float:
    """Return a figure of a record, 0 where its simulation failed and there is none."""
    return value if math.isfinite(value) else 0.0


def _line_errors(residuals: FitResiduals, seen: list[str], judged: int) -> dict[float, float]:
    """Return the relative error of each order, the RMS over records; those within their noise count as none."""
    squares: dict[float, list[float]] = {}
    for name in seen:
        summary = residuals.summaries.get(name)
        for order in summary.channels[TORQUE].orders if summary and TORQUE in summary.channels else ():
            if order.amplitude_error_percent is not None:
                phase = np.radians(order.phase_error_deg or 0.0)
                squares.setdefault(order.order, []).append((order.amplitude_error_percent / 100.0) ** 2 + phase**2)
    share = len(seen) / judged
    return {order: float(np.sqrt(np.mean(values) * share)) for order, values in squares.items()}
