"""Residual of a fit over the rate: torque lines at orders of the step rate, and the density between them.

A line that the model lacks is in no parameter's error and in no relative error of a modelled line. It is in the
residual, and there it is told by its order: in windows of equal travel the sines of all orders are fitted together, and
what they leave says how large noise alone would make them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechid.analysis.hum_in_residual import without_hum
from mechid.analysis.order_tracking import TravelWindow, travel_windows
from mechid.analysis.settings import ORDER
from mechid.arrays import FloatArray
from mechid.signal.density import THIRD
from mechid.signal.orders import fit_orders
from mechid.signal.series import Series
from mechid.signal.window import windowed_density

TRACKED = (*np.arange(0.25, 2.0, 0.25).tolist(), *np.arange(2.0, 8.0, 0.5).tolist(), *np.arange(8.0, 17.0).tolist())
"""Quarters to 2, where detents and imbalances of the phases stand, halves to 8, whole ones to 16 microsteps a step."""
SPACED = tuple(zip(TRACKED, np.diff(TRACKED, prepend=0.0).tolist(), strict=True))
"""Each with its distance to the one below."""
CENTRES_HZ = 10.0 ** (np.arange(41) / 10.0)
"""Of the third octaves of the density, 1 Hz to 10 kHz."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ResidualAtRate:
    """What is left of a torque record at one rate.

    Attributes
    ----------
    rate : float
        Full steps/s, its magnitude.
    windows : int
    duration_s : float
        Of all windows.
    amplitude : (K,)
        Amplitude of the lines at `TRACKED`, N m, noise included, root mean square over the windows; NaN where the
        record does not reach or resolve the order.
    sigma : (K,)
        The same that noise of the density between the lines would give alone.
    density : (B,)
        What lies between the lines, (N m)^2/Hz, in third octaves about `CENTRES_HZ`; NaN where no window resolves it.
    """

    rate: float
    windows: int
    duration_s: float
    amplitude: FloatArray
    sigma: FloatArray
    density: FloatArray


@dataclass(frozen=True)
class _Window:
    rate: float
    duration_s: float
    power: FloatArray
    noise: FloatArray
    density: FloatArray


def residual_emission(
    residual: Series, travel: Series, sample_rate_hz: float, mains_hz: float | None = None
) -> tuple[ResidualAtRate, ...]:
    """Return what is left of a torque record by rate, ascending; none where the command travels too little.

    Multiples of the mains' frequency are no emission: they are removed, and an order of a steady rate that the record
    does not tell from one of them is not known.

    Parameters
    ----------
    residual : Series of N samples
        Measured less model, offset and drift, N m.
    travel : Series of N samples
        Full steps travelled at each sample, never falling.
    sample_rate_hz : float
    mains_hz : float or None
        Of the grid whose hum is in the records, Hz.
    """
    found: dict[int, list[_Window]] = {}
    hidden: frozenset[float] = frozenset()
    if mains_hz:
        residual, hidden = without_hum(residual, travel, sample_rate_hz, mains_hz, TRACKED)
    for key, window, orders in tracked_windows(travel, sample_rate_hz):
        found.setdefault(key, []).append(_tracked(window, window.of(residual), orders, hidden))
    return tuple(_joined(found[key]) for key in sorted(found))


def tracked_windows(travel: Series, sample_rate_hz: float) -> Iterator[tuple[int, TravelWindow, list[float]]]:
    """Yield each window of a record with the number of its rate, alike within `ORDER.rate_step`, and its orders.

    The orders are those of `TRACKED` that it reaches and tells apart; windows without any are left out.
    """
    for window in travel_windows(travel, sample_rate_hz):
        orders = [q for q, apart in SPACED if window.reaches(q) and apart * window.travelled >= ORDER.turns]
        if orders and window.size > 4 * len(orders) + 4:
            yield round(np.log(window.rate) / np.log1p(ORDER.rate_step)), window, orders


def _tracked(window: TravelWindow, left: FloatArray, orders: list[float], hidden: Collection[float]) -> _Window:
    amplitudes, rest = fit_orders(left[:, None], window.position, orders)
    duration_s = left.size / window.sample_rate_hz
    fine = windowed_density(rest[:, 0], window.sample_rate_hz)
    frequency = np.arange(fine.size) / duration_s
    at_lines, tracked = window.rate * np.array(orders), np.isin(TRACKED, orders)
    density = _third_octaves(frequency, fine, at_lines)
    near = around(frequency, fine, at_lines)
    power, noise = np.full((2, len(TRACKED)), np.nan)
    power[tracked], noise[tracked] = np.abs(amplitudes[:, 0]) ** 2, 2.0 * near / duration_s
    power[np.isin(TRACKED, [*hidden])] = np.nan
    return _Window(window.rate, duration_s, power, noise, density)


def around(frequency: FloatArray, density: NDArray[Any], lines_hz: FloatArray) -> NDArray[Any]:
    """Return the mean density around each line, (..., k), over an octave to both sides and `ORDER.bins` bins at least.

    Of densities (..., n) at frequencies (n,). A bin less counts for each line that was fitted among them.
    """
    sums = np.concatenate([np.zeros((*density.shape[:-1], 1)), np.cumsum(density, axis=-1)], axis=-1)
    first = np.maximum(np.searchsorted(frequency, 0.5 * lines_hz), 1)
    last = np.minimum(np.maximum(np.searchsorted(frequency, 2.0 * lines_hz), first + ORDER.bins), frequency.size)
    lowest = np.maximum(np.minimum(first, last - ORDER.bins), 1)
    fitted = np.searchsorted(lines_hz, frequency[last - 1], side="right") - np.searchsorted(lines_hz, frequency[lowest])
    return np.asarray((sums[..., last] - sums[..., lowest]) / np.maximum(last - lowest - fitted, 1))


def _third_octaves(frequency: FloatArray, density: FloatArray, lines_hz: FloatArray) -> FloatArray:
    """Return the mean density in each band, a bin less for each line that was fitted there; NaN where few are left."""
    edges = np.append(CENTRES_HZ / THIRD**0.5, CENTRES_HZ[-1] * THIRD**0.5)
    bins, lines = (np.histogram(at, edges)[0] for at in (frequency, lines_hz))
    left = bins - lines
    power = np.histogram(frequency, edges, weights=density)[0]
    return np.where(left >= ORDER.fewest_bins, power / np.maximum(left, 1), np.nan)


def _joined(windows: list[_Window]) -> ResidualAtRate:
    with np.errstate(invalid="ignore"):
        power, noise, density = (
            _mean(np.array([getattr(w, name) for w in windows])) for name in ("power", "noise", "density")
        )
    return ResidualAtRate(
        rate=float(np.mean([w.rate for w in windows])),
        windows=len(windows),
        duration_s=sum(w.duration_s for w in windows),
        amplitude=np.sqrt(power),
        sigma=np.sqrt(noise),
        density=density,
    )


def _mean(rows: FloatArray) -> FloatArray:
    """Return the mean of each column over what is known, NaN where nothing is."""
    known = np.isfinite(rows)
    count = known.sum(axis=0)
    return np.where(count > 0, np.where(known, rows, 0.0).sum(axis=0) / np.maximum(count, 1), np.nan)
