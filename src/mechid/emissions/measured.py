"""Measured quantities of one stretch of a record in one direction, each with bounds, as requirements ask for them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.emissions.band_peak import band_peaks
from mechid.emissions.bounds import difference_bounds, line_bounds, power_bounds
from mechid.emissions.lines import Lines, mains_of, orders_of
from mechid.emissions.settings import EMISSION
from mechid.emissions.spectra import BIN_CORRELATION, Spectra
from mechid.specification.bounded_values import BoundedValues
from mechid.specification.requirement import AMPLITUDE, BAND_PEAK, PSD, Requirement, whole_bands


@dataclass(frozen=True, kw_only=True, eq=False)
class Stretch:
    """One stretch of a record in one direction, with the background measured there.

    Attributes
    ----------
    y : ndarray, shape (N,)
        Samples in SI.
    rate : float
        Full steps/s; NaN where it is not known.
    spectra : Spectra
    lines : Lines
    background : Spectra or None
        By windows of the same length.
    background_lines : Lines or None
    background_y : ndarray or None
    bench_error : ndarray or None, shape (M,)
        Density of the error that calibration and response of the bench leave, at the bins of `spectra`.
    """

    y: FloatArray
    rate: float
    spectra: Spectra
    lines: Lines
    background: Spectra | None = None
    background_lines: Lines | None = None
    background_y: FloatArray | None = None
    bench_error: FloatArray | None = None


def measure(
    stretch: Stretch, requirement: Requirement, records: int, fine: tuple[Spectra, Spectra | None] | None = None
) -> BoundedValues:
    """Return what a stretch measures of a requirement's quantity, over all frequencies of its mask.

    A pass needs every upper bound below the mask, so each is at its own confidence. A fail needs one lower bound above
    it, so the chance of an error is divided by the number of frequencies and records (Bonferroni).

    Parameters
    ----------
    stretch : Stretch
    requirement : Requirement
    records : int
        Stretches of all records that the requirement holds for.
    fine : (Spectra, Spectra or None) or None
        Spectra of the stretch and of its background at the requirement's resolution, of a power density.
    """
    alpha = 0.5 * (1.0 - requirement.confidence)
    if requirement.kind == AMPLITUDE:
        found = _amplitudes(stretch, requirement, alpha, records)
    elif requirement.kind == PSD:
        spectra, background = fine or (stretch.spectra, stretch.background)
        found = _densities(stretch, requirement, (spectra, background), alpha, records)
    elif requirement.kind == BAND_PEAK:
        found = _peaks(stretch, requirement, alpha, records)
    else:
        found = _bands(stretch, requirement, alpha, records)
    return found if stretch.bench_error is None else _widen(found, stretch, requirement, alpha)


def _widen(found: BoundedValues, stretch: Stretch, requirement: Requirement, alpha: float) -> BoundedValues:
    """Return values with bounds that the error of the bench widens; at all rates it is the same."""
    from scipy.special import ndtri

    assert stretch.bench_error is not None
    spectra, error = stretch.spectra, stretch.bench_error
    z = float(ndtri(1.0 - alpha))
    if requirement.kind in (AMPLITUDE, PSD):
        # The main lobe of a line is three bins wide, and the nearest bin may be one beside its top.
        near = np.clip(np.round(found.frequency_hz / spectra.bin_hz).astype(np.int64), 1, error.size - 2)
        own = np.max([error[near + k] for k in (-1, 0, 1)], axis=0)
        size = np.sqrt(own * (spectra.peak_scale if requirement.kind == AMPLITUDE else 1.0))
    else:
        edges = np.array([band[:2] for band in whole_bands(requirement, spectra.usable_hz)]).reshape(-1, 2)
        size = np.sqrt(sum_bins(error, spectra.bin_hz, edges))
        if requirement.kind == BAND_PEAK:
            rms = np.sqrt(sum_bins(spectra.density, spectra.bin_hz, edges))
            size = found.value * size / np.maximum(rms, np.finfo(np.float64).tiny)
    power = 2.0 if requirement.kind == PSD else 1.0
    value, lower, upper = (np.maximum(x, 0.0) ** (1.0 / power) for x in (found.value, found.lower, found.upper))
    return replace(
        found,
        sigma=np.hypot(found.sigma, power * np.maximum(value, size) ** (power - 1.0) * size),
        lower=np.maximum(lower - z * size, 0.0) ** power,
        upper=(upper + z * size) ** power,
    )


def _in_mask(frequency_hz: FloatArray, requirement: Requirement) -> FloatArray:
    """Return the limit at frequencies with the margin subtracted; infinite outside the mask."""
    return requirement.mask.limit_at(frequency_hz) * requirement.margin_factor


def background_amplitude(stretch: Stretch, alpha: float) -> FloatArray:
    """Return the upper bound of the background's line at each line of a stretch, (n,); 0 where there is none."""
    found, own = np.zeros(stretch.lines.frequency_hz.size), stretch.background_lines
    if own is not None and own.frequency_hz.size:
        upper = own.bounds(alpha, alpha)[1]
        apart = np.abs(stretch.lines.frequency_hz[:, None] - own.frequency_hz[None, :]) / stretch.spectra.bin_hz
        nearest = np.argmin(apart, axis=1)
        is_near = apart[np.arange(found.size), nearest] <= 2.0 * EMISSION.near_bins
        found = np.where(is_near, upper[nearest], 0.0)
    return found


def excluded_lines(stretch: Stretch) -> BoolArray:
    """Tell which lines are the mains' alone, (n,): one that is also at an order of the step rate is not."""
    frequency = stretch.lines.frequency_hz
    is_mains = ~np.isnan(mains_of(frequency, stretch.spectra))
    return is_mains & np.isnan(orders_of(frequency, stretch.rate, stretch.spectra.bin_hz))


def _amplitudes(stretch: Stretch, requirement: Requirement, alpha: float, records: int) -> BoundedValues:
    """Return the amplitudes of all lines, and for the bins beside them what a line there could have at most."""
    spectra, lines = stretch.spectra, stretch.lines
    judged = spectra.usable_bins()
    limits = _in_mask(spectra.frequency_hz, requirement)
    looks = max(int(np.sum(judged & np.isfinite(limits))), 1) * records
    lower, upper = lines.bounds(alpha / looks, alpha)
    beside = background_amplitude(stretch, alpha)
    drift = (1.0 + EMISSION.line_drift) * beside
    kept = judged[lines.bins]
    if requirement.exclude_mains:
        kept = kept & ~excluded_lines(stretch)
    noise = spectra.noise * spectra.peak_scale
    # least amplitude that noise alone would leave open
    floor = np.sqrt(line_bounds(np.ones(1), lines.windows, alpha)[1][0] * noise)
    free = judged.copy()
    for k in range(-EMISSION.core, EMISSION.core + 1):
        # Bins of a line's main lobe hold the line and cannot bound another one.
        free[np.clip(lines.bins + k, 0, free.size - 1)] = False
    ratio = spectra.apart.mean(axis=0)[free] * spectra.peak_scale / noise[free]
    bins_upper = np.sqrt(line_bounds(ratio, lines.windows, alpha)[1] * noise[free]) / EMISSION.least_response
    zero = np.zeros(bins_upper.size)
    frequency = np.concatenate([lines.frequency_hz[kept], spectra.frequency_hz[free]])
    return _sort_by_frequency(
        BoundedValues(
            frequency_hz=frequency,
            value=np.concatenate([np.sqrt(np.maximum(lines.amplitude**2 - beside**2, 0.0))[kept], zero]),
            sigma=np.concatenate([lines.sigma[kept], np.sqrt(0.5 * noise[free] / lines.windows)]),
            lower=np.concatenate([np.maximum(lower - drift, 0.0)[kept], zero]),
            upper=np.concatenate([(upper + drift)[kept], bins_upper]),
            background=np.concatenate([np.maximum(drift, floor[lines.bins])[kept], floor[free]]),
            limit=_in_mask(frequency, requirement),
        )
    )


def _sort_by_frequency(found: BoundedValues) -> BoundedValues:
    order = np.argsort(found.frequency_hz, kind="stable")
    order = order[np.isfinite(found.limit[order])]
    return BoundedValues(**{name: values[order] for name, values in vars(found).items()})


def _densities(
    stretch: Stretch,
    requirement: Requirement,
    spectra: tuple[Spectra, Spectra | None],
    alpha: float,
    records: int,
) -> BoundedValues:
    own, background = spectra
    limit = _in_mask(own.frequency_hz, requirement)
    kept = own.usable_bins() & np.isfinite(limit)
    if requirement.exclude_mains:
        kept &= ~_mains_bins(stretch, own)
    powers = (own.density[kept], own.variance[kept])
    other = (background.density[kept], background.variance[kept]) if background else None
    drift = _line_powers(own, background)[kept]
    looks = max(int(kept.sum()), 1) * records
    value, sigma, lower, upper = _subtract_background(powers, other, drift, (alpha / looks, alpha))
    zero = np.zeros(value.size)
    return BoundedValues(
        frequency_hz=own.frequency_hz[kept],
        value=value,
        sigma=sigma,
        lower=lower,
        upper=upper,
        background=other[0] if other else zero,
        limit=limit[kept],
    )


def _subtract_background(
    own: tuple[FloatArray, FloatArray],
    other: tuple[FloatArray, FloatArray] | None,
    drift: FloatArray,
    alphas: tuple[float, float],
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return powers less the background's, their standard errors and bounds; each power comes with its variance."""
    power, variance = own
    bounded = (power, *power_bounds(power, _dof(power, variance), *alphas))
    if other is None:
        return power, np.sqrt(variance), np.maximum(bounded[1] - drift, 0.0), bounded[2] + drift
    less = (other[0], *power_bounds(other[0], _dof(*other), alphas[1], alphas[0]))
    # the background's own bounds at the level of the bound they enter
    above = (other[0], *power_bounds(other[0], _dof(*other), alphas[1], alphas[1]))
    value, lower, _ = difference_bounds(bounded, less)
    _, _, upper = difference_bounds(bounded, above)
    sigma = np.sqrt(variance + other[1])
    return np.maximum(value, 0.0), sigma, np.maximum(lower - drift, 0.0), np.maximum(upper, 0.0) + drift


def _dof(power: FloatArray, variance: FloatArray) -> FloatArray:
    tiny = np.finfo(np.float64).tiny
    # A chi-square value has the mean nu and the variance 2 nu.
    return np.asarray(np.minimum(2.0 * power**2 / np.maximum(variance, tiny), 1e7), dtype=np.float64)


def _line_powers(own: Spectra, background: Spectra | None) -> FloatArray:
    """Return the doubt that lines of the background leave in each bin, (M,): their phase to the emission is not known.

    Two sines of powers p and b make from (sqrt p - sqrt b)^2 to (sqrt p + sqrt b)^2 together.
    """
    if background is None:
        return np.zeros(own.density.size)
    line = np.where(background.density > EMISSION.above_noise * background.noise, background.density, 0.0)
    return np.asarray(2.0 * (1.0 + EMISSION.line_drift) * np.sqrt(own.density * line), dtype=np.float64)


def _mains_bins(stretch: Stretch, spectra: Spectra) -> BoolArray:
    """Tell which bins the mains alone fill, (M,)."""
    found = np.zeros(spectra.density.size, dtype=np.bool_)
    own = stretch.lines.frequency_hz[excluded_lines(stretch)]
    for frequency in own:
        found |= np.abs(spectra.frequency_hz - frequency) <= 2.0 * spectra.bin_hz
    return found


def _bands(stretch: Stretch, requirement: Requirement, alpha: float, records: int) -> BoundedValues:
    """Return RMS values of the mask's bands or of third octaves, from the sums of their bins."""
    spectra, background = stretch.spectra, stretch.background
    bands = whole_bands(requirement, spectra.usable_hz)
    looks = max(len(bands), 1) * records
    weight = np.ones(spectra.density.size)
    if requirement.exclude_mains:
        weight[_mains_bins(stretch, spectra)] = 0.0
    edges = np.array([band[:2] for band in bands]).reshape(-1, 2)
    own = _band_power(spectra, edges, weight, len(spectra.apart))
    other = _band_power(background, edges, weight, len(background.apart)) if background else None
    drift = sum_bins(_line_powers(spectra, background) * weight, spectra.bin_hz, edges)
    value, sigma, lower, upper = _subtract_background(own, other, drift, (alpha / looks, alpha))
    root = np.sqrt(value)
    tiny = np.finfo(np.float64).tiny
    return BoundedValues(
        frequency_hz=np.sqrt(edges[:, 0] * edges[:, 1]),
        value=root,
        sigma=sigma / (2.0 * np.sqrt(np.maximum(np.maximum(value, sigma), tiny))),
        lower=np.sqrt(lower),
        upper=np.sqrt(upper),
        background=np.sqrt(other[0]) if other else np.zeros(root.size),
        limit=np.array([band[2] for band in bands]) * requirement.margin_factor,
    )


def sum_bins(density: FloatArray, bin_hz: float, edges: FloatArray) -> FloatArray:
    """Return the integrals of a density, (M,), between edges in Hz, (n, 2); a bin counts by the part that is inside."""
    # A bin covers half its width on both sides; the linear cumulative sum divides it at an edge.
    ends = (np.arange(density.size + 1) - 0.5) * bin_hz
    total = np.concatenate([[0.0], np.cumsum(density) * bin_hz])
    return np.asarray(np.interp(edges[:, 1], ends, total) - np.interp(edges[:, 0], ends, total), dtype=np.float64)


def _band_power(spectra: Spectra, edges: FloatArray, weight: FloatArray, windows: int) -> tuple[FloatArray, FloatArray]:
    """Return powers of bands and their variances: by the noise, or by the scatter over windows where that is larger."""
    power = sum_bins(spectra.density * weight, spectra.bin_hz, edges)
    # Neighbouring bins under Hann's window are correlated, which widens the scatter of their sum.
    variance = sum_bins(spectra.variance * weight, spectra.bin_hz, edges) * (spectra.bin_hz * BIN_CORRELATION)
    if windows > 1 and len(edges):
        each = np.stack([sum_bins(row * weight, spectra.bin_hz, edges) for row in spectra.apart])
        variance = np.maximum(variance, np.var(each, axis=0, ddof=1) / windows)
    return power, variance


def _peaks(stretch: Stretch, requirement: Requirement, alpha: float, records: int) -> BoundedValues:
    rate = stretch.spectra.sample_rate_hz
    bands = whole_bands(requirement, stretch.spectra.usable_hz)
    edges = [(low, high) for low, high, _ in bands]
    looks = max(len(bands), 1) * records
    if stretch.background_y is None:
        spans = np.array(edges).reshape(-1, 2)
        noise = np.sqrt(sum_bins(stretch.spectra.noise, stretch.spectra.bin_hz, spans))
    else:
        noise = band_peaks(stretch.background_y, rate, edges)[1]
    return _peak_bounds(
        stretch, (edges, noise), alpha, looks, np.array([b[2] for b in bands]) * requirement.margin_factor
    )


def _peak_bounds(
    stretch: Stretch,
    bands: tuple[list[tuple[float, float]], FloatArray],
    alpha: float,
    looks: int,
    limit: FloatArray,
) -> BoundedValues:
    """Return the peaks of bands with bounds; `noise` is the RMS of the background in each."""
    from scipy.special import ndtri

    edges, noise = bands
    rate = stretch.spectra.sample_rate_hz
    peak = band_peaks(stretch.y, rate, edges)[0]
    low, high = np.array(edges).reshape(-1, 2).T
    # Rice's rate of crossings of zero of noise in a band makes 2 N T values of which the largest counts
    count = np.maximum(2.0 * np.sqrt((low**2 + low * high + high**2) / 3.0) * stretch.y.size / rate, 1.0)
    largest = noise * np.sqrt(2.0 * np.log(count * looks / alpha))
    usual = noise * np.sqrt(2.0 * np.log(np.maximum(count, 2.0)))
    return BoundedValues(
        frequency_hz=np.sqrt(low * high),
        value=peak,
        sigma=noise,
        lower=np.maximum(peak - largest, 0.0),
        # at the instant of the emission's own peak the noise has its usual size, however long the record is
        upper=peak + noise * float(ndtri(1.0 - alpha)),
        background=usual if stretch.background_y is not None else np.zeros(peak.size),
        limit=limit,
    )
