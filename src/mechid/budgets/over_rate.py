"""Line of sight over the steady rates of a mode: RMS and levels with their bands."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.budgets.flying_mechanism import Estimate
from mechid.budgets.indices import Index
from mechid.budgets.line_of_sight import ABSOLUTE, Response
from mechid.budgets.other_errors import OtherError
from mechid.budgets.requirement import Requirement
from mechid.budgets.residual_source import ResidualHere
from mechid.budgets.settings import LEVEL
from mechid.budgets.shares import deviations
from mechid.budgets.standing import axis_of, nominal_level, others_square


@dataclass(frozen=True, eq=False)
class LevelCurve:
    """A requirement's level over the rate.

    Attributes
    ----------
    level : (r,)
        Over time, of the nominal unit, rad.
    band : (r, 2)
        Its 95 % interval.
    at : tuple of Response, (r,)
        At each rate the steady state of the largest level.
    """

    level: FloatArray
    band: FloatArray
    at: tuple[Response, ...]


def sampled_phasors(
    response: Response, estimate: Estimate, seed: int, lacking: FloatArray | None = None
) -> ComplexArray:
    """Return the phasors of parameter samples drawn from the covariance, with what the model misses, (k, n, m) rad.

    Parameters
    ----------
    response : Response
        What was measured beside the torque is drawn with its errors.
    estimate : Estimate
    seed : int
    lacking : (n,) or None
        Amplitude of what the model lacks at each of its lines, N m, added at phases of their own. None leaves the
        model's lines alone.
    """
    rng, alone = np.random.default_rng(seed), response.of_drive()
    by = deviations(estimate.covariance, LEVEL.samples, rng)
    moved = alone.phasors + np.tensordot(by, alone.slopes[: len(estimate.names)], axes=1)
    share = estimate.discrepancy.of_lines(response.state.step_orders)
    amplitude, phase = rng.normal(size=(2, LEVEL.samples, share.size)) * share
    drive = np.asarray(moved * ((1.0 + amplitude) * np.exp(1j * phase))[:, :, None], dtype=np.complex128)
    if lacking is not None and response.residual is not None:
        drive = drive + response.residual.draws(lacking, LEVEL.samples, rng)[:, :, None] * response.transfer
    if response.side is None:
        return drive
    turned = phase + response.state.turned(by @ response.state.gradient[:, : len(estimate.names)].T)
    return response.side.drawn(drive, turned, rng)


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

    The upper one counts what noise may hide of the lines that the model lacks, too; that is no part of the value.

    Parameters
    ----------
    response : Response
    estimate : Estimate
    index : Index
    seed : int
    of_axes : callable
        From mean squares along each line of sight, (k, m), to what is wanted of them, (k, ...).
    """
    ends = []
    for hidden, limit in zip((False, True), LEVEL.limits95, strict=True):
        squares = of_axes(_total_squares(response, estimate, index, seed, hidden=hidden))
        ends.append(np.quantile(squares, limit, axis=0))
    return np.array(ends)


def _total_squares(response: Response, estimate: Estimate, index: Index, seed: int, *, hidden: bool) -> FloatArray:
    """Return samples of `Response.total_square`, (k, m) rad^2.

    What the model lacks adds to its lines at phases of their own; elsewhere its power alone is drawn, as that of a
    level that few rates tell. What is `hidden` by noise may add to the lines too.
    """
    weight, here = index.weight(response.state.frequency_hz), response.residual
    heard = np.zeros(weight.size) if here is None else _tracked(here, response, here.amplitude)
    sizes = _tracked(here, response, here.limit) if here is not None and hidden else heard
    lines = 0.5 * np.abs(sampled_phasors(response, estimate, seed, sizes)) ** 2
    drawn = np.einsum("n,knm->km", weight, lines)
    at_lines = weight @ (0.5 * heard[:, None] ** 2 * np.abs(response.transfer) ** 2)
    beside = sum((part.variance(index) for part in response.randoms if part is not response.lacking), np.zeros(1))
    if here is None or response.lacking is None:
        return np.asarray(drawn + beside)
    rest = np.maximum(response.lacking.variance(index) - at_lines, 0.0)
    scale = here.rates / np.random.default_rng((seed, 1)).gamma(here.rates, size=(LEVEL.samples, 1))
    return np.asarray(drawn + scale * rest + beside)


def _tracked(here: ResidualHere, response: Response, sizes: FloatArray) -> FloatArray:
    """Return what the model lacks at those of its lines that were tracked, (n,) N m; 0 at the others."""
    own = dict(zip(here.orders.tolist(), sizes.tolist(), strict=True))
    return np.array([own.get(order, 0.0) for order in response.state.step_orders.tolist()], dtype=np.float64)


def torque_samples(
    response: Response, estimate: Estimate, seed: int, lacking: FloatArray | None = None
) -> ComplexArray:
    """Return samples of the torque's lines as `sampled_phasors`, (k, n) N m."""
    ones, lines = np.ones((response.state.lines.size, 1), dtype=np.complex128), response.state.lines[:, None]
    torque = Response(("torque",), response.state, ones, lines, 0.0, None, response.residual)
    return sampled_phasors(torque, estimate, seed, lacking)[:, :, 0]


def torque_bands(responses: Sequence[Response], estimate: Estimate, seed: int) -> list[FloatArray]:
    """Return the 95 % interval of each of the model's torque lines at each rate, amplitudes, (n, 2) N m each."""
    return [np.quantile(np.abs(torque_samples(r, estimate, seed)), LEVEL.limits95, axis=0).T for r in responses]


def level_curve(
    requirement: Requirement,
    states: Sequence[Sequence[Response]],
    estimate: Estimate,
    errors: Sequence[OtherError],
    seed: int,
) -> LevelCurve:
    """Return the level over the rate, of the worst of the steady states at each.

    The band takes the level to be moved as the RMS under the index is, what the model lacks and the other errors
    included in both, by the same parameter samples.
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
    """Return the level over the rate with the structure's modes joined, which decides where it was computed.

    Its band is the one-way band, scaled at each rate as the nominal unit's level is. `joined` are the two-way
    responses, (r,).
    """
    level = np.array([nominal_level(requirement, [(1.0, response)], errors) for response in joined])
    known = one_way.level > 0.0
    scale = np.divide(level, one_way.level, out=np.zeros_like(level), where=known)
    band = np.where(known[:, None], scale[:, None] * one_way.band, level[:, None])
    return LevelCurve(level, band, tuple(joined))


def deciding_curve(curve: LevelCurve, level: float, ends: tuple[float, float]) -> LevelCurve:
    """Return a curve scaled so that its largest level and the band there are those that decide the margin.

    A margin counts the ensemble and what the model misses at the worst rate alone; other rates are taken to move as
    that one does. So a requirement is met where the band exceeds its limit at no rate.

    Parameters
    ----------
    curve : LevelCurve
        Of the coupling that decides, of the nominal unit.
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
    """Return an end of a band scaled to a value at rate k; that of the levels where it is zero there."""
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
