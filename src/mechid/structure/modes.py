"""Modes: frequency, damping, and mass-normalised shapes at interface and payload."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import BoolArray, ComplexArray, FloatArray
from mechid.errors import InputFileError

RIGID_BELOW_HZ = 1e-3
"""A free-free solver returns rigid-body modes at frequencies of this size and below."""


@dataclass(frozen=True, eq=False)
class Modes:
    """A modal model; transfer functions are sums over its modes.

    With mass-normalised shapes, T the torque at the interface and w = 2 pi f,
    psi T phi / (w_k^2 - w^2 + 2 i zeta_k w_k w), summed over k (Ewins, Modal Testing, 2nd ed., 2.4).

    Parameters
    ----------
    frequency_hz : (n,)
        Undamped; below `RIGID_BELOW_HZ` a mode is a rigid-body mode.
    damping : (n,)
        Share of critical.
    interface : (n,)
        Rotation of the interface about the mechanism's axis, rad/(kg^0.5 m).
    line_of_sight : (m, n)
        Rotation along each line of sight, same unit.
    static : (1 + m,)
        Flexibility of the modes left out, rad/(N m): at the interface, then along each line of sight.

    Raises
    ------
    InputFileError
        Shapes that do not fit together, a frequency or damping below zero, or a number that is none.
    """

    frequency_hz: FloatArray
    damping: FloatArray
    interface: FloatArray
    line_of_sight: FloatArray
    static: FloatArray | None = None

    def __post_init__(self) -> None:
        n = self.frequency_hz.size
        if not n or self.damping.shape != (n,) or self.interface.shape != (n,) or self.line_of_sight.shape[1:] != (n,):
            raise InputFileError("give frequency, damping and every shape of each mode, at least one mode")
        for name in ("frequency_hz", "damping", "interface", "line_of_sight"):
            if not np.isfinite(getattr(self, name)).all():
                raise InputFileError(f"{name}: holds what is no finite number")
        for name in ("frequency_hz", "damping"):
            if np.any(getattr(self, name) < 0.0):
                at = int(np.argmin(getattr(self, name)))
                raise InputFileError(f"{name} of mode {at}: found {getattr(self, name)[at]:.9g}; write 0 or above")

    @property
    def coverage_hz(self) -> tuple[float, float]:
        """From 0 (above it where there are rigid-body modes) to twice the highest mode: beyond, modes are missing."""
        low = np.nextafter(0.0, 1.0) if self.rigid.any() else 0.0
        return float(low), 2.0 * float(self.frequency_hz.max()) if not self.rigid.all() else math.inf

    @property
    def rigid(self) -> BoolArray:
        """Which modes are rigid-body modes, (n,)."""
        return self.frequency_hz < RIGID_BELOW_HZ

    @property
    def omega(self) -> FloatArray:
        """Undamped angular frequencies, (n,) rad/s, exactly zero for rigid-body modes."""
        return np.where(self.rigid, 0.0, 2.0 * np.pi * self.frequency_hz)

    def response(self, frequency_hz: FloatArray) -> ComplexArray:
        """Return rotation per torque, (n_f, 1 + m) rad/(N m); NaN at zero frequency where rigid-body modes are."""
        w = 2.0 * np.pi * frequency_hz[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            gain = self.interface / (self.omega**2 - w**2 + 2j * self.damping * self.omega * w)
            total = gain @ np.vstack([self.interface, self.line_of_sight]).T
        if self.static is not None:
            total = total + self.static
        return np.where(np.isfinite(total), total, np.nan)

    def state_space(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return A (2n, 2n), B (2n, 1), C (1 + m, 2n): states are modal coordinates, then their rates.

        Input is the torque in N m; outputs are the rotations in rad, of the interface first.
        """
        n = self.frequency_hz.size
        A = np.zeros((2 * n, 2 * n))
        A[:n, n:] = np.eye(n)
        A[n:, :n] = -np.diag(self.omega**2)
        A[n:, n:] = -np.diag(2.0 * self.damping * self.omega)
        B = np.concatenate([np.zeros(n), self.interface])[:, None]
        shapes = np.vstack([self.interface, self.line_of_sight])
        return A, B, np.hstack([shapes, np.zeros_like(shapes)])

    def with_attitude_control(self, bandwidth_hz: float, damping: float) -> Modes:
        """Return the modes with the rigid-body ones held by an attitude controller of this bandwidth.

        Proportional-derivative control of a rigid body gives it the receptance of an oscillator:
        the rotation per torque below the bandwidth is limited, above it is that of the free body.
        """
        held = np.where(self.rigid, bandwidth_hz, self.frequency_hz)
        return replace(self, frequency_hz=held, damping=np.where(self.rigid, damping, self.damping))

    def up_to(self, frequency_hz: float) -> Modes:
        """Return the modes up to a frequency in Hz; of those above, their static flexibility is kept."""
        keep = self.frequency_hz <= frequency_hz
        shapes = np.vstack([self.interface, self.line_of_sight])
        left_out = shapes[:, ~keep] @ (self.interface[~keep] / self.omega[~keep] ** 2)
        static = left_out if self.static is None else self.static + left_out
        return Modes(
            self.frequency_hz[keep], self.damping[keep], self.interface[keep], self.line_of_sight[:, keep], static
        )
