"""Frequency responses: transfer functions known at frequencies, interpolated between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.errors import InputFileError

KINDS = {"rad/(N*m)": 0, "rad/s/(N*m)": 1, "rad/s^2/(N*m)": 2}
"""Receptance, mobility and accelerance by their SI unit: how often the rotation is differentiated."""


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """Transfer functions at ascending frequencies.

    Between its points a response is interpolated linearly in the complex plane; outside them it is NaN.

    Parameters
    ----------
    frequency_hz : (n,)
        Ascending.
    values : (n, 1 + m) complex
        Rotation per torque in rad/(N m): of the interface (NaN where not measured), then along each line of sight.

    Raises
    ------
    InputFileError
        Fewer than two points, frequencies that do not ascend, or numbers that are none.
    """

    frequency_hz: FloatArray
    values: ComplexArray

    def __post_init__(self) -> None:
        f = self.frequency_hz
        if f.size < 2 or self.values.shape[0] != f.size:
            raise InputFileError(f"{f.size} frequencies; a frequency response needs two at least")
        if not np.all(np.diff(f) > 0.0):
            at = int(np.argmin(np.diff(f)))
            raise InputFileError(f"frequency {f[at + 1]:.9g} Hz comes after {f[at]:.9g} Hz; sort the lines")
        if f[0] < 0.0:
            raise InputFileError(f"frequency {f[0]:.9g} Hz; give the one-sided response, from 0 Hz on")
        if not np.isfinite(self.values[:, 1:]).all():
            raise InputFileError("the response along the line of sight holds what is no finite number")

    @property
    def coverage_hz(self) -> tuple[float, float]:
        """First and last frequency, Hz."""
        return float(self.frequency_hz[0]), float(self.frequency_hz[-1])

    def response(self, frequency_hz: FloatArray) -> ComplexArray:
        """Return rotation per torque, (n_f, 1 + m) rad/(N m), NaN outside the coverage."""
        columns = [
            np.interp(frequency_hz, self.frequency_hz, column, left=np.nan, right=np.nan) for column in self.values.T
        ]
        return np.array(columns, dtype=np.complex128).T


def to_receptance(frequency_hz: FloatArray, values: ComplexArray, differentiated: int) -> ComplexArray:
    """Return a mobility (1) or accelerance (2) as receptance, (n, k): divided by (2 pi i f)^differentiated.

    Raises
    ------
    InputFileError
        It starts at 0 Hz, where a rate or an acceleration does not tell the rotation.
    """
    if differentiated and frequency_hz[0] == 0.0:
        raise InputFileError("a mobility or accelerance at 0 Hz does not give the rotation; leave 0 Hz out")
    factor = (2j * np.pi * frequency_hz) ** differentiated
    return np.asarray(values / factor[:, None], dtype=np.complex128)
