"""The noun of this layer: a structure as the mechanism and the payload see it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from mechid.arrays import ComplexArray, FloatArray


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
    directions : mapping of str to TransferModel
        Of forces ``"tx"`` to ``"tz"``, rad/N, and torques ``"rx"`` to ``"rz"`` at the interface beside the mechanism's
        own: motion along them and line of sight, as `model` has it of that torque. Empty where the file has none.
    warnings : tuple of str
        What was odd, each with its remedy.
    """

    name: str
    line_of_sight: tuple[str, ...]
    model: TransferModel
    axis: str = ""
    directions: Mapping[str, TransferModel] = field(default_factory=dict)
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

    def along(self, direction: str, frequency_hz: ArrayLike) -> ComplexArray | None:
        """Return line of sight per force or torque along a direction at the interface, (n, m) rad/N or rad/(N m).

        None where the file does not have the direction; NaN where it is not known.
        """
        if direction == self.axis:
            return self.to_line_of_sight(frequency_hz)
        if direction not in self.directions:
            return None
        return self.directions[direction].response(np.atleast_1d(np.asarray(frequency_hz, dtype=np.float64)))[:, 1:]

    def with_warnings(self, *warnings: str) -> Structure:
        """Return the same structure with further warnings."""
        return replace(self, warnings=(*self.warnings, *warnings))


def structure_along(
    name: str, line_of_sight: tuple[str, ...], models: Mapping[str, TransferModel], axis: str
) -> Structure:
    """Return the structure of a model for each direction at the interface, that of the mechanism's axis among them."""
    others = {direction: model for direction, model in models.items() if direction != axis}
    return Structure(name=name, line_of_sight=line_of_sight, model=models[axis], axis=axis, directions=others)
