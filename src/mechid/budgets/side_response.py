"""Line-of-sight response to the other force and moment components at one rate.

Lines with a phase relative to the drive torque are added coherently. Lines without are added by magnitude, in phase
with the rest, as a bound of each line along each line of sight. At orders without a modelled line there is no phase to
add to; these lines form a separate source.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechid.analysis.residual_emission import TRACKED
from mechid.arrays import ComplexArray, FloatArray, IntArray
from mechid.budgets.pointing_error import Incoherent
from mechid.budgets.side_here import SideHere
from mechid.budgets.side_source import SideSource
from mechid.budgets.steady_state import SteadyState


@dataclass(frozen=True, eq=False)
class SideResponse:
    """Components at the lines of a steady torque.

    Attributes
    ----------
    here : SideHere
    at : (n,) of int
        Position of each modelled line among the tracked orders, -1 for an untracked one.
    phase : (n,) complex
        Phase factors of the modelled lines, of magnitude 1; 0 for a line below its own error.
    transfer : (n, m, s) complex
        Line of sight per component, rad/N or rad/(N m).
    alone : Incoherent or None
        Components at orders without a modelled line; None if there are none.
    """

    here: SideHere
    at: IntArray
    phase: ComplexArray
    transfer: ComplexArray
    alone: Incoherent | None

    @property
    def lines(self) -> ComplexArray:
        """Components with a known phase, (n, s) N or N m; 0 otherwise."""
        return np.asarray(_rows_or_zero(self.here.lines, self.at) * self.phase[:, None])

    @property
    def bounds(self) -> FloatArray:
        """Amplitudes of components without a known phase, (n, s)."""
        without = np.where(self.phase[:, None] == 0.0, np.abs(_rows_or_zero(self.here.lines, self.at)), 0.0)
        return np.asarray(_rows_or_zero(self.here.bounds, self.at) + without, dtype=np.float64)

    @property
    def coherent(self) -> ComplexArray:
        """Line of sight of the components with a known phase, (n, m) rad."""
        return np.asarray(np.einsum("nms,ns->nm", self.transfer, self.lines))

    def parts(self) -> ComplexArray:
        """Return the line of sight of each component alone, (n, m, s) rad; the magnitude if its phase is unknown."""
        return np.asarray(self.transfer * self.lines[:, None, :] + np.abs(self.transfer) * self.bounds[:, None, :])

    def add_to(self, drive: ComplexArray) -> ComplexArray:
        """Return the line of sight of drive torque and components together, (n, m) rad."""
        return _with_bound(drive + self.coherent, np.einsum("nms,ns->nm", np.abs(self.transfer), self.bounds))

    def slopes(self, turning: FloatArray) -> ComplexArray:
        """Return the derivative of the coherent part, (p, n, m) rad: its phases follow those of the drive torque.

        Parameters
        ----------
        turning : (p, n)
            Derivative of the phases of the drive torque's lines with respect to the parameters, rad.
        """
        return np.asarray(1j * turning[:, :, None] * self.coherent[None, :, :])

    def draw(self, drive: ComplexArray, turned: FloatArray, rng: np.random.Generator) -> ComplexArray:
        """Return draws of drive torque and components together, (k, n, m) rad.

        Parameters
        ----------
        drive : (k, n, m) complex
            Draws of the line of sight due to the drive torque, rad.
        turned : (k, n)
            Phase error of the drive torque in each draw, rad; the components follow it.
        rng : Generator
        """
        k, (n, s) = len(drive), self.lines.shape
        errors = np.zeros((k, n, s), dtype=np.complex128)
        for line, order in enumerate(self.at):
            if order >= 0:
                errors[:, line] = _complex_gaussian(self.here.covariance[order], k, rng)
        turn = turned + rng.normal(size=(k, n)) * _rows_or_zero(self.here.turn[:, None], self.at)[:, 0]
        counts = np.abs(self.lines) > 0.0
        lines = (self.lines + np.where(counts, errors * self.phase[:, None], 0.0)) * np.exp(1j * turn)[:, :, None]
        coherent = np.einsum("nms,kns->knm", self.transfer, lines)
        amplitudes = np.where(self.bounds > 0.0, np.abs(self.bounds + errors), 0.0)
        return _with_bound(drive + coherent, np.einsum("nms,kns->knm", np.abs(self.transfer), amplitudes))


def side_response(state: SteadyState, source: SideSource, here: SideHere, highest_hz: float) -> SideResponse:
    """Return the components at the lines of a steady torque, up to a frequency."""
    orders = list(TRACKED)
    at = np.array([orders.index(q) if q in orders else -1 for q in state.step_orders.tolist()], dtype=np.int64)
    size = np.abs(state.lines)
    # The phase of a line within its numerical error is arbitrary: components there count by magnitude.
    phase = np.where(size > state.error, state.lines / np.where(size > 0.0, size, 1.0), 0.0)
    return SideResponse(here, at, phase, source.transfer(state.frequency_hz), _alone(state, source, here, highest_hz))


def _alone(state: SteadyState, source: SideSource, here: SideHere, highest_hz: float) -> Incoherent | None:
    """Return the components at orders without a modelled line, their magnitudes added."""
    size, frequency = np.abs(here.lines) + here.bounds, abs(state.rate) * np.array(TRACKED)
    kept = ~np.isin(TRACKED, state.step_orders) & size.any(axis=1) & (frequency <= highest_hz)
    if not kept.any():
        return None
    amplitude = np.einsum("kms,ks->km", np.abs(source.transfer(frequency[kept])), size[kept])
    return Incoherent(frequency[kept], 0.5 * amplitude**2)


def _rows_or_zero(values: NDArray[Any], at: IntArray) -> NDArray[Any]:
    """Return rows by position, zero for a position of -1."""
    known = (at >= 0).reshape(-1, *[1] * (values.ndim - 1))
    return np.where(known, values[at], 0.0)


def _with_bound(total: ComplexArray, bound: FloatArray) -> ComplexArray:
    """Return phasors lengthened by a magnitude."""
    size = np.abs(total)
    # A total of zero has no direction; the bound then takes the real one.
    return np.asarray(total + bound * np.where(size > 0.0, total / np.where(size > 0.0, size, 1.0), 1.0))


def _complex_gaussian(covariance: ComplexArray, count: int, rng: np.random.Generator) -> ComplexArray:
    """Return draws of circular complex Gaussians, (count, s), with covariance E[e e^H]."""
    values, vectors = np.linalg.eigh(covariance)
    unit = rng.normal(size=(2, count, values.size)) / np.sqrt(2.0)
    return np.asarray((unit[0] + 1j * unit[1]) * np.sqrt(np.maximum(values, 0.0)) @ vectors.T)
