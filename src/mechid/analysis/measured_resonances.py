"""Resonances in a record: frequencies of large response, independent of the step rate.

There are two kinds of evidence. If the rate varies, each order is largest when it passes a resonance: peaks of several
orders at different rates but one frequency indicate a resonance, peaks at one rate do not. Also, the spectral density
of the record, smoothed over its lines, has a hump at a resonance.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from mechid.analysis.order_tracking import OrderLine
from mechid.analysis.settings import RESONANCE
from mechid.arrays import FloatArray
from mechid.signal.lines import Line


@dataclass(frozen=True, kw_only=True)
class MeasuredResonance:
    """A resonance: a frequency that does not follow the step rate.

    Attributes
    ----------
    frequency_hz : float
    spread_hz : float
        Half the distance of the peaks, or half the width of the hump 3 dB below its top.
    orders : tuple of float
        Orders of the step rate that peak at the resonance, at different rates; empty if none was tracked.
    hump : bool
        Whether the density has a hump at the frequency.
    """

    frequency_hz: float
    spread_hz: float
    orders: tuple[float, ...]
    hump: bool


def measured_resonances(
    tracked: Iterable[OrderLine],
    frequency: FloatArray,
    density: FloatArray,
    *,
    lines: Sequence[Line],
    spacing_hz: float,
) -> tuple[MeasuredResonance, ...]:
    """Find the resonances of a record, in order of frequency.

    Parameters
    ----------
    tracked : iterable of OrderLine
        Lines of the orders over a varying rate; empty if the rate is constant or unknown.
    frequency, density : ndarray, shape (M,)
        Result of `mechid.signal.power_density`.
    lines : sequence of Line
        Lines of the spectrum.
    spacing_hz : float
        Distance of the lines of a constant rate, whose tops form the humps; 0 if the rate is not constant, in which
        case the density between the lines forms them.
    """
    humps = _humps(frequency, density if spacing_hz else _without_lines(frequency, density, lines), spacing_hz)
    groups = [group for group in _groups(_order_peaks(tracked)) if len({order for order, _ in group}) > 1]
    found = [_from_peaks(group, humps) for group in groups]
    explained = [one.frequency_hz for one in found]
    alone = [h for h in humps if not any(abs(h[0] / hz - 1.0) < 2.0 * RESONANCE.alike for hz in explained)]
    found += [MeasuredResonance(frequency_hz=hz, spread_hz=half, orders=(), hump=True) for hz, half in alone]
    return tuple(sorted(found, key=lambda one: one.frequency_hz))


def _from_peaks(group: Sequence[tuple[float, float]], humps: Sequence[tuple[float, float]]) -> MeasuredResonance:
    frequencies = [frequency for _, frequency in group]
    middle = float(np.median(frequencies))
    return MeasuredResonance(
        frequency_hz=middle,
        spread_hz=0.5 * (max(frequencies) - min(frequencies)),
        orders=tuple(sorted({order for order, _ in group})),
        hump=any(abs(hz / middle - 1.0) < 2.0 * RESONANCE.alike for hz, _ in humps),
    )


def _order_peaks(lines: Iterable[OrderLine]) -> list[tuple[float, float]]:
    """Return order and frequency of each amplitude peak over the rate."""
    by_order: dict[float, list[OrderLine]] = {}
    for line in lines:
        by_order.setdefault(line.order, []).append(line)
    return [peak for order, each in by_order.items() for peak in _peaks_of(order, sorted(each, key=lambda x: x.rate))]


def _peaks_of(order: float, lines: Sequence[OrderLine]) -> list[tuple[float, float]]:
    amplitude = np.array([math.sqrt(max(line.power(), 0.0)) for line in lines])
    noise = np.array([line.errors[0] for line in lines])
    # Raising small amplitudes to the noise keeps peaks of noise from standing out.
    size = np.maximum(amplitude, RESONANCE.above_noise * noise / RESONANCE.stands_out)
    # Imported here: loading takes 0.4 s, needed only in the search for resonances.
    from scipy.signal import find_peaks

    peaks, _ = find_peaks(np.log(np.maximum(size, np.finfo(float).tiny)), prominence=math.log(RESONANCE.stands_out))
    return [
        (order, order * _rate_at(lines, amplitude, k))
        for k in peaks.tolist()
        if amplitude[k] > RESONANCE.above_noise * noise[k]
    ]


def _rate_at(lines: Sequence[OrderLine], amplitude: FloatArray, peak: int) -> float:
    """Return the rate of a peak, averaged over the adjacent windows with their power as weight."""
    # The top lies between the rates of the windows; their power locates it.
    around = slice(max(peak - 1, 0), peak + 2)
    return float(np.average([line.rate for line in lines[around]], weights=amplitude[around] ** 2))


def _groups(peaks: Sequence[tuple[float, float]]) -> list[list[tuple[float, float]]]:
    """Group peaks of similar frequency."""
    groups: list[list[tuple[float, float]]] = []
    for peak in sorted(peaks, key=lambda p: p[1]):
        # Compared with the first peak of the group: a chain of close peaks must not grow without limit.
        if groups and peak[1] <= groups[-1][0][1] * (1.0 + RESONANCE.alike):
            groups[-1].append(peak)
        else:
            groups.append([peak])
    return groups


def _without_lines(frequency: FloatArray, density: FloatArray, lines: Sequence[Line]) -> FloatArray:
    """Replace the lines of a density by linear interpolation.

    Under a Hann window, the skirt of a line at a distance of d bins is 1 / (pi d^3) of its amplitude. The line is cut
    out to the distance at which its skirt reaches the surrounding level.
    """
    number = np.arange(frequency.size)
    kept = np.ones(frequency.size, dtype=bool)
    for line in lines:
        skirt = RESONANCE.line_bins + (math.sqrt(line.ratio) / math.pi) ** (1.0 / 3.0)
        kept[np.abs(number - line.frequency_hz / frequency[1]) <= skirt] = False
    return np.interp(number, number[kept], density[kept]) if kept.any() else density


def _humps(frequency: FloatArray, density: FloatArray, spacing_hz: float) -> list[tuple[float, float]]:
    """Return frequency and half-width of the humps of a density, in Hz."""
    from scipy.signal import find_peaks

    width = float(frequency[1])
    lowest = max(RESONANCE.lines_a_hump * spacing_hz, 8.0 * width)
    if lowest * 10.0 ** (8 / RESONANCE.points_a_decade) >= frequency[-1]:
        return []
    # A window of one line spacing always contains the top of a line.
    reach = 2 * math.ceil(0.5 * spacing_hz / width) + 1
    tops = maximum_filter1d(density, reach) if spacing_hz else density
    # A logarithmic grid gives humps the same relative resolution at all frequencies.
    grid = np.geomspace(
        0.5 * lowest, frequency[-1], int(RESONANCE.points_a_decade * math.log10(frequency[-1] / lowest) + 8)
    )
    level = np.maximum(np.interp(grid, frequency, _running_mean(frequency, tops)), np.finfo(float).tiny)
    decibels = 10.0 * gaussian_filter1d(np.log10(level), RESONANCE.smooth * RESONANCE.points_a_decade / math.log(10.0))
    # The upper octave of the band stands for the noise floor.
    floor = float(np.median(decibels[grid > 0.5 * frequency[-1]]))
    peaks, facts = find_peaks(decibels, prominence=RESONANCE.hump_db, width=1, rel_height=1.0)
    found = []
    for k, prominent in zip(peaks.tolist(), facts["prominences"].tolist(), strict=True):
        if grid[k] < lowest or decibels[k] < floor + RESONANCE.hump_db:
            continue
        inside = _extent(decibels, k, min(3.0, prominent))
        half = 0.5 * float(grid[inside[1]] - grid[inside[0]])
        if half >= RESONANCE.wider * spacing_hz:
            found.append((float(grid[k]), half))
    return found


def _extent(decibels: FloatArray, peak: int, below: float) -> tuple[int, int]:
    """Return the outermost points around a peak that are less than `below` dB under it."""
    under = np.flatnonzero(decibels < decibels[peak] - below)
    before, after = under[under < peak], under[under > peak]
    return (int(before[-1]) + 1 if before.size else 0), (int(after[0]) - 1 if after.size else decibels.size - 1)


def _running_mean(frequency: FloatArray, density: FloatArray) -> FloatArray:
    """Return the moving average of a density over the relative width `RESONANCE.smooth` on both sides."""
    # With a cumulative sum the cost does not depend on the width, which grows with frequency.
    total = np.concatenate([[0.0], np.cumsum(density)])
    number = np.arange(frequency.size)
    first = np.minimum(np.floor(number * (1.0 - RESONANCE.smooth)).astype(np.int64), number)
    stop = np.minimum(np.ceil(number * (1.0 + RESONANCE.smooth)).astype(np.int64) + 1, frequency.size)
    return np.asarray((total[stop] - total[first]) / (stop - first), dtype=np.float64)
