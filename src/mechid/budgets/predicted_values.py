"""Quantities of an emission requirement from the draws of the torque at one rate.

Spectra are those of a long record under Hann's window, as measured ones: a line of amplitude A that is d bins off reads
A^2 R(d)^2 / (3 bin width), R(d) = sinc(d) / (1 - d^2). Upper bounds are quantiles of the draws. A lower bound is the
modelled value less a normal quantile of its scatter and the largest that the unmodelled torque may take from it: with
its size from n rates, |E|^2 / A^2 is F(2, 2 n) distributed, whose quantile at 1 - a is n (a^(-1/n) - 1).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtri

from mechid.arrays import ComplexArray, FloatArray, IntArray
from mechid.budgets.residual_source import EDGES_HZ
from mechid.budgets.torque_draws import TorqueDraws
from mechid.specification.bounded_values import BoundedValues
from mechid.specification.requirement import AMPLITUDE, BAND_PEAK, PSD, Requirement, whole_bands
from mechid.specification.settings import SPECIFICATION

LOBE = 4
"""Bins on each side of a line that have power under Hann's window; the rest is 1e-4 of it."""
POINTS = 8
"""Oversampling of a waveform over twice its highest frequency."""
AT_ONCE = 2_000_000
"""Samples of waveforms that are held together."""
MOST_SAMPLES, LEAST_DRAWS = 8_000_000, 100
"""Samples of all waveforms of a band above which fewer draws are taken, and their least number."""
GRID = 400
"""Points of a band over which a density is integrated."""
LEAST_GAIN = 1e-4
"""Gain of a band-pass below which a line does not reach the peak."""
OFF_MULTIPLE = 1e-6
"""Distance from a whole multiple of the waveform's frequency above which a line is none of its multiples."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueAtRate:
    """Draws of the torque at one rate, and the chances of its bounds.

    Attributes
    ----------
    draws : TorqueDraws
    rate : float
        Full steps/s.
    steps : int
        Full steps after which the modelled lines repeat.
    rates : int
        Bench rates that determine the size of the unmodelled torque.
    random : (k, 2)
        Frequency in Hz in equal steps and density in (N m)^2/Hz of what does not repeat; empty where all does.
    alpha : float
        Chance that a bound is missed.
    looks : int
        Rates at which the requirement is judged: their lower bounds hold together.
    """

    draws: TorqueDraws
    rate: float
    steps: int
    rates: int
    random: FloatArray
    alpha: float
    looks: int


def predict_values(at: TorqueAtRate, requirement: Requirement, band_hz: tuple[float, float]) -> BoundedValues:
    """Return what the draws make of a requirement's quantity, over all frequencies of its mask inside a band.

    Parameters
    ----------
    at : TorqueAtRate
    requirement : Requirement
        Of the torque.
    band_hz : (float, float)
        Frequencies that the prediction covers.
    """
    if requirement.kind == AMPLITUDE:
        return _amplitudes(at, requirement, band_hz)
    if requirement.kind == PSD:
        return _densities(at, requirement, band_hz)
    bands = whole_bands(requirement, band_hz)
    edges = np.array([band[:2] for band in bands]).reshape(-1, 2)
    limit = np.array([band[2] for band in bands]) * requirement.margin_factor
    roots = _peaks(at, edges) if requirement.kind == BAND_PEAK else _roots(at, *_band_weights(at, edges))
    return _with_bounds(at, np.asarray(np.sqrt(edges[:, 0] * edges[:, 1]), dtype=np.float64), roots, limit)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Roots:
    """Root of a power, or a peak, by frequency: nominal values (m,), draws (k, m), and what noise may hide, (m,)."""

    value: FloatArray
    modelled: FloatArray
    unmodelled: FloatArray
    drawn: FloatArray
    hidden: FloatArray


def _with_bounds(at: TorqueAtRate, frequency_hz: FloatArray, found: _Roots, limit: FloatArray) -> BoundedValues:
    # Heavy tails of a residual from few rates have no standard deviation: half the central 68 % instead.
    low, high = np.quantile(found.drawn, (0.1587, 0.8413), axis=0) if frequency_hz.size else np.zeros((2, 0))
    scatter = 0.5 * (high - low)
    upper = np.quantile(found.drawn, 1.0 - at.alpha, axis=0) if frequency_hz.size else np.zeros(0)
    # One lower bound above the mask is a fail: Bonferroni, one half each for model and unmodelled torque.
    alpha = 0.5 * at.alpha / max(at.looks * frequency_hz.size, 1)
    taken = float(ndtri(1.0 - alpha)) * scatter + _unmodelled_quantile(at.rates, alpha) * found.unmodelled
    return BoundedValues(
        frequency_hz=frequency_hz,
        value=found.value,
        sigma=scatter,
        lower=np.maximum(found.modelled - taken, 0.0),
        upper=upper,
        background=found.hidden,
        limit=limit,
    )


def _unmodelled_quantile(rates: int, alpha: float) -> float:
    """Return the quantile of the unmodelled torque's amplitude over its size, which so many rates determine."""
    # Far fewer rates than the chance asks for make the quantile infinite, and no lower bound is above 0.
    return math.sqrt(rates * math.expm1(min(-math.log(alpha) / rates, 300.0)))


def _amplitudes(at: TorqueAtRate, requirement: Requirement, band_hz: tuple[float, float]) -> BoundedValues:
    draws, (low, high) = at.draws, _part(requirement, band_hz)
    kept = (draws.frequency_hz >= low) & (draws.frequency_hz <= high)
    modelled = np.abs(draws.modelled[kept])
    lines = _Roots(
        value=np.hypot(modelled, draws.residual[kept]),
        modelled=np.maximum(modelled - draws.error[kept], 0.0),
        unmodelled=draws.limit[kept],
        drawn=np.abs(draws.samples[:, kept]) + draws.error[kept],
        hidden=np.where(draws.residual[kept] > 0.0, 0.0, draws.limit[kept]),
    )
    # Between the lines a density reads as an amplitude, one value for each of its bands.
    inside = (EDGES_HZ[1:] > low) & (EDGES_HZ[:-1] < high)
    centre = np.clip(np.sqrt(EDGES_HZ[:-1] * EDGES_HZ[1:])[inside], low, high)
    reading = 3.0 / SPECIFICATION.window_s * _densities_at(at, centre)
    between = _Roots(
        value=np.sqrt(reading),
        modelled=np.zeros(centre.size),
        unmodelled=np.sqrt(reading),
        drawn=np.sqrt(draws.scale * reading),
        hidden=np.zeros(centre.size),
    )
    parts = (lines, between)
    joined = _Roots(**{name: np.concatenate([vars(part)[name] for part in parts], axis=-1) for name in vars(lines)})
    frequency = np.concatenate([draws.frequency_hz[kept], centre])
    order = np.argsort(frequency, kind="stable")
    sorted_parts = _Roots(**{name: values[..., order] for name, values in vars(joined).items()})
    limit = requirement.mask.limit_at(frequency[order]) * requirement.margin_factor
    return _with_bounds(at, frequency[order], sorted_parts, limit)


def _part(requirement: Requirement, band_hz: tuple[float, float]) -> tuple[float, float]:
    """Return the part of a mask that lies inside a band."""
    first, last = requirement.mask.range_hz
    return max(first, band_hz[0]), min(last, band_hz[1])


def _densities(at: TorqueAtRate, requirement: Requirement, band_hz: tuple[float, float]) -> BoundedValues:
    (low, high), each = _part(requirement, band_hz), requirement.resolution_hz
    first = math.ceil(low / each)
    frequency = np.asarray(np.arange(first, math.floor(high / each) + 1) * each, dtype=np.float64)
    shares = _hann_shares(at.draws.frequency_hz, each, (first, frequency.size))
    found = _roots(at, shares / each, _densities_at(at, frequency))
    limit = requirement.mask.limit_at(frequency) * requirement.margin_factor
    roots = _with_bounds(at, frequency, found, limit)
    squares = {name: vars(roots)[name] ** 2 for name in ("value", "lower", "upper", "background")}
    # The relative error of a square is twice that of its root.
    return BoundedValues(frequency_hz=frequency, sigma=2.0 * roots.value * roots.sigma, limit=limit, **squares)


def _hann_shares(frequency_hz: FloatArray, bin_hz: float, bins: tuple[int, int]) -> FloatArray:
    """Return the share of each line's power that bins read under Hann's window, (n, m).

    Parameters
    ----------
    frequency_hz : (n,)
    bin_hz : float
    bins : (first, number)
    """
    first, number = bins
    shares = np.zeros((frequency_hz.size, number))
    rows = np.arange(frequency_hz.size)
    for offset in range(-LOBE, LOBE + 1):
        near = np.round(frequency_hz / bin_hz).astype(np.int64) + offset
        column = near - first
        inside = (column >= 0) & (column < number)
        shares[rows[inside], column[inside]] = _hann_response(frequency_hz / bin_hz - near)[inside] ** 2 / 1.5
    return shares


def _hann_response(off: FloatArray) -> FloatArray:
    """Return the reading of a sine so many bins off, over its amplitude."""
    near_one = np.abs(np.abs(off) - 1.0) < 1e-9
    # At one bin both sine and denominator are zero; the limit is one half.
    return np.where(near_one, 0.5, np.sinc(off) / np.where(near_one, 1.0, 1.0 - off**2))


def _densities_at(at: TorqueAtRate, frequency_hz: FloatArray) -> FloatArray:
    """Return the density between the lines, unmodelled and not repeating, at frequencies, (m,) (N m)^2/Hz."""
    band = np.searchsorted(EDGES_HZ, frequency_hz, side="right") - 1
    inside = (band >= 0) & (band < at.draws.density.size)
    found = np.where(inside, at.draws.density[np.clip(band, 0, at.draws.density.size - 1)], 0.0)
    if not at.random.size:
        return np.asarray(found, dtype=np.float64)
    return np.asarray(found + np.interp(frequency_hz, at.random[:, 0], at.random[:, 1]), dtype=np.float64)


def _band_weights(at: TorqueAtRate, edges: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the share of each line's power in each band, (n, m), and the power of the density there, (m,)."""
    each, lines = 1.0 / SPECIFICATION.window_s, at.draws.frequency_hz
    weights = np.zeros((lines.size, len(edges)))
    for offset in range(-LOBE, LOBE + 1):
        near = np.round(lines / each) + offset
        share = _hann_response(lines / each - near) ** 2 / 1.5
        # A bin covers half its width on both sides; an edge divides it.
        ends = (near[:, None] + np.array([-0.5, 0.5])) * each
        covered = np.minimum(ends[:, 1:], edges[:, 1]) - np.maximum(ends[:, :1], edges[:, 0])
        weights += share[:, None] * np.clip(covered / each, 0.0, 1.0)
    grids = [np.linspace(low, high, GRID) for low, high in edges]
    return weights, np.array([np.trapezoid(_densities_at(at, grid), grid) for grid in grids], dtype=np.float64)


def _roots(at: TorqueAtRate, weights: FloatArray, density: FloatArray) -> _Roots:
    """Return roots of powers: lines by their weights, (n, m), and of the density, (m,)."""
    draws = at.draws
    modelled, residual, limit = (
        0.5 * np.abs(sizes) ** 2 @ weights for sizes in (draws.modelled, draws.residual, draws.limit)
    )
    return _Roots(
        value=np.sqrt(modelled + residual + density),
        modelled=np.sqrt(modelled),
        unmodelled=np.sqrt(limit + density),
        drawn=np.sqrt((0.5 * np.abs(draws.samples) ** 2) @ weights + draws.scale * density),
        hidden=np.sqrt(np.maximum(limit - residual, 0.0)),
    )


def _peaks(at: TorqueAtRate, edges: FloatArray) -> _Roots:
    """Return the largest instantaneous values in bands after the band-pass of the definition."""
    at = _with_fewer_draws(at, float(edges.max(initial=0.0)))
    found = [_peak(at, (float(low), float(high))) for low, high in edges]
    columns = {name: [vars(one)[name] for one in found] for name in _Roots.__annotations__}
    empty = {"drawn": np.zeros((len(at.draws.samples), 0))}
    return _Roots(
        **{name: np.stack(parts, axis=-1) if parts else empty.get(name, np.zeros(0)) for name, parts in columns.items()}
    )


def _with_fewer_draws(at: TorqueAtRate, highest_hz: float) -> TorqueAtRate:
    """Return fewer draws where a motion repeats late, so that its waveforms are long: a hundred tell a quantile."""
    length = 2 * POINTS * highest_hz / abs(at.rate) * math.lcm(at.steps, 4)
    each = min(math.ceil(len(at.draws.samples) * length / MOST_SAMPLES), max(len(at.draws.samples) // LEAST_DRAWS, 1))
    if each <= 1:
        return at
    draws = replace(at.draws, samples=at.draws.samples[::each], scale=at.draws.scale[::each])
    return replace(at, draws=draws)


def _peak(at: TorqueAtRate, band_hz: tuple[float, float]) -> _Roots:
    draws, gain = at.draws, band_gain(at.draws.frequency_hz, band_hz)
    kept = np.abs(gain) > LEAST_GAIN
    lines, size = draws.samples[:, kept] * gain[kept], np.abs(gain[kept])
    # Quarters of a step are the finest orders that the records were tracked at, but for those that a mechanism names.
    whole = math.lcm(at.steps, 4)
    number = draws.orders[kept] * whole
    # Lines between all multiples meet the peak of the others, and one another, at some instant.
    alone = np.abs(number - np.round(number)) > OFF_MULTIPLE
    numbers = np.round(number[~alone]).astype(np.int64)
    grid = np.geomspace(band_hz[0] / 2.0, band_hz[1] * 2.0, GRID)
    power = np.trapezoid(_densities_at(at, grid) * np.abs(band_gain(grid, band_hz)) ** 2, grid)
    low, high = band_hz
    # Rice's rate of crossings of zero of noise in a band makes 2 N T values of which the largest counts.
    count = 2.0 * math.sqrt((low**2 + low * high + high**2) / 3.0) * SPECIFICATION.peak_s
    random = math.sqrt(power * 2.0 * math.log(max(count, 2.0)))
    modelled = draws.modelled[kept] * gain[kept]
    nominal = _largest(modelled[None, ~alone], numbers)[0] + float(np.sum(np.abs(modelled[alone])))
    # Between its samples a waveform exceeds them by no more than this (Bernstein's inequality).
    above = 1.0 / math.cos(0.5 * math.pi / POINTS)
    residual, limit = (float(np.sqrt(np.sum((sizes[kept] * size) ** 2))) for sizes in (draws.residual, draws.limit))
    return _Roots(
        value=np.asarray(math.hypot(nominal, residual) + random),
        modelled=np.asarray(nominal),
        # Unmodelled lines may all meet at one instant.
        unmodelled=np.asarray(float(np.sum(draws.limit[kept] * size)) + random),
        drawn=_largest(lines[:, ~alone], numbers) * above
        + np.sum(np.abs(lines[:, alone]), axis=1)
        + float(draws.error[kept] @ size)
        + np.sqrt(draws.scale[:, 0]) * random,
        hidden=np.asarray(math.sqrt(max(limit**2 - residual**2, 0.0))),
    )


def band_gain(frequency_hz: FloatArray, band_hz: tuple[float, float]) -> ComplexArray:
    """Return the response of the band-pass of a band peak, (n,): that of high sample rates.

    Examples
    --------
    >>> abs(band_gain(np.array([100.0, 200.0]), (100.0, 400.0))).round(3).tolist()
    [0.707, 1.0]
    """
    from scipy.signal import butter, freqs_zpk  # half a second to import, needed by this kind alone

    turn = 2.0 * np.pi
    zpk = butter(SPECIFICATION.filter_order, [turn * f for f in band_hz], "bandpass", analog=True, output="zpk")
    return np.asarray(freqs_zpk(*zpk, worN=turn * frequency_hz)[1], dtype=np.complex128)


def _largest(lines: ComplexArray, numbers: IntArray) -> FloatArray:
    """Return the largest magnitude of waveforms, (k,), from their lines, (k, n), at multiples of one frequency."""
    if not numbers.size:
        return np.zeros(len(lines))
    size = 2 * POINTS * int(numbers.max())
    out = []
    for part in np.array_split(lines, max(len(lines) * size // AT_ONCE, 1)):
        spectrum = np.zeros((len(part), size // 2 + 1), dtype=np.complex128)
        spectrum[:, numbers] = 0.5 * size * part
        out.append(np.abs(np.fft.irfft(spectrum, size, axis=1)).max(axis=1))
    return np.concatenate(out)
