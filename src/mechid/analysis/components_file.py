"""components.json: forces and moments that the bench measured beside the drive torque, at the mounting point.

It lies beside the estimate that it belongs to, as residual.json does; the budget has no records.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mechid.analysis.beside_estimate import read_beside
from mechid.analysis.residual_emission import TRACKED
from mechid.analysis.side_components import SideAtRate, side_lines
from mechid.analysis.validation import RecordValidation
from mechid.arrays import ComplexArray, FloatArray
from mechid.identification.result.fit import Fit
from mechid.records import Mounting
from mechid.units import unit_words

FILE_NAME, FORMAT = "components.json", "mechid-components/1"
DIGITS = 6
STALE = "make it anew by mechid report, or delete it"


@dataclass(frozen=True, kw_only=True, eq=False)
class SideRecord:
    """The components of one record.

    Attributes
    ----------
    name : str
    stepping : str
        As it was driven: "full", "half" or "micro".
    microsteps : int
    components : tuple of str, (s,)
        Of `records.COMPONENTS`, in the order of the matrices behind the drive torque.
    rates : tuple of SideAtRate
        Ascending.
    """

    name: str
    stepping: str
    microsteps: int
    components: tuple[str, ...]
    rates: tuple[SideAtRate, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class SideRecords:
    """What components.json holds: all records, and how the mechanism stood on the table."""

    mounting: Mounting
    records: tuple[SideRecord, ...]


def components_content(fit: Fit, validation: Mapping[str, RecordValidation]) -> dict[str, Any] | None:
    """Return the content of components.json, None where no record has a component beside its torque.

    Records that contradicted the others and were left out are not in it.
    """
    measured = {
        name: record for name, record in validation.items() if record.side and not fit.records[name].reading.left_out
    }
    mounting = next((record.mounting for record in measured.values()), None)
    if mounting is None:
        return None
    records = tuple(
        SideRecord(
            name=name,
            stepping=str(record.command["stepping"]),
            microsteps=int(record.command["microsteps"]),
            components=record.components,
            rates=record.side,
        )
        for name, record in measured.items()
    )
    return components_text(SideRecords(mounting=mounting, records=records), fit.provenance)


def components_text(measured: SideRecords, provenance: Mapping[str, Any]) -> dict[str, Any]:
    """Return what the file holds, as JSON can; numbers that are none are where an order was not tracked."""
    return {
        "format": FORMAT,
        "drive_axis": measured.mounting.drive_axis,
        "mounting_point_m": list(measured.mounting.point_m),
        "orders": list(TRACKED),
        "records": {
            record.name: {
                "stepping": record.stepping,
                "microsteps": record.microsteps,
                "components": list(record.components),
                "units": [unit_words(quantity) for quantity in record.components],
                "rates": [_row(at) for at in record.rates],
            }
            for record in measured.records
        },
        "provenance": dict(provenance),
    }


def side_records(fit: Fit, validation: Mapping[str, RecordValidation]) -> SideRecords | None:
    """Return the components of the records of a fit in memory, rounded as components.json holds them."""
    content = components_content(fit, validation)
    return None if content is None else _records(content)


def read_components(fit: Fit) -> SideRecords | None:
    """Return the components of the records of a fit by its folder's components.json; None where there is none.

    Raises
    ------
    InputFileError
        The file is damaged, or of another fit.
    """
    return read_beside(fit, FILE_NAME, FORMAT, STALE, _records)


def _records(content: Mapping[str, Any]) -> SideRecords:
    x, y, z = content["mounting_point_m"]
    return SideRecords(
        mounting=Mounting(str(content["drive_axis"]), (float(x), float(y), float(z))),
        records=tuple(_record(name, entry) for name, entry in content["records"].items()),
    )


def _row(at: SideAtRate) -> dict[str, Any]:
    """Return a rate: for people amplitude, phase and error of each line, for the budget the matrices."""
    lines, tracked = side_lines(at), np.isfinite(at.amplitude[:, :1])
    return {
        "rate": at.rate,
        "windows": at.windows,
        "duration_s": at.duration_s,
        "drive_amplitude": _rounded(at.amplitude[:, 0]),
        "amplitude": [_rounded(row) for row in np.where(tracked, lines.amplitude, np.nan)],
        "phase_deg": [_rounded(row) for row in np.where(lines.known, np.degrees(lines.phase), np.nan)],
        "sigma": [_rounded(row) for row in np.where(tracked, lines.sigma, np.nan)],
        "power": [_packed(matrix) for matrix in at.power],
        "noise": [_packed(matrix) for matrix in at.noise],
    }


def _rounded(values: FloatArray) -> list[float]:
    return [float(f"{value:.{DIGITS}g}") for value in values]


def _packed(matrix: ComplexArray) -> list[float]:
    """Return a Hermitian matrix, (c, c), as its lower triangle, real and imaginary part of each; none where unknown."""
    if not np.isfinite(matrix).all():
        return []
    lower = matrix[np.tril_indices(len(matrix))]
    return _rounded(np.column_stack([lower.real, lower.imag]).ravel())


def _unpacked(packed: Sequence[float], channels: int) -> ComplexArray:
    if not packed:
        return np.full((channels, channels), np.nan, dtype=np.complex128)
    pairs = np.array(packed, dtype=np.float64).reshape(-1, 2)
    matrix = np.zeros((channels, channels), dtype=np.complex128)
    matrix[np.tril_indices(channels)] = pairs[:, 0] + 1j * pairs[:, 1]
    return np.asarray(matrix + np.tril(matrix, -1).conj().T)


def _record(name: str, entry: Mapping[str, Any]) -> SideRecord:
    components = tuple(str(quantity) for quantity in entry["components"])
    return SideRecord(
        name=name,
        stepping=str(entry["stepping"]),
        microsteps=int(entry["microsteps"]),
        components=components,
        rates=tuple(
            SideAtRate(
                rate=float(row["rate"]),
                windows=int(row["windows"]),
                duration_s=float(row["duration_s"]),
                power=np.array([_unpacked(packed, len(components) + 1) for packed in row["power"]]),
                noise=np.array([_unpacked(packed, len(components) + 1) for packed in row["noise"]]),
            )
            for row in entry["rates"]
        ),
    )
