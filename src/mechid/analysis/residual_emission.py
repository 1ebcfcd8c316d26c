"""Residual torque over the rate: lines at orders of the step rate, and the density between them.

A line that the model lacks appears in no parameter error and in no relative error of a modelled line, but in the
residual, where its order identifies it. The sines of all orders are fitted jointly in windows of equal travel. The
remainder gives the amplitude that noise alone would produce.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechid.analysis.hum_in_residual import remove_hum
from mechid.analysis.named_orders import NamedOrder, named_orders
from mechid.analysis.order_tracking import TravelWindow, travel_windows
from mechid.analysis.settings import ORDER
from mechid.arrays import FloatArray
from mechid.plant.mechanism import NamedLine
from mechid.signal.density import THIRD
from mechid.signal.orders import fit_orders
from mechid.signal.remainder import Remainder
from mechid.signal.series import Series
from mechid.signal.window import windowed_density

TRACKED = (*np.arange(0.25, 2.0, 0.25).tolist(), *np.arange(2.0, 8.0, 0.5).tolist(), *np.arange(8.0, 17.0).tolist())
"""Tracked orders: quarters up to 2, for detents and phase imbalance; halves up to 8; integers up to 16 microsteps."""
SPACED = tuple(zip(TRACKED, np.diff(TRACKED, prepend=0.0).tolist(), strict=True))
"""Tracked orders with their distance to the next lower one."""
CENTRES_HZ = 10.0 ** (np.arange(41) / 10.0)
"""Centres of the third octaves of the density, 1 Hz to 10 kHz."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ResidualAtRate:
    """Residual of a torque record at one rate.

    Attributes
    ----------
    rate : float
        Magnitude in full steps/s.
    windows : int
    duration_s : float
        Total duration of the windows.
    amplitude : (K,)
        Amplitude of the lines in N m, at `TRACKED` and then at the orders that the mechanism names, including noise,
        root mean square over the windows; NaN if the record does not reach or resolve the order.
    sigma : (K,)
        Amplitude expected from noise alone, with the density between the lines.
    density : (B,)
        Density between the lines in (N m)^2/Hz, in third octaves about `CENTRES_HZ`; NaN if no window resolves it.
    orders : (K,)
        Multiples of the step rate of the lines.
    """

    rate: float
    windows: int
    duration_s: float
    amplitude: FloatArray
    sigma: FloatArray
    density: FloatArray
    orders: FloatArray = field(default_factory=lambda: np.array(TRACKED))


@dataclass(frozen=True)
class _Window:
    rate: float
    duration_s: float
    power: FloatArray
    noise: FloatArray
    density: FloatArray


def residual_emission(
    residual: Series,
    travel: Series,
    sample_rate_hz: float,
    mains_hz: float | None = None,
    named: Sequence[NamedLine] = (),
) -> tuple[ResidualAtRate, ...]:
    """Compute the residual of a torque record by ascending rate; empty if the command travels too little.

    Multiples of the mains frequency are removed, since they are not emission. Orders of a steady rate that cannot be
    separated from them are NaN. Lines that the mechanism names need long windows; they are fitted first, so that they
    do not count as density.

    Parameters
    ----------
    residual : Series of N samples
        Measured minus model, offset and drift, in N m.
    travel : Series of N samples
        Full steps travelled at each sample, non-decreasing.
    sample_rate_hz : float
    mains_hz : float or None
        Frequency in Hz of the grid whose hum is in the records.
    named : sequence of NamedLine
        Lines that the mechanism names; those without an order are left out.
    """
    found: dict[int, list[_Window]] = {}
    hidden: frozenset[float] = frozenset()
    named = [one for one in named if one.order is not None]
    if mains_hz:
        orders = (*TRACKED, *(one.order for one in named if one.order))
        residual, hidden = remove_hum(residual, travel, sample_rate_hz, mains_hz, orders)
    fitted = named_orders(residual, travel, sample_rate_hz, named, TRACKED)
    rest = Remainder(residual, model=fitted) if fitted.lines else residual
    for key, window, tracked in tracked_windows(travel, sample_rate_hz):
        found.setdefault(key, []).append(_track_window(window, window.of(rest), tracked, hidden))
    rates = [_average_windows(found[key]) for key in sorted(found)]
    if not named:
        return tuple(rates)
    at_orders = tracked_orders(named)
    seen = [one for one in fitted.lines if at_orders[len(TRACKED) + one.position] not in hidden]
    return tuple(_with_named(rates, seen, np.array(at_orders)))


def _with_named(
    rates: Sequence[ResidualAtRate], lines: Sequence[NamedOrder], orders: FloatArray
) -> Iterator[ResidualAtRate]:
    """Yield the residuals with the lines that the mechanism names, each at the nearest of the rates."""
    count = orders.size - len(TRACKED)
    at = [int(np.argmin([abs(np.log(one.rate / line.rate)) for one in rates])) for line in lines] if rates else []
    for k, one in enumerate(rates):
        power, noise = np.full((2, count), np.nan)
        for place in {line.position for line in lines}:
            own = [line for line, near in zip(lines, at, strict=True) if near == k and line.position == place]
            if own:
                power[place] = np.mean([abs(line.amplitude) ** 2 for line in own])
                noise[place] = np.mean([line.noise**2 for line in own])
        yield replace(
            one,
            amplitude=np.concatenate([one.amplitude, np.sqrt(power)]),
            sigma=np.concatenate([one.sigma, np.sqrt(noise)]),
            orders=orders,
        )


def tracked_orders(named: Sequence[NamedLine]) -> tuple[float, ...]:
    """Return the orders of the lines of a residual: `TRACKED`, then those that the mechanism names."""
    return (*TRACKED, *(one.order for one in named if one.order is not None))


def tracked_windows(travel: Series, sample_rate_hz: float) -> Iterator[tuple[int, TravelWindow, list[float]]]:
    """Yield each window of a record with the index of its rate class, of width `ORDER.rate_step`, and its orders.

    The orders are those of `TRACKED` that the window reaches and resolves; windows without any are left out.
    """
    for window in travel_windows(travel, sample_rate_hz):
        orders = [q for q, apart in SPACED if window.reaches(q) and apart * window.travelled >= ORDER.turns]
        if orders and window.size > 4 * len(orders) + 4:
            yield round(np.log(window.rate) / np.log1p(ORDER.rate_step)), window, orders


def _track_window(window: TravelWindow, left: FloatArray, orders: list[float], hidden: Collection[float]) -> _Window:
    amplitudes, rest = fit_orders(left[:, None], window.position, orders)
    duration_s = left.size / window.sample_rate_hz
    fine = windowed_density(rest[:, 0], window.sample_rate_hz)
    frequency = np.arange(fine.size) / duration_s
    at_lines, tracked = window.rate * np.array(orders), np.isin(TRACKED, orders)
    density = _third_octaves(frequency, fine, at_lines)
    near = density_around(frequency, fine, at_lines)
    power, noise = np.full((2, len(TRACKED)), np.nan)
    power[tracked], noise[tracked] = np.abs(amplitudes[:, 0]) ** 2, 2.0 * near / duration_s
    # Orders that coincide with hum at a steady rate are unknown.
    power[np.isin(TRACKED, [*hidden])] = np.nan
    return _Window(window.rate, duration_s, power, noise, density)


def density_around(frequency: FloatArray, density: NDArray[Any], lines_hz: FloatArray) -> NDArray[Any]:
    """Return the mean density around lines, (..., k), over an octave on both sides and at least `ORDER.bins` bins.

    Densities have the shape (..., n), frequencies (n,). One bin is deducted for each line fitted in the range.
    """
    # Differences of cumulative sums give all means at once, without a loop over the lines.
    sums = np.concatenate([np.zeros((*density.shape[:-1], 1)), np.cumsum(density, axis=-1)], axis=-1)
    first = np.maximum(np.searchsorted(frequency, 0.5 * lines_hz), 1)
    last = np.minimum(np.maximum(np.searchsorted(frequency, 2.0 * lines_hz), first + ORDER.bins), frequency.size)
    lowest = np.maximum(np.minimum(first, last - ORDER.bins), 1)
    fitted = np.searchsorted(lines_hz, frequency[last - 1], side="right") - np.searchsorted(lines_hz, frequency[lowest])
    return np.asarray((sums[..., last] - sums[..., lowest]) / np.maximum(last - lowest - fitted, 1))


def _third_octaves(frequency: FloatArray, density: FloatArray, lines_hz: FloatArray) -> FloatArray:
    """Return the mean density in each band, with one bin deducted per fitted line; NaN if too few bins are left."""
    edges = np.append(CENTRES_HZ / THIRD**0.5, CENTRES_HZ[-1] * THIRD**0.5)
    bins, lines = (np.histogram(at, edges)[0] for at in (frequency, lines_hz))
    left = bins - lines
    power = np.histogram(frequency, edges, weights=density)[0]
    return np.where(left >= ORDER.fewest_bins, power / np.maximum(left, 1), np.nan)


def _average_windows(windows: list[_Window]) -> ResidualAtRate:
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
    """Return the mean of each column over its finite values, NaN if there are none."""
    known = np.isfinite(rows)
    count = known.sum(axis=0)
    return np.where(count > 0, np.where(known, rows, 0.0).sum(axis=0) / np.maximum(count, 1), np.nan)
