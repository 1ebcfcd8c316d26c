"""Structure that supports mechanism and payload, described by its transfer functions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from mechid.arrays import ComplexArray, FloatArray


class TransferModel(Protocol):
    """Transfer functions of any representation: modes, frequency responses or a state space."""

    @property
    def coverage_hz(self) -> tuple[float, float]:
        """Lowest and highest known frequency in Hz."""

    def response(self, frequency_hz: FloatArray) -> ComplexArray:
        """Return rotation per torque, (n, 1 + m) rad/(N m): at the interface, then along each line of sight.

        Unknown values are NaN.
        """


@dataclass(frozen=True, kw_only=True, eq=False)
class Structure:
    """Rotation of interface and line of sight per torque at the interface.

    Parameters
    ----------
    name : str
        Name used in messages, usually the file name.
    line_of_sight : tuple of str, (m,)
        Names of the payload's axes.
    model : TransferModel
    axis : str
        Axis of the torque in the structure's frame, ``"rx"``, ``"ry"`` or ``"rz"``; empty if the file does not state
        it.
    directions : mapping of str to TransferModel
        Responses to forces ``"tx"`` to ``"tz"``, in rad/N, and to torques ``"rx"`` to ``"rz"`` at the interface other
        than that of the mechanism, in the form of `model`. Empty if the file has none.
    warnings : tuple of str
        Warnings of the checks, each with its remedy.
    """

    name: str
    line_of_sight: tuple[str, ...]
    model: TransferModel
    axis: str = ""
    directions: Mapping[str, TransferModel] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    @property
    def coverage_hz(self) -> tuple[float, float]:
        """Lowest and highest known frequency in Hz."""
        return self.model.coverage_hz

    def to_interface(self, frequency_hz: ArrayLike) -> ComplexArray:
        """Return the driving-point receptance, (n,) rad/(N m), at frequencies (n,) in Hz; NaN if not known."""
        return self.model.response(np.atleast_1d(np.asarray(frequency_hz, dtype=np.float64)))[:, 0]

    def to_line_of_sight(self, frequency_hz: ArrayLike) -> ComplexArray:
        """Return line of sight per torque, (n, m) rad/(N m), at frequencies (n,) in Hz; NaN if not known."""
        return self.model.response(np.atleast_1d(np.asarray(frequency_hz, dtype=np.float64)))[:, 1:]

    def along(self, direction: str, frequency_hz: ArrayLike) -> ComplexArray | None:
        """Return line of sight per force or torque along a direction at the interface, (n, m) rad/N or rad/(N m).

        None if the file does not contain the direction; NaN at frequencies where it is not known.
        """
        if direction == self.axis:
            return self.to_line_of_sight(frequency_hz)
        if direction not in self.directions:
            return None
        return self.directions[direction].response(np.atleast_1d(np.asarray(frequency_hz, dtype=np.float64)))[:, 1:]

    def with_warnings(self, *warnings: str) -> Structure:
        """Return a copy with additional warnings."""
        return replace(self, warnings=(*self.warnings, *warnings))


def structure_from_directions(
    name: str, line_of_sight: tuple[str, ...], models: Mapping[str, TransferModel], axis: str
) -> Structure:
    """Return a structure from models for directions at the interface, which include the mechanism's axis."""
    others = {direction: model for direction, model in models.items() if direction != axis}
    return Structure(name=name, line_of_sight=line_of_sight, model=models[axis], axis=axis, directions=others)
