"""Frequency responses: transfer functions tabulated over frequency, with interpolation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.errors import InputFileError

KINDS = {"rad/(N*m)": 0, "rad/s/(N*m)": 1, "rad/s^2/(N*m)": 2}
"""Order of the time derivative of the rotation by SI unit: receptance, mobility and accelerance."""


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """Transfer functions at ascending frequencies.

    Responses are interpolated linearly in the complex plane; outside the tabulated range they are NaN.

    Parameters
    ----------
    frequency_hz : (n,)
        Ascending.
    values : (n, 1 + m) complex
        Rotation per torque in rad/(N m): of the interface (NaN if not measured), then along each line of sight.

    Raises
    ------
    InputFileError
        There are fewer than two points, the frequencies do not ascend, or a number is not finite.
    """

    frequency_hz: FloatArray
    values: ComplexArray

    def __post_init__(self) -> None:
        f = self.frequency_hz
        if f.size < 2 or self.values.shape[0] != f.size:
            raise InputFileError(f"{f.size} frequencies; a frequency response needs at least two")
        if not np.all(np.diff(f) > 0.0):
            at = int(np.argmin(np.diff(f)))
            raise InputFileError(f"frequency {f[at + 1]:.9g} Hz comes after {f[at]:.9g} Hz; sort the lines")
        if f[0] < 0.0:
            raise InputFileError(f"frequency {f[0]:.9g} Hz; give the one-sided response, from 0 Hz on")
        if not np.isfinite(self.values[:, 1:]).all():
            raise InputFileError("the response along the line of sight contains a value that is not finite")

    @property
    def coverage_hz(self) -> tuple[float, float]:
        """First and last frequency, Hz."""
        return float(self.frequency_hz[0]), float(self.frequency_hz[-1])

    def response(self, frequency_hz: FloatArray) -> ComplexArray:
        """Return rotation per torque, (n_f, 1 + m) rad/(N m); NaN outside the coverage."""
        columns = [
            np.interp(frequency_hz, self.frequency_hz, column, left=np.nan, right=np.nan) for column in self.values.T
        ]
        return np.array(columns, dtype=np.complex128).T


def to_receptance(frequency_hz: FloatArray, values: ComplexArray, differentiated: int) -> ComplexArray:
    """Convert a mobility (1) or accelerance (2) to a receptance, (n, k), by division by (2 pi i f)^differentiated.

    Raises
    ------
    InputFileError
        The response starts at 0 Hz, where a rate or an acceleration does not determine the rotation.
    """
    if differentiated and frequency_hz[0] == 0.0:
        raise InputFileError("a mobility or accelerance at 0 Hz does not determine the rotation; omit 0 Hz")
    factor = (2j * np.pi * frequency_hz) ** differentiated
    return np.asarray(values / factor[:, None], dtype=np.complex128)
