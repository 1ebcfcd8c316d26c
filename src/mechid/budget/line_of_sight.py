"""From the lines of a steady torque to the line of sight."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mechid.budget.discrepancy import Discrepancy
from mechid.budget.indices import Index
from mechid.budget.pointing_error import PointingError, Random, Source
from mechid.budget.steady_state import SteadyState
from mechid.signal.power import cumulative_rms, power_density
from mechid.structure import Structure

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

QUIET = 1e-4
"""A line below this share of the largest is left out of levels; together they are far below the bands."""
NOT_STEADY = 1e-3
"""Share of the RMS that does not repeat from which on it counts as a random part."""

Moved: TypeAlias = Callable[[FloatArray], PointingError]
"""From deviations of the parameters, those of the state's gradient or none of them, to the pointing error."""


class LineOfSight(Protocol):
    """What a mode makes of the line of sight, by lines or over time."""

    @property
    def axes(self) -> tuple[str, ...]:
        """The lines of sight, (m,)."""

    @property
    def columns(self) -> int:
        """Number of parameters to which the derivative is known."""

    def under(self, index: Index) -> Moved:
        """Return the error under an index, as a function of the parameters' deviations (`columns`,)."""

    def missed(self, discrepancy: Discrepancy, rng: np.random.Generator) -> LineOfSight:
        """Return a draw of what it may really be, by what the model misses."""

    def rms(self) -> FloatArray:
        """Return the RMS along each line of sight, (m,) rad."""


@dataclass(frozen=True, eq=False)
class Response:
    """The line of sight at one steady rate.

    Attributes
    ----------
    axes : tuple of str, (m,)
        The lines of sight.
    state : SteadyState
    transfer : (n, m) complex
        Line of sight per torque at each line, rad/(N m); zero where the structure is not known.
    phasors : (n, m) complex
        rad.
    uncovered : float
        Share of the torque lines' RMS at frequencies that the structure does not cover.
    random : Random or None
        Of what does not repeat; None where it is small.
    """

    axes: tuple[str, ...]
    state: SteadyState
    transfer: ComplexArray
    phasors: ComplexArray
    uncovered: float
    random: Random | None

    @property
    def columns(self) -> int:
        """Number of parameters to which the derivative is known."""
        return int(self.state.gradient.shape[1])

    @property
    def slopes(self) -> ComplexArray:
        """Derivative of the phasors to each parameter, (p, n, m)."""
        return np.asarray(self.state.gradient.T[:, :, None] * self.transfer[None, :, :], dtype=np.complex128)

    def under(self, index: Index) -> Moved:
        """Return the error as a function of the parameters' deviations, (p,)."""
        del index  # the lines' weights are its own
        size = np.asarray(np.abs(self.phasors).max(axis=1))
        loud = np.asarray(size > QUIET * size.max(initial=0.0))
        phasors, slopes, orders = self.phasors[loud], self.slopes[:, loud], self.state.orders[loud]
        randoms = () if self.random is None else (self.random,)

        def moved(by: FloatArray) -> PointingError:
            at = phasors + np.tensordot(by, slopes, axes=1) if by.any() else phasors
            lines = Source("mechanism", self.state.fundamental_hz, orders, at)
            return PointingError(np.zeros(at.shape[1]), (lines,), randoms)

        return moved

    def missed(self, discrepancy: Discrepancy, rng: np.random.Generator) -> Response:
        """Return a draw with each line's amplitude and phase off by what the model misses of it."""
        share = discrepancy.of_lines(self.state.step_orders)
        amplitude, phase = rng.normal(size=(2, share.size)) * share
        return replace(self, phasors=self.phasors * ((1.0 + amplitude) * np.exp(1j * phase))[:, None])

    def rms(self) -> FloatArray:
        """Return the RMS of the lines along each line of sight, (m,) rad."""
        return np.asarray(np.sqrt(0.5 * np.sum(np.abs(self.phasors) ** 2, axis=0)), dtype=np.float64)

    def whole_rms(self) -> FloatArray:
        """Return the RMS of the lines and of what does not repeat along each line of sight, (m,) rad."""
        if self.random is None:
            return self.rms()
        beside = [cumulative_rms(self.random.frequency_hz, column)[-1] for column in self.random.density.T]
        return np.hypot(self.rms(), np.array(beside, dtype=np.float64))


def respond(state: SteadyState, structure: Structure) -> Response:
    """Return the line of sight that a steady torque makes."""
    transfer = structure.to_line_of_sight(state.frequency_hz)
    known = np.asarray(np.isfinite(transfer).all(axis=1))
    transfer = np.where(known[:, None], transfer, 0.0)
    phasors = transfer * state.lines[:, None]
    power = np.abs(state.lines) ** 2
    uncovered = float(np.sqrt(power[~known].sum() / power.sum())) if power.sum() > 0.0 else 0.0
    return Response(structure.line_of_sight, state, transfer, phasors, uncovered, _random_part(state, structure))


def _random_part(state: SteadyState, structure: Structure) -> Random | None:
    if state.unsteady < NOT_STEADY:
        return None
    frequency, torque = power_density(state.residual, state.sample_rate_hz)
    transfer = np.nan_to_num(np.abs(structure.to_line_of_sight(frequency)) ** 2)
    return Random(frequency, transfer * torque[:, None])
