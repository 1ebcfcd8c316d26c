"""What the model misses beyond noise, on records it was not fitted to: overall, and line by line."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.budgets.settings import RESIDUALS
from mechid.identification.output_error.noise_level import NoiseSource
from mechid.reading.whole import read_result

REPORT_NAME = "report.json"


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


def read_discrepancy(content: Mapping[str, Any], folder: Path) -> Discrepancy:
    """Return what validation records (without any: all that were fitted) say of the model.

    A record that contradicted the others and was left out is none of them: it may be wrong itself.

    Single lines are those of the report beside the estimate, where it is of the same fit.

    Parameters
    ----------
    content : mapping
        Of estimate.json.
    folder : Path
        Where it lies.
    """
    records = {name: r for name, r in content["records"].items() if "use" not in r.get("taken", {})}
    held_out = {name: r for name, r in records.items() if r["use"] == "validate"}
    judged = held_out or records
    missed = {name: (1.0 - (r["fit_percent"] or 0.0) / 100.0) ** 2 * _beyond_noise(r) for name, r in judged.items()}
    if not missed:
        return Discrepancy()
    seen = [name for name, share in missed.items() if share > 0.0]
    return Discrepancy(float(np.sqrt(np.mean(list(missed.values())))), _line_errors(content, folder, seen, len(missed)))


def _beyond_noise(record: Mapping[str, Any]) -> float:
    """Return the share of the residual's power that is no noise, 0 within three standard errors of none.

    Noise is what was known of it before the fit: a level that rests on the residual excuses nothing.
    """
    known = "noise_known" if record.get("noise_rests_on") == NoiseSource.RESIDUAL else "noise_sigma"
    residual, noise = record["residual_rms"] or 0.0, record[known] or 0.0
    if residual <= noise:
        return 0.0
    share = 1.0 - (noise / residual) ** 2
    return share if share > 3.0 * RESIDUALS.noise_error / np.sqrt(max(record["samples"], 1)) else 0.0


def _line_errors(content: Mapping[str, Any], folder: Path, seen: list[str], judged: int) -> dict[float, float]:
    """Return the relative error of each order, the RMS over records; those within their noise count as none."""
    squares: dict[float, list[float]] = {}
    for row in report_of(content, folder).get("orders", []):
        torque = row["quantity"] == "torque"
        if torque and row["name"] in seen and row["amplitude_error_percent"] is not None:
            phase = np.radians(row["phase_error_deg"] or 0.0)
            squares.setdefault(float(row["order"]), []).append((row["amplitude_error_percent"] / 100.0) ** 2 + phase**2)
    share = len(seen) / judged
    return {order: float(np.sqrt(np.mean(values) * share)) for order, values in squares.items()}


def report_of(content: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
    """Return the report beside an estimate.json where it is of the same fit, empty where there is none.

    Parameters
    ----------
    content : mapping
        Of estimate.json.
    folder : Path
        Where it lies.
    """
    try:
        report = json.loads(read_result(folder / REPORT_NAME))
    except (OSError, ValueError):
        return {}
    same = isinstance(report, dict) and "provenance" in content and report.get("provenance") == content["provenance"]
    return report if same else {}
