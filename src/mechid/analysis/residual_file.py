"""residual.json: what a fit leaves of its torque records over the rate, beside the estimate it belongs to.

The budget has no records; this is what it needs of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mechid.analysis.beside_estimate import read_beside
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
    """What is left of one torque record.

    Attributes
    ----------
    name : str
    stepping : str
        As it was driven: "full", "half" or "micro".
    microsteps : int
    noise_sigma : float
        Of a sample, N m, white.
    sample_rate_hz : float
    rates : tuple of ResidualAtRate
        Ascending.
    """

    name: str
    stepping: str
    microsteps: int
    noise_sigma: float
    sample_rate_hz: float
    rates: tuple[ResidualAtRate, ...]

    @property
    def noise_density(self) -> float:
        """One-sided density of the white noise, (N m)^2/Hz."""
        return 2.0 * self.noise_sigma**2 / self.sample_rate_hz


def residual_content(fit: Fit, validation: Mapping[str, RecordValidation]) -> dict[str, Any]:
    """Return the content of residual.json; records that contradicted the others and were left out are not in it.

    Parameters
    ----------
    fit : Fit
        Signed, as it is left.
    validation : mapping
        Of the records, as `validate` makes it.
    """
    from mechid.analysis.validation import TORQUE  # the simulator, which reading the file does not need

    records = {}
    for name, record in validation.items():
        channel = record.channels.get(TORQUE)
        if channel is not None and channel.emission and not fit.records[name].reading.left_out:
            records[name] = {
                "stepping": record.command["stepping"],
                "microsteps": record.command["microsteps"],
                "noise_sigma": fit.records[name].channels[TORQUE].noise_sigma,
                "sample_rate_hz": 2.0 * float(channel.spectrum_hz[-1]),
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
    """Return what is left of the records of a fit in memory, rounded as residual.json holds it."""
    return _records(residual_content(fit, validation))


def read_residual(fit: Fit) -> tuple[ResidualRecord, ...] | None:
    """Return what is left of the records of a fit by its folder's residual.json; None where there is none.

    Raises
    ------
    InputFileError
        The file is damaged, or of another fit.
    """
    return read_beside(fit, FILE_NAME, FORMAT, STALE, _records)


def _records(content: Mapping[str, Any]) -> tuple[ResidualRecord, ...]:
    return tuple(_record(name, entry) for name, entry in content["records"].items())


def _row(at: ResidualAtRate) -> dict[str, Any]:
    return {
        "rate": at.rate,
        "windows": at.windows,
        "duration_s": at.duration_s,
        "amplitude": _rounded(at.amplitude),
        "sigma": _rounded(at.sigma),
        "density": _rounded(at.density),
    }


def _rounded(values: FloatArray) -> list[float]:
    return [float(f"{value:.{DIGITS}g}") for value in values]


def _record(name: str, entry: Mapping[str, Any]) -> ResidualRecord:
    return ResidualRecord(
        name=name,
        stepping=str(entry["stepping"]),
        microsteps=int(entry["microsteps"]),
        noise_sigma=float(entry["noise_sigma"] or 0.0),
        sample_rate_hz=float(entry["sample_rate_hz"]),
        rates=tuple(
            ResidualAtRate(
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
