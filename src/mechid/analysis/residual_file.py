"""residual.json: residuals of the torque records over the rate, a companion file of the estimate.

The budget reads it, since it has no records.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mechid.analysis.companion_file import read_companion
from mechid.analysis.residual_emission import CENTRES_HZ, TRACKED, ResidualAtRate
from mechid.arrays import FloatArray

if TYPE_CHECKING:
    from mechid.analysis.validation import RecordValidation
    from mechid.identification.result.fit import Fit

FILE_NAME, FORMAT = "residual.json", "mechid-residual/1"
DIGITS = 5
STALE = "make it anew by mechid report, or delete it"


@dataclass(frozen=True, kw_only=True, eq=False)
class ResidualRecord:
    """Residual of one torque record.

    Attributes
    ----------
    name : str
    stepping : str
        Stepping mode of the command: "full", "half" or "micro".
    microsteps : int
    noise_sigma : float
        Standard deviation of the white noise of a sample in N m.
    sample_rate_hz : float
    rates : tuple of ResidualAtRate
        In ascending order.
    named : tuple of str
        Names of the lines behind those at `TRACKED`, which the mechanism names.
    """

    name: str
    stepping: str
    microsteps: int
    noise_sigma: float
    sample_rate_hz: float
    rates: tuple[ResidualAtRate, ...]
    named: tuple[str, ...] = ()

    @property
    def noise_density(self) -> float:
        """One-sided density of the white noise in (N m)^2/Hz."""
        return 2.0 * self.noise_sigma**2 / self.sample_rate_hz


def residual_content(fit: Fit, validation: Mapping[str, RecordValidation]) -> dict[str, Any]:
    """Return the content of residual.json, without records excluded from the fit as contradictory.

    Parameters
    ----------
    fit : Fit
        Fit with its provenance, as stored.
    validation : mapping
        Validation of the records, by `validate`.
    """
    # Imported here: it loads the simulator, which reading the file does not need.
    from mechid.analysis.validation import TORQUE

    named = [one for one in fit.mechanism.named_lines if one.order is not None]
    stated = {"named": [one.name for one in named], "named_orders": [one.order for one in named]} if named else {}
    records = {}
    for name, record in validation.items():
        channel = record.channels.get(TORQUE)
        # Excluded records contradict the others and would falsify the budget.
        if channel is not None and channel.emission and not fit.records[name].reading.left_out:
            records[name] = {
                "stepping": record.command["stepping"],
                "microsteps": record.command["microsteps"],
                "noise_sigma": fit.records[name].channels[TORQUE].noise_sigma,
                "sample_rate_hz": 2.0 * float(channel.spectrum_hz[-1]),
                **stated,
                "rates": [_row(at) for at in channel.emission],
            }
    return {
        "format": FORMAT,
        "unit": "N m",
        "orders": list(TRACKED),
        "band_centres_hz": CENTRES_HZ.tolist(),
        "records": records,
        "provenance": dict(fit.provenance),
    }


def residual_records(fit: Fit, validation: Mapping[str, RecordValidation]) -> tuple[ResidualRecord, ...]:
    """Return the residuals of a fit in memory, rounded as in residual.json."""
    return _records(residual_content(fit, validation))


def read_residual(fit: Fit) -> tuple[ResidualRecord, ...] | None:
    """Read the residuals of a fit from residual.json in its folder; None if there is none.

    Raises
    ------
    InputFileError
        The file is damaged or belongs to another fit.
    """
    return read_companion(fit, FILE_NAME, FORMAT, STALE, _records)


def _records(content: Mapping[str, Any]) -> tuple[ResidualRecord, ...]:
    return tuple(_record(name, entry) for name, entry in content["records"].items())


def _row(at: ResidualAtRate) -> dict[str, Any]:
    return {
        "rate": at.rate,
        "windows": at.windows,
        "duration_s": at.duration_s,
        "amplitude": _round_values(at.amplitude),
        "sigma": _round_values(at.sigma),
        "density": _round_values(at.density),
    }


def _round_values(values: FloatArray) -> list[float]:
    return [float(f"{value:.{DIGITS}g}") for value in values]


def _record(name: str, entry: Mapping[str, Any]) -> ResidualRecord:
    # A mechanism without tooth meshes names no lines, and then the file has no such keys.
    orders = np.array([*TRACKED, *map(float, entry.get("named_orders", ()))])
    return ResidualRecord(
        name=name,
        stepping=str(entry["stepping"]),
        microsteps=int(entry["microsteps"]),
        noise_sigma=float(entry["noise_sigma"] or 0.0),
        sample_rate_hz=float(entry["sample_rate_hz"]),
        named=tuple(map(str, entry.get("named", ()))),
        rates=tuple(
            ResidualAtRate(
                orders=orders,
                rate=float(row["rate"]),
                windows=int(row["windows"]),
                duration_s=float(row["duration_s"]),
                amplitude=_array(row["amplitude"]),
                sigma=_array(row["sigma"]),
                density=_array(row["density"]),
            )
            for row in entry["rates"]
        ),
    )


def _array(values: list[float | None]) -> FloatArray:
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
