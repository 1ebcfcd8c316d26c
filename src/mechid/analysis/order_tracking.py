"""Order tracking: amplitude and phase of recorded quantities at multiples of the step rate.

A record is cut into windows of equal travel, so that sweeps can be tracked like constant rates. In each window the
sines of all orders are fitted jointly, with their phase relative to the commanded position. Order 1 is one period
per full step.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mechid.analysis.settings import ORDER
from mechid.arrays import FloatArray, IntArray
from mechid.signal import order_amplitudes
from mechid.signal.series import Series, blocks

ORDERS = (0.5, 1.0, 2.0, 3.0, 4.0)
"""Default orders. 0.5: rotor tooth of 3.6 deg in a 1.8 deg motor; 1 to 4: full step and its harmonics."""


@dataclass(frozen=True, kw_only=True)
class OrderLine:
    """One order in one window, for several signals.

    Attributes
    ----------
    order : float
        Multiple of the step rate; 1 is one period per full step.
    rate : float
        Mean step rate, full steps/s.
    samples : (int, int)
        First sample of the window, and the one after the last.
    amplitudes : tuple of complex
        Amplitude of each signal in its unit, c in Re(c exp(2 pi i order position)).
    errors : tuple of float
        Standard error of the real and the imaginary part of each amplitude, assuming a white remainder.
    """

    order: float
    rate: float
    samples: tuple[int, int]
    amplitudes: tuple[complex, ...]
    errors: tuple[float, ...]

    def power(self, signal: int = 0) -> float:
        """Return the squared amplitude minus the mean contribution of noise; for noise alone it scatters about 0."""
        # Real and imaginary part each have the variance of the error.
        return abs(self.amplitudes[signal]) ** 2 - 2.0 * self.errors[signal] ** 2


@dataclass(frozen=True, eq=False)
class TravelWindow:
    """A window of a record in which the command moves.

    Attributes
    ----------
    along : slice
        From the first sample to the last.
    moving : (n,) of int
        Indices of the counted samples in `along`, without those at which the command dwells.
    position : (n,)
        Travel at the counted samples in full steps.
    sample_rate_hz : float
    """

    along: slice
    moving: IntArray
    position: FloatArray
    sample_rate_hz: float

    @property
    def size(self) -> int:
        """Number of counted samples."""
        return self.moving.size

    @property
    def travelled(self) -> float:
        """Travel of the window in full steps."""
        return float(self.position[-1] - self.position[0])

    @property
    def rate(self) -> float:
        """Mean rate in full steps/s."""
        return self.travelled * self.sample_rate_hz / (self.size - 1)

    def reaches(self, order: float) -> bool:
        """Return whether the line of an order is well below half the sample rate."""
        return order * self.rate < ORDER.highest_share * 0.5 * self.sample_rate_hz

    def of(self, series: Series) -> FloatArray:
        """Return the counted samples of a series, (n,)."""
        return series[self.along][self.moving]


@dataclass(frozen=True, kw_only=True)
class OrderError:
    """Model error at one order of the commanded step rate.

    Attributes
    ----------
    order : float
        Multiple of the step rate; 1 is one period per full step.
    windows : int
    measured, modelled : float
        Amplitudes in N m, root mean square over the windows.
    amplitude_error_percent : float or None
        100 (modelled / measured - 1); None if the measured line is not resolved.
    phase_error_deg : float or None
        Phase lead of the model, averaged over the windows by amplitude; None as above.
    peak_rate : float
        Rate in full steps/s of the window with the largest measured amplitude.
    peak_measured, peak_modelled : float
        Amplitudes in that window, N m.
    """

    order: float
    windows: int
    measured: float
    modelled: float
    amplitude_error_percent: float | None
    phase_error_deg: float | None
    peak_rate: float
    peak_measured: float
    peak_modelled: float


def order_errors(measured: Series, modelled: Series, travel: Series, sample_rate_hz: float) -> tuple[OrderError, ...]:
    """Compute the model error at each of `ORDERS` within the bandwidth of the record.

    Parameters
    ----------
    measured, modelled : Series of N samples
        N m.
    travel : Series of N samples
        Full steps travelled at each sample, non-decreasing.
    sample_rate_hz : float
    """
    lines: dict[float, list[OrderLine]] = {order: [] for order in ORDERS}
    for line in order_lines((measured, modelled), travel, sample_rate_hz):
        lines[line.order].append(line)
    return tuple(_order_error(order, each) for order, each in lines.items() if each)


def order_lines(
    signals: Sequence[Series], travel: Series, sample_rate_hz: float, orders: Sequence[float] = ORDERS
) -> Iterator[OrderLine]:
    """Yield the lines of each window of equal travel, at the orders within its bandwidth.

    Parameters
    ----------
    signals : sequence of Series of N samples
        Signals in their own units, without offset and drift.
    travel : Series of N samples
        Full steps travelled at each sample, non-decreasing; stretches at rest are left out.
    sample_rate_hz : float
    orders : sequence of float
        Positive orders, more than a sixteenth apart.
    """
    for window in travel_windows(travel, sample_rate_hz):
        used = [order for order in orders if window.reaches(order)]
        # Each order takes two parameters; with fewer samples the fit leaves too little to estimate its errors.
        if window.size <= 4 * len(used) + 4 or not used:
            continue
        together = np.column_stack([window.of(signal) for signal in signals])
        found, error = order_amplitudes(together, window.position, used)
        for order, amplitudes in zip(used, found.tolist(), strict=True):
            yield OrderLine(
                order=order,
                rate=window.rate,
                samples=(window.along.start, window.along.stop),
                amplitudes=tuple(amplitudes),
                errors=tuple(error.tolist()),
            )


def travel_windows(
    travel: Series, sample_rate_hz: float, window_steps: float = ORDER.window_steps
) -> Iterator[TravelWindow]:
    """Yield the windows of equal travel of a record, at least as long as asked; none if the command travels too little.

    A record that travels less than `window_steps` full steps is one window.
    """
    for samples in _windows(travel, window_steps):
        if samples.size > 1:
            along = slice(int(samples[0]), int(samples[-1]) + 1)
            moving = samples - along.start
            yield TravelWindow(along, moving, travel[along][moving], sample_rate_hz)


def _windows(travel: Series, window_steps: float) -> Iterator[IntArray]:
    """Yield the sample indices of windows of equal travel, without samples at which the command dwells."""
    first, last = float(travel[:1][0]), float(travel[travel.size - 1 :][0])
    total, count = last - first, max(int((last - first) / window_steps), 1)
    if total < ORDER.least_steps:
        return
    begun, number = [np.zeros(0, dtype=np.int64)], 0
    for part in blocks(travel.size):
        # One sample of overlap, so that motion across the boundary of two blocks is seen.
        before = max(part.start - 1, 0)
        position = travel[before : part.stop]
        moving = 1 + np.flatnonzero(np.diff(position) > 0.0)
        # The last sample would otherwise begin a window of its own.
        which = np.minimum((position[moving] - first) / total * count, count - 0.5).astype(np.int64)
        more, *others = np.split(before + moving, np.flatnonzero(np.diff(which, prepend=number)))
        begun.append(more)
        for other in others:
            yield np.concatenate(begun)
            begun = [other]
        number = int(which[-1]) if which.size else number
    yield np.concatenate(begun)


def _order_error(order: float, lines: list[OrderLine]) -> OrderError:
    y, p = np.array([line.amplitudes for line in lines]).T
    error = float(np.sqrt(np.mean([line.errors[0] ** 2 for line in lines])))
    size_y, size_p = (float(np.sqrt(np.mean(np.abs(c) ** 2))) for c in (y, p))
    peak = int(np.argmax(np.abs(y)))
    resolved = size_y > ORDER.resolved * error
    return OrderError(
        order=order,
        windows=len(lines),
        measured=size_y,
        modelled=size_p,
        amplitude_error_percent=100.0 * (size_p / size_y - 1.0) if resolved else None,
        phase_error_deg=float(np.degrees(np.angle(np.sum(p * np.conj(y))))) if resolved else None,
        peak_rate=lines[peak].rate,
        peak_measured=float(np.abs(y[peak])),
        peak_modelled=float(np.abs(p[peak])),
    )
