"""Response of a measuring table to loads at its interface, from modes or as measured, with its standard errors.

A load F(f) on the table is measured as H(f) F(f), H a 6 x 6 matrix that is the identity at rest. A mode of frequency
f_k and damping zeta_k that carries the share p_k of a component makes of it (a plate on force transducers, whose spring
force is measured):

    H = sum_k p_k / (1 - (f / f_k)^2 + 2 i zeta_k f / f_k)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.campaign.table_response_entry import TableMode
from mechid.emissions.settings import BENCH

SIX = 6
POINTS = 4000
"""Frequencies at which modes are evaluated up to `BENCH.modal_reach` times the highest one."""


class TableResponse(Protocol):
    """Response of a table from any source."""

    @property
    def grid_hz(self) -> FloatArray:
        """Frequencies that resolve it, (n,), ascending from 0."""

    @property
    def coverage_hz(self) -> FloatArray:
        """Lowest and highest frequency at which each component is known, (6, 2); NaN of one that is not."""

    def at(self, frequency_hz: FloatArray) -> ComplexArray:
        """Return measured loads per load, (n, 6, 6), in N and N m; outside of its coverage the nearest value."""

    def sigma(self, frequency_hz: FloatArray) -> FloatArray:
        """Return the standard error of the magnitude of each element, (n, 6, 6)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ModalTable:
    """Response by modes.

    Parameters
    ----------
    modes : sequence of TableMode
    uncertainty, damping_uncertainty : float
        Relative standard errors of the frequencies and of the dampings.
    """

    modes: Sequence[TableMode]
    uncertainty: float
    damping_uncertainty: float

    @cached_property
    def grid_hz(self) -> FloatArray:
        """Frequencies up to beyond the highest mode, (n,)."""
        return np.linspace(0.0, BENCH.modal_reach * max(mode.frequency_hz for mode in self.modes), POINTS)

    @property
    def coverage_hz(self) -> FloatArray:
        """Coverage of each component, (6, 2)."""
        # A component without a mode among those found has none below the highest of them.
        rigid = BENCH.rigid_share * max(mode.frequency_hz for mode in self.modes)
        own = {mode.component for mode in self.modes}
        return np.array([[0.0, float(self.grid_hz[-1]) if k in own else rigid] for k in range(SIX)])

    def at(self, frequency_hz: FloatArray) -> ComplexArray:
        """Return measured loads per load, (n, 6, 6)."""
        values = np.tile(np.eye(SIX, dtype=np.complex128), (frequency_hz.size, 1, 1))
        own = {mode.component for mode in self.modes}
        for k in own:
            values[:, k, k] = 0.0
        for mode in self.modes:
            values[:, mode.component, mode.component] += mode.share / _denominator(mode, frequency_hz)
        return values

    def sigma(self, frequency_hz: FloatArray) -> FloatArray:
        """Return the standard errors that those of frequencies and dampings make, (n, 6, 6)."""
        values = self.at(frequency_hz)
        variance = np.zeros(values.shape)
        for mode in self.modes:
            own = (slice(None), mode.component, mode.component)
            r, size = frequency_hz / mode.frequency_hz, np.abs(values[own])
            # Derivatives of p / D by the logarithms of frequency and damping; what turns the phase alone changes no
            # amplitude, so the parts in phase with the response count.
            each = mode.share / _denominator(mode, frequency_hz) ** 2 * np.conj(values[own]) / np.maximum(size, 1e-300)
            by_frequency = np.real((2.0 * r**2 - 2j * mode.damping * r) * each)
            by_damping = np.real(2j * mode.damping * r * each)
            variance[own] += (self.uncertainty * by_frequency) ** 2 + (self.damping_uncertainty * by_damping) ** 2
        return np.asarray(np.sqrt(variance), dtype=np.float64)


def _denominator(mode: TableMode, frequency_hz: FloatArray) -> ComplexArray:
    r = frequency_hz / mode.frequency_hz
    return np.asarray(1.0 - r**2 + 2j * mode.damping * r, dtype=np.complex128)


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredTable:
    """Response as measured by hammer or shaker.

    Parameters
    ----------
    frequency_hz : ndarray, shape (n,)
        Ascending.
    values : ndarray, shape (n, 6, 6)
        Measured loads per load, in N and N m; the identity in components that were not measured.
    measured : tuple of int
        Components that were measured, 0 to 5.
    uncertainty : float
        Relative standard error.
    """

    frequency_hz: FloatArray
    values: ComplexArray
    measured: tuple[int, ...]
    uncertainty: float

    @cached_property
    def grid_hz(self) -> FloatArray:
        """Its own frequencies, from 0 on, (n,)."""
        f = self.frequency_hz
        return f if f[0] == 0.0 else np.concatenate([np.linspace(0.0, f[0], 16, endpoint=False), f])

    @property
    def coverage_hz(self) -> FloatArray:
        """Coverage of each component, (6, 2)."""
        ends = [float(self.frequency_hz[0]), float(self.frequency_hz[-1])]
        return np.array([ends if k in self.measured else [np.nan, np.nan] for k in range(SIX)])

    def at(self, frequency_hz: FloatArray) -> ComplexArray:
        """Return measured loads per load, (n, 6, 6), linear between the points."""
        # At rest a response is real; towards it the phase of the first point is led to zero.
        known = self.frequency_hz if self.frequency_hz[0] == 0.0 else np.append(0.0, self.frequency_hz)
        values = self.values if known is self.frequency_hz else np.concatenate([self.values[:1].real, self.values])
        out = np.empty((frequency_hz.size, SIX, SIX), dtype=np.complex128)
        for row, column in np.ndindex(SIX, SIX):
            out[:, row, column] = np.interp(frequency_hz, known, values[:, row, column])
        return out

    def sigma(self, frequency_hz: FloatArray) -> FloatArray:
        """Return the stated standard error and the roughness of the curves together, (n, 6, 6)."""
        own = np.hypot(self.uncertainty * np.abs(self.values), self._roughness)
        out = np.empty((frequency_hz.size, SIX, SIX))
        for row, column in np.ndindex(SIX, SIX):
            out[:, row, column] = np.interp(frequency_hz, self.frequency_hz, own[:, row, column])
        return out

    @cached_property
    def _roughness(self) -> FloatArray:
        """RMS over neighbouring points of what each is off the line through its neighbours, (n, 6, 6).

        Noise and curvature show in it alike; both make the value between two points uncertain.
        """
        off = np.zeros(self.values.shape)
        if len(off) > 2:
            middle = 0.5 * (self.values[:-2] + self.values[2:])
            # of independent noise the difference has 1 + 2 / 4 of the variance
            off[1:-1] = np.abs(self.values[1:-1] - middle) / np.sqrt(1.5)
            off[0], off[-1] = off[1], off[-2]
        width = min(BENCH.roughness_points, len(off))
        total = np.cumsum(np.concatenate([np.zeros((1, SIX, SIX)), off**2]), axis=0)
        first = np.clip(np.arange(len(off)) - width // 2, 0, len(off) - width)
        power = np.maximum(total[first + width] - total[first], 0.0) / width
        return np.asarray(np.sqrt(power), dtype=np.float64)
