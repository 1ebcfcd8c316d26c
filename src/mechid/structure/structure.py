"""The noun of this layer: a structure as the mechanism and the payload see it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


class TransferModel(Protocol):
    """Transfer functions in whatever form a file gave them."""

    @property
    def coverage_hz(self) -> tuple[float, float]:
        """Lowest and highest frequency that it knows, Hz."""

    def response(self, frequency_hz: FloatArray) -> ComplexArray:
        """Return rotation per torque, (n, 1 + m) rad/(N m): at the interface, then along each line of sight.

        NaN where it is not known.
        """


@dataclass(frozen=True, kw_only=True, eq=False)
class Structure:
    """Rotation of interface and line of sight per torque at the interface.

    Parameters
    ----------
    name : str
        What messages call it, as a rule its file.
    line_of_sight : tuple of str, (m,)
        Names of the payload's axes.
    model : TransferModel
    axis : str
        Axis of the torque in the structure's own frame, ``"rx"``, ``"ry"`` or ``"rz"``; empty where the file does not
        say.
    warnings : tuple of str
        What was odd, each with its remedy.
    """

    name: str
    line_of_sight: tuple[str, ...]
    model: TransferModel
    axis: str = ""
    warnings: tuple[str, ...] = ()

    @property
    def coverage_hz(self) -> tuple[float, float]:
        """Lowest and highest frequency that is known, Hz."""
        return self.model.coverage_hz

    def to_interface(self, frequency_hz: ArrayLike) -> ComplexArray:
        """Return the driving-point receptance, (n,) rad/(N m), at frequencies (n,) in Hz; NaN where not known."""
        return self.model.response(np.atleast_1d(np.asarray(frequency_hz, dtype=np.float64)))[:, 0]

    def to_line_of_sight(self, frequency_hz: ArrayLike) -> ComplexArray:
        """Return line of sight per torque, (n, m) rad/(N m), at frequencies (n,) in Hz; NaN where not known."""
        return self.model.response(np.atleast_1d(np.asarray(frequency_hz, dtype=np.float64)))[:, 1:]

    def with_warnings(self, *warnings: str) -> Structure:
        """Return the same structure with further warnings."""
        return replace(self, warnings=(*self.warnings, *warnings))
