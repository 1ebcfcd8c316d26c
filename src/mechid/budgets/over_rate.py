"""What a mode's steady rates make of the line of sight: its RMS and levels over the rate, with their bands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.budgets.flying_mechanism import Estimate
from mechid.budgets.line_of_sight import Response
from mechid.budgets.other_errors import OtherError
from mechid.budgets.requirement import Requirement
from mechid.budgets.shares import deviations
from mechid.budgets.standing import axis_of, nominal_level

SAMPLES = 200
"""Parameter samples at each rate."""
LIMITS95 = (0.025, 0.975)


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


def sampled_phasors(response: Response, estimate: Estimate, seed: int) -> ComplexArray:
    """Return the phasors of parameter samples drawn from the covariance, with what the model misses, (k, n, m) rad.

    With what it lacks at each of its lines too, at phases of their own, and with what was measured beside the torque.
    """
    rng, alone = np.random.default_rng(seed), response.of_drive()
    by = deviations(estimate.covariance, SAMPLES, rng)
    moved = alone.phasors + np.tensordot(by, alone.slopes[: len(estimate.names)], axes=1)
    share = estimate.discrepancy.of_lines(response.state.step_orders)
    amplitude, phase = rng.normal(size=(2, SAMPLES, share.size)) * share
    lacking = response.lacking_lines(SAMPLES, rng)[:, :, None] * response.transfer
    drive = np.asarray(moved * ((1.0 + amplitude) * np.exp(1j * phase))[:, :, None] + lacking, dtype=np.complex128)
    if response.side is None:
        return drive
    turned = phase + response.state.turned(by @ response.state.gradient[:, : len(estimate.names)].T)
    return response.side.drawn(drive, turned, rng)


def rms_bands(responses: Sequence[Response], estimate: Estimate, seed: int) -> FloatArray:
    """Return the 95 % interval of the RMS at each rate along each line of sight, (r, m, 2) rad."""
    out = []
    for response in responses:
        square = 0.5 * np.sum(np.abs(sampled_phasors(response, estimate, seed)) ** 2, axis=1)
        out.append(np.quantile(np.sqrt(square), LIMITS95, axis=0).T)
    return np.array(out)


def torque_samples(response: Response, estimate: Estimate, seed: int) -> ComplexArray:
    """Return samples of the torque's lines as `sampled_phasors`, (k, n) N m."""
    ones, lines = np.ones((response.state.lines.size, 1), dtype=np.complex128), response.state.lines[:, None]
    torque = Response(("torque",), response.state, ones, lines, 0.0, None, response.residual)
    return sampled_phasors(torque, estimate, seed)[:, :, 0]


def torque_bands(responses: Sequence[Response], estimate: Estimate, seed: int) -> list[FloatArray]:
    """Return the 95 % interval of each torque line's amplitude at each rate, (n, 2) N m each."""
    return [np.quantile(np.abs(torque_samples(r, estimate, seed)), LIMITS95, axis=0).T for r in responses]


def level_curve(
    requirement: Requirement,
    states: Sequence[Sequence[Response]],
    estimate: Estimate,
    errors: Sequence[OtherError],
    seed: int,
) -> LevelCurve:
    """Return the level over the rate, of the worst of the steady states at each.

    The band takes the level to be moved as the RMS under the index is by the same parameter samples.
    """
    levels, bands, worst = [], [], []
    for here in states:
        of_each = [nominal_level(requirement, [(1.0, response)], errors) for response in here]
        at = int(np.argmax(of_each))
        levels.append(of_each[at])
        worst.append(here[at])
        bands.append(_level_band(requirement, here[at], of_each[at], estimate, seed))
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
    requirement: Requirement, response: Response, value: float, estimate: Estimate, seed: int
) -> FloatArray:
    axis, weight = axis_of(requirement, response), requirement.index.weight(response.state.frequency_hz)
    axes = slice(None) if axis is None else slice(axis, axis + 1)
    square = np.abs(sampled_phasors(response, estimate, seed)[:, :, axes]) ** 2
    samples = np.sqrt(np.einsum("n,knm->k", weight, square))
    here = float(np.sqrt(np.einsum("n,nm->", weight, np.abs(response.phasors[:, axes]) ** 2)))
    return value * np.quantile(samples, LIMITS95) / here if here > 0.0 else np.full(2, value)
