"""Modal models: frequencies, damping, and mass-normalised shapes at interface and payload."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import BoolArray, ComplexArray, FloatArray
from mechid.errors import InputFileError

RIGID_BELOW_HZ = 1e-3
"""Frequency below which a mode is a rigid-body mode; free-free solvers return these with rounding errors."""


@dataclass(frozen=True, eq=False)
class Modes:
    """Modal model, whose transfer functions are sums over the modes.

    With mass-normalised shapes phi at the interface and psi along the line of sight, torque T at the interface and
    w = 2 pi f, the rotation is the sum over k of psi_k T phi_k / (w_k^2 - w^2 + 2 i zeta_k w_k w) (Ewins, Modal
    Testing, 2nd ed., 2.4).

    Parameters
    ----------
    frequency_hz : (n,)
        Undamped frequencies; modes below `RIGID_BELOW_HZ` are rigid-body modes.
    damping : (n,)
        Ratio of critical damping.
    interface : (n,)
        Rotation of the interface about the mechanism's axis, rad/(kg^0.5 m).
    line_of_sight : (m, n)
        Rotation along each line of sight, in the same unit.
    static : (1 + m,) or None
        Static flexibility of omitted modes, rad/(N m): at the interface, then along each line of sight.

    Raises
    ------
    InputFileError
        The shapes of the arrays do not match, a frequency or damping is negative, or a number is not finite.
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
                raise InputFileError(f"{name}: contains a value that is not finite")
        for name in ("frequency_hz", "damping"):
            if np.any(getattr(self, name) < 0.0):
                at = int(np.argmin(getattr(self, name)))
                raise InputFileError(f"{name} of mode {at}: found {getattr(self, name)[at]:.9g}; write 0 or above")

    @property
    def coverage_hz(self) -> tuple[float, float]:
        """From 0 (excluded if there are rigid-body modes) to twice the highest mode, above which modes are missing."""
        low = np.nextafter(0.0, 1.0) if self.rigid.any() else 0.0
        return float(low), 2.0 * float(self.frequency_hz.max()) if not self.rigid.all() else math.inf

    @property
    def rigid(self) -> BoolArray:
        """Mask of the rigid-body modes, (n,)."""
        return self.frequency_hz < RIGID_BELOW_HZ

    @property
    def omega(self) -> FloatArray:
        """Undamped angular frequencies, (n,) rad/s, exactly zero for rigid-body modes."""
        return np.where(self.rigid, 0.0, 2.0 * np.pi * self.frequency_hz)

    def response(self, frequency_hz: FloatArray) -> ComplexArray:
        """Return rotation per torque, (n_f, 1 + m) rad/(N m); NaN at zero frequency if there are rigid-body modes."""
        w = 2.0 * np.pi * frequency_hz[:, None]
        # Rigid-body modes divide by zero at 0 Hz, which the last line turns into NaN.
        with np.errstate(divide="ignore", invalid="ignore"):
            gain = self.interface / (self.omega**2 - w**2 + 2j * self.damping * self.omega * w)
            total = gain @ np.vstack([self.interface, self.line_of_sight]).T
        if self.static is not None:
            total = total + self.static
        return np.where(np.isfinite(total), total, np.nan)

    def state_space(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return A (2n, 2n), B (2n, 1), C (1 + m, 2n) with modal coordinates and their rates as states.

        The input is the torque in N m; the outputs are the rotations in rad, that of the interface first.
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
        """Return the modes with the rigid-body modes stabilised by an attitude controller of a given bandwidth.

        Proportional-derivative control gives a rigid body the receptance of an oscillator: the rotation per torque is
        limited below the bandwidth, and is that of the free body above it.
        """
        held = np.where(self.rigid, bandwidth_hz, self.frequency_hz)
        return replace(self, frequency_hz=held, damping=np.where(self.rigid, damping, self.damping))

    def up_to(self, frequency_hz: float) -> Modes:
        """Return the modes up to a frequency in Hz; higher modes contribute their static flexibility only."""
        keep = self.frequency_hz <= frequency_hz
        shapes = np.vstack([self.interface, self.line_of_sight])
        # Far below their frequencies modes respond like springs, by their static flexibility.
        left_out = shapes[:, ~keep] @ (self.interface[~keep] / self.omega[~keep] ** 2)
        static = left_out if self.static is None else self.static + left_out
        return Modes(
            self.frequency_hz[keep], self.damping[keep], self.interface[keep], self.line_of_sight[:, keep], static
        )
