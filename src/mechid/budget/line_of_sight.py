"""From the torque's lines to the line of sight, its levels, their bands, and whose uncertainty makes them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechid.budget.flying_mechanism import Estimate
from mechid.budget.levels import CONE, ensemble_level, level
from mechid.budget.pointing_error import PointingError, Source
from mechid.budget.requirement import Requirement, Standing
from mechid.budget.shares import Band, drawn
from mechid.budget.steady_state import SteadyState
from mechid.budget.summation import Contribution, total
from mechid.signal.power import power_density
from mechid.structure import Structure

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

MEMBERS = 100
"""Draws of the ensemble that [flight.spread] describes."""
QUIET = 1e-4
"""A line below this share of the largest is left out of levels; together they are far below the bands."""
NOT_STEADY = 1e-3
"""Share of the RMS that does not repeat from which on it counts as a random part."""
DISCREPANCY = "model discrepancy"


@dataclass(frozen=True, eq=False)
class Response:
    """The line of sight at one rate.

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
    frequency_hz, density : (k,), (k, m)
        Of what does not repeat, rad^2/Hz; None where it is small.
    """

    axes: tuple[str, ...]
    state: SteadyState
    transfer: ComplexArray
    phasors: ComplexArray
    uncovered: float
    frequency_hz: FloatArray | None
    density: FloatArray | None

    def error(self, phasors: ComplexArray | None = None) -> PointingError:
        """Return the pointing error, of other phasors (n, m) where they are given."""
        phasors = self.phasors if phasors is None else phasors
        size = np.asarray(np.abs(self.phasors).max(axis=1))
        loud = np.asarray(size > QUIET * size.max(initial=0.0))
        source = Source("mechanism", 0.5 * self.state.rate, self.state.orders[loud], phasors[loud])
        return PointingError(np.zeros(phasors.shape[1]), (source,), self.frequency_hz, self.density)

    def rms(self) -> FloatArray:
        """Return the RMS of the lines along each line of sight, (m,) rad."""
        return np.asarray(np.sqrt(0.5 * np.sum(np.abs(self.phasors) ** 2, axis=0)), dtype=np.float64)


def respond(state: SteadyState, structure: Structure) -> Response:
    """Return the line of sight that a steady torque makes."""
    transfer = structure.to_line_of_sight(state.frequency_hz)
    known = np.asarray(np.isfinite(transfer).all(axis=1))
    transfer = np.where(known[:, None], transfer, 0.0)
    phasors = transfer * state.lines[:, None]
    power = np.abs(state.lines) ** 2
    uncovered = float(np.sqrt(power[~known].sum() / power.sum())) if power.sum() > 0.0 else 0.0
    frequency, density = _random_part(state, structure)
    return Response(structure.line_of_sight, state, transfer, phasors, uncovered, frequency, density)


def _random_part(state: SteadyState, structure: Structure) -> tuple[FloatArray | None, FloatArray | None]:
    if state.unsteady < NOT_STEADY:
        return None, None
    frequency, torque = power_density(state.residual, state.sample_rate_hz)
    transfer = np.nan_to_num(np.abs(structure.to_line_of_sight(frequency)) ** 2)
    return frequency, transfer * torque[:, None]


def standing(
    requirement: Requirement, mode: str, response: Response, estimate: Estimate, spread: FloatArray, members: FloatArray
) -> Standing:
    """Return how a response stands against a requirement.

    Parameters
    ----------
    spread : (s,)
        Standard deviations of the ensemble, those of the last s columns of the state's gradient.
    members : (k, s)
        Draws of the ensemble, in those standard deviations; none where there is no spread.
    """
    axis, index, confidence = _axis(requirement, response), requirement.index, requirement.confidence
    nominal = nominal_level(requirement, response)
    worst = nominal
    knowing, varying = _directions(response, len(estimate.names))
    if members.size:
        errors = [response.error(response.phasors + _moved(varying, row * spread)) for row in members]
        worst = ensemble_level(errors, index, confidence, axis, requirement.interpretation)
    elif requirement.interpretation == "ensemble":
        worst = ensemble_level([response.error()], index, confidence, axis, "ensemble")
    scale = worst / nominal if nominal > 0.0 else 1.0

    def moved(by: FloatArray) -> float:
        return scale * level(response.error(response.phasors + _moved(knowing, by)), index, confidence, axis)

    band = _with_discrepancy(drawn(worst, moved, estimate.covariance, estimate.names), estimate)
    return Standing(requirement=requirement, mode=mode, level=band, ecss_rad=_by_ecss(requirement, response, axis))


def nominal_level(requirement: Requirement, response: Response) -> float:
    """Return the level in rad over time of the nominal member."""
    return level(response.error(), requirement.index, requirement.confidence, _axis(requirement, response))


def _axis(requirement: Requirement, response: Response) -> int | None:
    return None if requirement.axis == CONE else response.axes.index(requirement.axis)


def ensemble_draws(count: int, seed: int) -> FloatArray:
    """Return seeded draws (MEMBERS, count) in standard deviations, the nominal member first."""
    if not count:
        return np.zeros((0, 0))
    draws = np.random.default_rng(seed).normal(size=(MEMBERS, count))
    draws[0] = 0.0
    return draws


def _directions(response: Response, estimated: int) -> tuple[ComplexArray, ComplexArray]:
    """Return the phasors' derivatives to the estimated parameters and to those that spread, (p, n, m) each."""
    slopes = response.state.gradient.T[:, :, None] * response.transfer[None, :, :]
    return slopes[:estimated], slopes[estimated:]


def _moved(slopes: ComplexArray, by: FloatArray) -> ComplexArray:
    return np.asarray(np.tensordot(by, slopes, axes=1), dtype=np.complex128)


def _with_discrepancy(band: Band, estimate: Estimate) -> Band:
    """Return the band with the share of the torque that the model misses as one more, independent part."""
    own = estimate.discrepancy * band.value
    variance = band.sigma**2 + own**2
    if variance <= 0.0:
        return band
    shares = {name: share * band.sigma**2 / variance for name, share in band.shares.items()}
    return Band(band.value, float(np.sqrt(variance)), {**shares, DISCREPANCY: own**2 / variance})


def _by_ecss(requirement: Requirement, response: Response, axis: int | None) -> float:
    """Return the level by the standard's summation, each line a periodic error of what the index keeps of it."""
    error, n = response.error(), response.phasors.shape[1]
    kept = np.sqrt(requirement.index.weight(error.sources[0].frequency_hz))
    amplitude = kept[:, None] * np.abs(error.sources[0].phasors)
    sigma = error.sigma(requirement.index)
    values = [_sum(amplitude[:, k], float(sigma[k]), requirement) for k in ([axis] if axis is not None else range(n))]
    return float(np.hypot.reduce(np.array(values)))


def _sum(amplitudes: FloatArray, sigma: float, requirement: Requirement) -> float:
    parts = [Contribution(name=str(k), kind="periodic", size=float(a)) for k, a in enumerate(amplitudes)]
    noise = Contribution(name="random", kind="random", size=sigma)
    return total([*parts, noise], requirement.interpretation, requirement.confidence)
