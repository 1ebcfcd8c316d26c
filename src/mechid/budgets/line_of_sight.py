"""From the lines of a steady torque to the line of sight."""

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
"""All of an error counts: its mean square is the whole."""

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

    def with_residual(self, rng: np.random.Generator) -> LineOfSight:
        """Return a draw of it with the lines that the model lacks on top of its own, at phases of their own."""

    def without_residual(self) -> LineOfSight:
        """Return what the model alone makes of it."""

    def with_side(self, rng: np.random.Generator) -> LineOfSight:
        """Return a draw of it with the components beside the drive torque off by their errors."""

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
        rad, of all components where several fly.
    uncovered : float
        Share of the torque lines' RMS at frequencies that the structure does not cover.
    random : Random or None
        Of what does not repeat; None where it is small.
    residual : ResidualHere or None
        What the model lacks of the torque; None where nothing is known of it.
    lacking : Incoherent or None
        What that makes of the line of sight; None where it is nothing.
    side : SideResponse or None
        What was measured beside the drive torque; None where nothing of it flies.
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
        """Number of parameters to which the derivative is known."""
        return int(self.state.gradient.shape[1])

    @property
    def slopes(self) -> ComplexArray:
        """Derivative of the phasors to each parameter, (p, n, m)."""
        own = np.asarray(self.state.gradient.T[:, :, None] * self.transfer[None, :, :], dtype=np.complex128)
        return own if self.side is None else own + self.side.slopes(self.state.turned(self.state.gradient.T))

    @property
    def drive(self) -> ComplexArray:
        """What the drive torque alone makes of the line of sight, (n, m) rad."""
        return self.transfer * self.state.lines[:, None]

    @property
    def randoms(self) -> tuple[Random | Incoherent, ...]:
        """What is beside the lines: what does not repeat, what the model lacks, and components at other orders."""
        alone = self.side.alone if self.side is not None else None
        return tuple(part for part in (self.random, self.lacking, alone) if part is not None)

    def total_square(self, index: Index) -> FloatArray:
        """Return the mean square under an index of the lines and of all beside them, (m,) rad^2."""
        lines = index.weight(self.state.frequency_hz) @ (0.5 * np.abs(self.phasors) ** 2)
        return np.asarray(lines + sum(part.variance(index) for part in self.randoms), dtype=np.float64)

    def of_drive(self) -> Response:
        """Return what the drive torque alone makes of it; itself where nothing else flies."""
        return self if self.side is None else replace(self, phasors=self.drive, side=None)

    def under(self, index: Index) -> Moved:
        """Return the error as a function of the parameters' deviations, (p,)."""
        del index  # the lines' weights are its own
        size = np.asarray(np.abs(self.phasors).max(axis=1))
        loud = np.asarray(size > LEVEL.quiet * size.max(initial=0.0))
        phasors, slopes, orders = self.phasors[loud], self.slopes[:, loud], self.state.orders[loud]

        def moved(by: FloatArray) -> PointingError:
            at = phasors + np.tensordot(by, slopes, axes=1) if by.any() else phasors
            lines = Source("mechanism", self.state.fundamental_hz, orders, at)
            return PointingError(np.zeros(at.shape[1]), (lines,), self.randoms)

        return moved

    def missed(self, discrepancy: Discrepancy, rng: np.random.Generator) -> Response:
        """Return a draw with each line's amplitude and phase off by what the model misses of it."""
        share = discrepancy.of_lines(self.state.step_orders)
        amplitude, phase = rng.normal(size=(2, share.size)) * share
        off = ((1.0 + amplitude) * np.exp(1j * phase))[:, None]
        return replace(self, phasors=self.phasors * off if self.side is None else self.side.added(self.drive * off))

    def with_residual(self, rng: np.random.Generator) -> Response:
        """Return a draw with what the model lacks at each of its lines added, at a phase of its own."""
        return replace(self, phasors=self.phasors + self.lacking_lines(1, rng)[0][:, None] * self.transfer)

    def without_residual(self) -> Response:
        """Return what the model alone makes of it."""
        return replace(self, residual=None, lacking=None)

    def with_side(self, rng: np.random.Generator) -> Response:
        """Return a draw with each component off by its error."""
        if self.side is None:
            return self
        drawn = self.side.drawn(self.drive[None], np.zeros((1, self.state.lines.size)), rng)
        return replace(self, phasors=drawn[0])

    def lacking_lines(self, count: int, rng: np.random.Generator) -> ComplexArray:
        """Return draws of what the model lacks at each of its lines, (count, n) N m."""
        if self.residual is None:
            return np.zeros((count, self.state.lines.size), dtype=np.complex128)
        return self.residual.draws(self.lacking_limits(), count, rng)

    def lacking_limits(self) -> FloatArray:
        """Return how large what the model lacks at each of its lines may be, (n,) N m, with what noise may hide."""
        here = self.residual
        if here is None:
            return np.zeros(self.state.lines.size)
        return here.at_orders(self.state.step_orders, LEVEL.line_spacing, here.limit)

    def rms(self) -> FloatArray:
        """Return the RMS of the lines along each line of sight, (m,) rad."""
        return np.asarray(np.sqrt(0.5 * np.sum(np.abs(self.phasors) ** 2, axis=0)), dtype=np.float64)

    def whole_rms(self) -> FloatArray:
        """Return the RMS of the lines and of what does not repeat along each line of sight, (m,) rad.

        What the model lacks is not part of it: it is the same of all motions at a rate.
        """
        if self.random is None:
            return self.rms()
        beside = [cumulative_rms(self.random.frequency_hz, column)[-1] for column in self.random.density.T]
        return np.hypot(self.rms(), np.array(beside, dtype=np.float64))

    def total_rms(self) -> FloatArray:
        """Return the RMS of the lines, of what does not repeat and of what the model lacks together, (m,) rad."""
        return np.sqrt(self.total_square(ABSOLUTE))

    def lacking_rms(self) -> FloatArray:
        """Return the RMS of what the model lacks along each line of sight, (m,) rad."""
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
    """Return the line of sight that a steady torque makes, with what the model lacks of it up to a frequency.

    With what was measured beside the torque, where that flies.
    """
    transfer = structure.to_line_of_sight(state.frequency_hz)
    known = np.asarray(np.isfinite(transfer).all(axis=1))
    transfer = np.where(known[:, None], transfer, 0.0)
    drive = transfer * state.lines[:, None]
    phasors = drive if side is None else side.added(drive)
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
        _lacking(residual, structure, highest_hz) if residual is not None and residual.any else None,
        side,
    )


def _lacking(residual: ResidualHere, structure: Structure, highest_hz: float) -> Incoherent:
    """Return what the model lacks as the line of sight has it: its lines, and its density in narrow slices."""
    kept = (residual.amplitude > 0.0) & (residual.frequency_hz <= highest_hz)
    lines_hz, square = residual.frequency_hz[kept], 0.5 * residual.amplitude[kept] ** 2
    edges = np.geomspace(EDGES_HZ[0], min(highest_hz, EDGES_HZ[-1]), LEVEL.slices)
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
