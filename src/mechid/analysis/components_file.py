"""components.json: forces and moments measured besides the drive torque, about the mounting point.

Like residual.json, a companion file of the estimate for the budget, which has no records.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mechid.analysis.companion_file import read_companion
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
    """Components of one record.

    Attributes
    ----------
    name : str
    stepping : str
        Stepping mode of the command: "full", "half" or "micro".
    microsteps : int
    components : tuple of str, (s,)
        Quantities among `records.COMPONENTS`, in the order of the matrices after the drive torque.
    rates : tuple of SideAtRate
        In ascending order.
    """

    name: str
    stepping: str
    microsteps: int
    components: tuple[str, ...]
    rates: tuple[SideAtRate, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class SideRecords:
    """Content of components.json: components of all records, and the mounting of the mechanism."""

    mounting: Mounting
    records: tuple[SideRecord, ...]


def components_content(fit: Fit, validation: Mapping[str, RecordValidation]) -> dict[str, Any] | None:
    """Return the content of components.json, None if no record has a component besides its torque.

    Records excluded from the fit as contradictory are omitted.
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
    """Return the content of the file for JSON; orders that were not tracked are NaN."""
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
    """Return the components of a fit in memory, rounded as in components.json."""
    content = components_content(fit, validation)
    return None if content is None else _records(content)


def read_components(fit: Fit) -> SideRecords | None:
    """Read the components of a fit from components.json in its folder; None if there is none.

    Raises
    ------
    InputFileError
        The file is damaged or belongs to another fit.
    """
    return read_companion(fit, FILE_NAME, FORMAT, STALE, _records)


def _records(content: Mapping[str, Any]) -> SideRecords:
    x, y, z = content["mounting_point_m"]
    return SideRecords(
        mounting=Mounting(str(content["drive_axis"]), (float(x), float(y), float(z))),
        records=tuple(_record(name, entry) for name, entry in content["records"].items()),
    )


def _row(at: SideAtRate) -> dict[str, Any]:
    """Return the entry of a rate: amplitudes, phases and errors for readers, matrices for the budget."""
    lines, tracked = side_lines(at), np.isfinite(at.amplitude[:, :1])
    return {
        "rate": at.rate,
        "windows": at.windows,
        "duration_s": at.duration_s,
        "drive_amplitude": _round_values(at.amplitude[:, 0]),
        "amplitude": [_round_values(row) for row in np.where(tracked, lines.amplitude, np.nan)],
        "phase_deg": [_round_values(row) for row in np.where(lines.known, np.degrees(lines.phase), np.nan)],
        "sigma": [_round_values(row) for row in np.where(tracked, lines.sigma, np.nan)],
        "power": [_pack_matrix(matrix) for matrix in at.power],
        "noise": [_pack_matrix(matrix) for matrix in at.noise],
    }


def _round_values(values: FloatArray) -> list[float]:
    return [float(f"{value:.{DIGITS}g}") for value in values]


def _pack_matrix(matrix: ComplexArray) -> list[float]:
    """Return the lower triangle of a Hermitian matrix, (c, c), as real and imaginary parts; empty if unknown."""
    if not np.isfinite(matrix).all():
        return []
    # The upper triangle follows from the matrix being Hermitian.
    lower = matrix[np.tril_indices(len(matrix))]
    return _round_values(np.column_stack([lower.real, lower.imag]).ravel())


def _unpack_matrix(packed: Sequence[float], channels: int) -> ComplexArray:
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
                power=np.array([_unpack_matrix(packed, len(components) + 1) for packed in row["power"]]),
                noise=np.array([_unpack_matrix(packed, len(components) + 1) for packed in row["noise"]]),
            )
            for row in entry["rates"]
        ),
    )
