"""Line of sight as the structure's response to the lines of a steady torque."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol, TypeAlias

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.budgets.discrepancy import Discrepancy
from mechid.budgets.indices import Index
from mechid.budgets.pointing_error import Incoherent, PointingError, Random, Source
from mechid.budgets.residual_source import EDGES_HZ, ResidualHere
from mechid.budgets.settings import LEVEL
from mechid.budgets.side_response import SideResponse
from mechid.budgets.steady_state import SteadyState
from mechid.signal.power import cumulative_rms, power_density
from mechid.structure import Structure

ABSOLUTE = Index("APE")
"""Index that keeps all of an error, so that its mean square is the total."""

ErrorFunction: TypeAlias = Callable[[FloatArray], PointingError]
"""Pointing error as a function of the parameters' deviations: those of the state's gradient, or none."""


class LineOfSight(Protocol):
    """Response of the line of sight in one mode, by lines or over time."""

    @property
    def axes(self) -> tuple[str, ...]:
        """The lines of sight, (m,)."""

    @property
    def columns(self) -> int:
        """Number of parameters with a derivative."""

    def error_under(self, index: Index) -> ErrorFunction:
        """Return the error under an index, as a function of the parameters' deviations (`columns`,)."""

    def draw_discrepancy(self, discrepancy: Discrepancy, rng: np.random.Generator) -> LineOfSight:
        """Return a draw of the response with the model discrepancy applied."""

    def with_residual(self, rng: np.random.Generator) -> LineOfSight:
        """Return a draw with the unmodelled lines added at random phases."""

    def without_residual(self) -> LineOfSight:
        """Return the response of the model alone."""

    def with_side(self, rng: np.random.Generator) -> LineOfSight:
        """Return a draw with the other components off by their errors."""

    def rms(self) -> FloatArray:
        """Return the RMS along each line of sight, (m,) rad."""


@dataclass(frozen=True, eq=False)
class Response:
    """Line of sight at one steady rate.

    Attributes
    ----------
    axes : tuple of str, (m,)
        Lines of sight.
    state : SteadyState
    transfer : (n, m) complex
        Line of sight per torque at each line, rad/(N m); zero where the structure's response is unknown.
    phasors : (n, m) complex
        rad, the sum over all components that fly.
    uncovered : float
        Share of the torque lines' RMS at frequencies that the structure does not cover.
    random : Random or None
        Non-repeating part; None if it is small.
    residual : ResidualHere or None
        Unmodelled torque; None if unknown.
    lacking : Incoherent or None
        Line of sight due to the unmodelled torque; None if there is none.
    side : SideResponse or None
        Other components measured on the bench; None if none of them flies.
    """

    axes: tuple[str, ...]
    state: SteadyState
    transfer: ComplexArray
    phasors: ComplexArray
    uncovered: float
    random: Random | None
    residual: ResidualHere | None = None
    lacking: Incoherent | None = None
    side: SideResponse | None = None

    @property
    def columns(self) -> int:
        """Number of parameters with a derivative."""
        return int(self.state.gradient.shape[1])

    @property
    def slopes(self) -> ComplexArray:
        """Derivative of the phasors with respect to each parameter, (p, n, m)."""
        own = np.asarray(self.state.gradient.T[:, :, None] * self.transfer[None, :, :], dtype=np.complex128)
        return own if self.side is None else own + self.side.slopes(self.state.phase_changes(self.state.gradient.T))

    @property
    def drive(self) -> ComplexArray:
        """Line of sight due to the drive torque alone, (n, m) rad."""
        return self.transfer * self.state.lines[:, None]

    @property
    def randoms(self) -> tuple[Random | Incoherent, ...]:
        """Random parts: the non-repeating part, the unmodelled torque, and components at other orders."""
        alone = self.side.alone if self.side is not None else None
        return tuple(part for part in (self.random, self.lacking, alone) if part is not None)

    def total_square(self, index: Index) -> FloatArray:
        """Return the mean square under an index of the lines and all random parts, (m,) rad^2."""
        lines = index.weight(self.state.frequency_hz) @ (0.5 * np.abs(self.phasors) ** 2)
        return np.asarray(lines + sum(part.variance(index) for part in self.randoms), dtype=np.float64)

    def of_drive(self) -> Response:
        """Return the response to the drive torque alone; itself if nothing else flies."""
        return self if self.side is None else replace(self, phasors=self.drive, side=None)

    def error_under(self, index: Index) -> ErrorFunction:
        """Return the error as a function of the parameters' deviations, (p,)."""
        del index  # a Source applies the index itself
        size = np.asarray(np.abs(self.phasors).max(axis=1))
        # Each line costs an exponential per instant; lines this small do not change a level.
        loud = np.asarray(size > LEVEL.quiet * size.max(initial=0.0))
        phasors, slopes, orders = self.phasors[loud], self.slopes[:, loud], self.state.orders[loud]

        def error_at(by: FloatArray) -> PointingError:
            at = phasors + np.tensordot(by, slopes, axes=1) if by.any() else phasors
            lines = Source("mechanism", self.state.fundamental_hz, orders, at)
            return PointingError(np.zeros(at.shape[1]), (lines,), self.randoms)

        return error_at

    def draw_discrepancy(self, discrepancy: Discrepancy, rng: np.random.Generator) -> Response:
        """Return a draw with the amplitude and phase of each line off by the model discrepancy."""
        share = discrepancy.of_lines(self.state.step_orders)
        amplitude, phase = rng.normal(size=(2, share.size)) * share
        off = ((1.0 + amplitude) * np.exp(1j * phase))[:, None]
        return replace(self, phasors=self.phasors * off if self.side is None else self.side.add_to(self.drive * off))

    def with_residual(self, rng: np.random.Generator) -> Response:
        """Return a draw with the unmodelled torque added at each line, at a random phase."""
        return replace(self, phasors=self.phasors + self.residual_lines(1, rng)[0][:, None] * self.transfer)

    def without_residual(self) -> Response:
        """Return the response of the model alone."""
        return replace(self, residual=None, lacking=None)

    def with_side(self, rng: np.random.Generator) -> Response:
        """Return a draw with each component off by its error."""
        if self.side is None:
            return self
        drawn = self.side.draw(self.drive[None], np.zeros((1, self.state.lines.size)), rng)
        return replace(self, phasors=drawn[0])

    def residual_lines(self, count: int, rng: np.random.Generator) -> ComplexArray:
        """Return draws of the unmodelled torque at each line, (count, n) N m."""
        if self.residual is None:
            return np.zeros((count, self.state.lines.size), dtype=np.complex128)
        return self.residual.draws(self.residual_limits(), count, rng)

    def residual_limits(self) -> FloatArray:
        """Return the limit of the unmodelled torque at each line, (n,) N m, including torque that noise may hide."""
        here = self.residual
        if here is None:
            return np.zeros(self.state.lines.size)
        return here.at_orders(self.state.step_orders, LEVEL.line_spacing, here.limit)

    def rms(self) -> FloatArray:
        """Return the RMS of the lines along each line of sight, (m,) rad."""
        return np.asarray(np.sqrt(0.5 * np.sum(np.abs(self.phasors) ** 2, axis=0)), dtype=np.float64)

    def whole_rms(self) -> FloatArray:
        """Return the RMS of the lines and the non-repeating part along each line of sight, (m,) rad.

        The unmodelled torque is excluded: it is the same for all motions at a rate.
        """
        if self.random is None:
            return self.rms()
        beside = [cumulative_rms(self.random.frequency_hz, column)[-1] for column in self.random.density.T]
        return np.hypot(self.rms(), np.array(beside, dtype=np.float64))

    def total_rms(self) -> FloatArray:
        """Return the RMS of the lines, the non-repeating part and the unmodelled torque together, (m,) rad."""
        return np.sqrt(self.total_square(ABSOLUTE))

    def residual_rms(self) -> FloatArray:
        """Return the RMS due to the unmodelled torque along each line of sight, (m,) rad."""
        if self.lacking is None:
            return np.zeros(len(self.axes))
        return np.asarray(np.sqrt(self.lacking.power.sum(axis=0)), dtype=np.float64)


def respond(
    state: SteadyState,
    structure: Structure,
    residual: ResidualHere | None = None,
    highest_hz: float = np.inf,
    side: SideResponse | None = None,
) -> Response:
    """Return the line of sight due to a steady torque, unmodelled torque up to a frequency included.

    Other components are added if any fly.
    """
    transfer = structure.to_line_of_sight(state.frequency_hz)
    known = np.asarray(np.isfinite(transfer).all(axis=1))
    transfer = np.where(known[:, None], transfer, 0.0)
    drive = transfer * state.lines[:, None]
    phasors = drive if side is None else side.add_to(drive)
    power = np.abs(state.lines) ** 2
    uncovered = float(np.sqrt(power[~known].sum() / power.sum())) if power.sum() > 0.0 else 0.0
    return Response(
        structure.line_of_sight,
        state,
        transfer,
        phasors,
        uncovered,
        _random_part(state, structure),
        residual,
        _unmodelled_part(residual, structure, highest_hz) if residual is not None and residual.any else None,
        side,
    )


def torque_response(state: SteadyState, residual: ResidualHere | None) -> Response:
    """Return the torque itself, as a line of sight with a transfer function of 1."""
    ones = np.ones((state.lines.size, 1), dtype=np.complex128)
    return Response(("torque",), state, ones, state.lines[:, None], 0.0, None, residual)


def _unmodelled_part(residual: ResidualHere, structure: Structure, highest_hz: float) -> Incoherent:
    """Return the line of sight due to unmodelled torque: its lines, and its density in narrow slices."""
    kept = (residual.amplitude > 0.0) & (residual.frequency_hz <= highest_hz)
    lines_hz, square = residual.frequency_hz[kept], 0.5 * residual.amplitude[kept] ** 2
    edges = np.geomspace(EDGES_HZ[0], min(highest_hz, EDGES_HZ[-1]), LEVEL.slices)
    # Slices far narrower than a third octave, so that a resonance is resolved within a band.
    between_hz = np.sqrt(edges[1:] * edges[:-1])
    density = residual.density[np.digitize(between_hz, EDGES_HZ[1:-1])]
    heard = density > 0.0
    frequency = np.concatenate([lines_hz, between_hz[heard]])
    power = np.concatenate([square, (density * np.diff(edges))[heard]])
    transfer = np.nan_to_num(np.abs(structure.to_line_of_sight(frequency)) ** 2)
    return Incoherent(frequency, transfer * power[:, None])


def _random_part(state: SteadyState, structure: Structure) -> Random | None:
    if state.unsteady < LEVEL.not_steady:
        return None
    frequency, torque = power_density(state.residual, state.sample_rate_hz)
    transfer = np.nan_to_num(np.abs(structure.to_line_of_sight(frequency)) ** 2)
    return Random(frequency, transfer * torque[:, None])
