"""Line of sight over the steady rates of a mode: RMS and levels with 95 % bands."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.budgets.flying_mechanism import Estimate
from mechid.budgets.indices import Index
from mechid.budgets.line_of_sight import ABSOLUTE, Response, torque_response
from mechid.budgets.other_errors import OtherError
from mechid.budgets.requirement import Requirement
from mechid.budgets.residual_source import ResidualHere
from mechid.budgets.settings import LEVEL
from mechid.budgets.shares import deviations
from mechid.budgets.standing import axis_of, nominal_level, others_square


@dataclass(frozen=True, eq=False)
class LevelCurve:
    """Level of a requirement over the rate.

    Attributes
    ----------
    level : (r,)
        Over time, for the nominal unit, rad.
    band : (r, 2)
        Its 95 % interval.
    at : tuple of Response, (r,)
        At each rate the steady state with the largest level.
    """

    level: FloatArray
    band: FloatArray
    at: tuple[Response, ...]


def sampled_phasors(
    response: Response,
    estimate: Estimate,
    seed: int,
    lacking: FloatArray | None = None,
    count: int = LEVEL.samples,
) -> ComplexArray:
    """Return phasors for parameter samples drawn from the covariance, model discrepancy included, (k, n, m) rad.

    Parameters
    ----------
    response : Response
        Its other components are drawn with their errors.
    estimate : Estimate
    seed : int
    lacking : (n,) or None
        Amplitude of the unmodelled torque at each line, N m, added at random phases; None adds nothing.
    count : int
        Number of samples k.
    """
    rng, alone = np.random.default_rng(seed), response.of_drive()
    by = deviations(estimate.covariance, count, rng)
    moved = alone.phasors + np.tensordot(by, alone.slopes[: len(estimate.names)], axes=1)
    share = estimate.discrepancy.of_lines(response.state.step_orders)
    amplitude, phase = rng.normal(size=(2, count, share.size)) * share
    drive = np.asarray(moved * ((1.0 + amplitude) * np.exp(1j * phase))[:, :, None], dtype=np.complex128)
    if lacking is not None and response.residual is not None:
        drive = drive + response.residual.draws(lacking, count, rng)[:, :, None] * response.transfer
    if response.side is None:
        return drive
    turned = phase + response.state.phase_changes(by @ response.state.gradient[:, : len(estimate.names)].T)
    return response.side.draw(drive, turned, rng)


def rms_bands(responses: Sequence[Response], estimate: Estimate, seed: int) -> FloatArray:
    """Return the 95 % interval of the RMS of the lines at each rate along each line of sight, (r, m, 2) rad."""
    out = []
    for response in responses:
        square = 0.5 * np.sum(np.abs(sampled_phasors(response, estimate, seed)) ** 2, axis=1)
        out.append(np.quantile(np.sqrt(square), LEVEL.limits95, axis=0).T)
    return np.array(out)


def total_bands(responses: Sequence[Response], estimate: Estimate, seed: int) -> FloatArray:
    """Return the 95 % interval of `Response.total_rms` at each rate along each line of sight, (r, m, 2) rad."""
    return np.array([np.sqrt(_total_limits(response, estimate, ABSOLUTE, seed)).T for response in responses])


def _total_limits(
    response: Response,
    estimate: Estimate,
    index: Index,
    seed: int,
    of_axes: Callable[[FloatArray], FloatArray] = np.asarray,
) -> FloatArray:
    """Return the 95 % limits of the mean square of `Response.total_square`, (2, ...) rad^2.

    The upper limit also includes unmodelled lines that noise may hide, which are not part of the value.

    Parameters
    ----------
    response : Response
    estimate : Estimate
    index : Index
    seed : int
    of_axes : callable
        Reduces mean squares along each line of sight, (k, m), to the quantity needed, (k, ...).
    """
    ends = []
    for hidden, limit in zip((False, True), LEVEL.limits95, strict=True):
        squares = of_axes(_total_squares(response, estimate, index, seed, hidden=hidden))
        ends.append(np.quantile(squares, limit, axis=0))
    return np.array(ends)


def _total_squares(response: Response, estimate: Estimate, index: Index, seed: int, *, hidden: bool) -> FloatArray:
    """Return samples of `Response.total_square`, (k, m) rad^2.

    Unmodelled torque adds to the lines at random phases. Elsewhere only its power is drawn, as a level that few rates
    determine. Torque `hidden` by noise may also add to the lines.
    """
    weight, here = index.weight(response.state.frequency_hz), response.residual
    heard = np.zeros(weight.size) if here is None else _tracked_sizes(here, response, here.amplitude)
    sizes = _tracked_sizes(here, response, here.limit) if here is not None and hidden else heard
    lines = 0.5 * np.abs(sampled_phasors(response, estimate, seed, sizes)) ** 2
    drawn = np.einsum("n,knm->km", weight, lines)
    at_lines = weight @ (0.5 * heard[:, None] ** 2 * np.abs(response.transfer) ** 2)
    beside = sum((part.variance(index) for part in response.randoms if part is not response.lacking), np.zeros(1))
    if here is None or response.lacking is None:
        return np.asarray(drawn + beside)
    # The part at the lines is in `drawn` already, coherently.
    rest = np.maximum(response.lacking.variance(index) - at_lines, 0.0)
    # A separate stream: the draws of the lines stay the same with and without unmodelled torque.
    scale = here.rates / np.random.default_rng((seed, 1)).gamma(here.rates, size=(LEVEL.samples, 1))
    return np.asarray(drawn + scale * rest + beside)


def _tracked_sizes(here: ResidualHere, response: Response, sizes: FloatArray) -> FloatArray:
    """Return the unmodelled torque at those lines that were tracked, (n,) N m; 0 at the others."""
    own = dict(zip(here.orders.tolist(), sizes.tolist(), strict=True))
    return np.array([own.get(order, 0.0) for order in response.state.step_orders.tolist()], dtype=np.float64)


def torque_samples(
    response: Response,
    estimate: Estimate,
    seed: int,
    lacking: FloatArray | None = None,
    count: int = LEVEL.samples,
) -> ComplexArray:
    """Return samples of the torque's lines as in `sampled_phasors`, (k, n) N m."""
    torque = torque_response(response.state, response.residual)
    return sampled_phasors(torque, estimate, seed, lacking, count)[:, :, 0]


def torque_bands(responses: Sequence[Response], estimate: Estimate, seed: int) -> list[FloatArray]:
    """Return the 95 % interval of each modelled torque line at each rate, amplitudes, (n, 2) N m each."""
    return [np.quantile(np.abs(torque_samples(r, estimate, seed)), LEVEL.limits95, axis=0).T for r in responses]


def level_curve(
    requirement: Requirement,
    states: Sequence[Sequence[Response]],
    estimate: Estimate,
    errors: Sequence[OtherError],
    seed: int,
) -> LevelCurve:
    """Return the level over the rate, at each rate of the worst steady state.

    The band assumes that the level changes in proportion to the RMS under the index, unmodelled torque and other errors
    included in both, over the same parameter samples.
    """
    levels, bands, worst = [], [], []
    for here in states:
        of_each = [nominal_level(requirement, [(1.0, response)], errors) for response in here]
        at = int(np.argmax(of_each))
        levels.append(of_each[at])
        worst.append(here[at])
        bands.append(_level_band(requirement, here[at], of_each[at], estimate, errors, seed))
    return LevelCurve(np.array(levels), np.array(bands), tuple(worst))


def two_way_curve(
    requirement: Requirement, one_way: LevelCurve, joined: Sequence[Response], errors: Sequence[OtherError]
) -> LevelCurve:
    """Return the two-way level over the rate, which decides where it was computed.

    Its band is the one-way band, scaled at each rate by the level of the nominal unit. `joined` are the two-way
    responses, (r,).
    """
    level = np.array([nominal_level(requirement, [(1.0, response)], errors) for response in joined])
    known = one_way.level > 0.0
    scale = np.divide(level, one_way.level, out=np.zeros_like(level), where=known)
    band = np.where(known[:, None], scale[:, None] * one_way.band, level[:, None])
    return LevelCurve(level, band, tuple(joined))


def deciding_curve(curve: LevelCurve, level: float, ends: tuple[float, float]) -> LevelCurve:
    """Return a curve scaled so that its largest level and the band there match those of the deciding margin.

    A margin includes the ensemble and the model discrepancy at the worst rate only; other rates are assumed to change
    in proportion. A requirement is therefore met if the band exceeds its limit at no rate.

    Parameters
    ----------
    curve : LevelCurve
        Of the deciding coupling, for the nominal unit.
    level : float
        rad.
    ends : (lower, upper)
        95 % interval of the level, rad.
    """
    k = int(curve.level.argmax())
    if curve.level[k] <= 0.0:
        return curve
    levels = curve.level * level / curve.level[k]
    low, high = (_scaled_end(curve.band[:, j], k, end, levels) for j, end in enumerate(ends))
    return LevelCurve(levels, np.column_stack([np.minimum(low, levels), np.maximum(high, levels)]), curve.at)


def _scaled_end(end: FloatArray, k: int, wanted: float, levels: FloatArray) -> FloatArray:
    """Return an end of a band scaled to a value at rate k; the levels if it is zero there."""
    return np.asarray(end * wanted / end[k] if end[k] > 0.0 else levels)


def _level_band(
    requirement: Requirement,
    response: Response,
    value: float,
    estimate: Estimate,
    errors: Sequence[OtherError],
    seed: int,
) -> FloatArray:
    index, axis = requirement.index, axis_of(requirement, response)
    axes = slice(None) if axis is None else slice(axis, axis + 1)
    rest = others_square(requirement, response, errors)
    here = float(response.total_square(index)[axes].sum()) + rest
    if here <= 0.0:
        return np.full(2, value)
    limits = _total_limits(response, estimate, index, seed, lambda squares: squares[:, axes].sum(axis=1))
    return np.asarray(value * np.sqrt((limits + rest) / here), dtype=np.float64)
