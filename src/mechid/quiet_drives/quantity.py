"""Quantity that a table makes small: the torque on a held base, or the line of sight through a structure.

All levels are root mean squares over lines. The root sum of squares over the lines of sight of a line at frequency f is
|T(f)| sqrt(sum_m |H_m(f)|^2), H_m the structure's response in rad/(N m), so that the torque's lines need one real
weight each, whatever the number of axes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.structure import Structure


@dataclass(frozen=True, eq=False)
class Quantity:
    """Torque where `structure` is None, else the root sum of squares of its lines of sight."""

    structure: Structure | None = None

    @property
    def unit(self) -> str:
        """Unit of a level, as files write it."""
        return "N*m" if self.structure is None else "rad"

    def weight(self, frequency_hz: FloatArray) -> FloatArray:
        """Return the quantity per torque, (n,), at frequencies in Hz; 0 where the structure's response is unknown."""
        if self.structure is None:
            return np.ones(frequency_hz.size)
        per_axis = self.structure.to_line_of_sight(frequency_hz)
        return np.asarray(np.nan_to_num(np.sqrt(np.sum(np.abs(per_axis) ** 2, axis=1)), nan=0.0))

    def uncovered_share(self, frequency_hz: FloatArray, lines: ComplexArray) -> float:
        """Return the share of the RMS of torque lines, (n,), at frequencies in Hz that the structure does not cover."""
        power = np.abs(lines) ** 2
        if self.structure is None or not power.any():
            return 0.0
        unknown = np.isnan(self.structure.to_line_of_sight(frequency_hz)).any(axis=1)
        return float(np.sqrt(power[unknown].sum() / power.sum()))


TORQUE = Quantity()
"""Torque on a held base."""
