"""Lines at orders that a mechanism names, such as those of its tooth meshes, in a record or a residual.

Such orders are no multiples of the step rate and may lie close together, so that windows of a few steps do not separate
them. Windows are as long as the orders need, the whole record if that is not longer. In each window the sines of the
named orders and of those of the step rate are fitted jointly.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from mechid.analysis.order_tracking import TravelWindow, travel_windows
from mechid.analysis.settings import ORDER
from mechid.arrays import ComplexArray, FloatArray
from mechid.plant.mechanism import NamedLine
from mechid.signal.orders import order_phasors, order_signal
from mechid.signal.series import Series

PROBES = (-5.0, -4.0, -3.0, 3.0, 4.0, 5.0)
"""Offsets from a line, in units of 1 / (steps travelled in the window), at which the level of the noise is read."""
PART = 1 << 16
"""Samples whose sines are held at a time."""


@dataclass(frozen=True, kw_only=True)
class NamedOrder:
    """A named order in one window, with the names that the window does not separate from it.

    Attributes
    ----------
    position : int
        Index of the line in `named`.
    names : tuple of str
        Its name first.
    order : float
        Multiple of the step rate; of several names the middle.
    rate : float
        Mean step rate, full steps/s.
    duration_s : float
    amplitude : complex
        c in Re(c exp(2 pi i order travel)), in the unit of the signal.
    noise : float
        Amplitude that noise alone would give there, root mean square.
    """

    position: int
    names: tuple[str, ...]
    order: float
    rate: float
    duration_s: float
    amplitude: complex
    noise: float


@dataclass(frozen=True, eq=False)
class NamedOrders:
    """Named orders of a signal by window, and their sum as a series, 0 where the command does not move.

    Attributes
    ----------
    lines : tuple of NamedOrder
    travel : Series
    """

    lines: tuple[NamedOrder, ...]
    travel: Series
    _parts: tuple[tuple[slice, FloatArray, ComplexArray], ...] = field(default=())

    @property
    def size(self) -> int:
        """Number of samples."""
        return self.travel.size

    def __getitem__(self, part: slice, /) -> FloatArray:
        """Return the sum of the lines at the samples of a slice."""
        index = np.arange(*part.indices(self.size))
        position, out = self.travel[part], np.zeros(index.size)
        for along, orders, amplitudes in self._parts:
            here = (index >= along.start) & (index < along.stop)
            out[here] = order_signal(amplitudes, position[here], orders.tolist())
        return out


def named_orders(
    signal: Series, travel: Series, sample_rate_hz: float, named: Sequence[NamedLine], beside: Sequence[float]
) -> NamedOrders:
    """Fit the lines of named orders.

    Parameters
    ----------
    signal : Series of N samples
        Without offset and drift.
    travel : Series of N samples
        Full steps travelled at each sample, non-decreasing.
    sample_rate_hz : float
    named : sequence of NamedLine
        Those without an order are left out.
    beside : sequence of float
        Orders of the step rate, ascending, which are fitted jointly.
    """
    wanted = [(k, one, one.order) for k, one in enumerate(named) if one.order is not None]
    if not wanted:
        return NamedOrders((), travel)
    lines: list[NamedOrder] = []
    parts = []
    for window in travel_windows(travel, sample_rate_hz, _needed_steps([q for *_, q in wanted], beside)):
        others = [q for q in beside if window.reaches(q)]
        groups = list(_groups(wanted, others, window))
        if not groups or window.size <= 4 * (len(others) + len(groups)) + 4:
            continue
        # Lines that cannot be separated are fitted at their middle order, where the error for any of them is smallest.
        orders = np.array([0.5 * (group[0][2] + group[-1][2]) for group in groups])
        found, noise = _fit_window(window, window.of(signal), orders, others)
        parts.append((window.along, orders, found))
        duration_s = window.size / sample_rate_hz
        lines += [
            NamedOrder(
                position=group[0][0],
                names=tuple(one.name for _, one, _ in group),
                order=float(order),
                rate=window.rate,
                duration_s=duration_s,
                amplitude=complex(amplitude),
                noise=float(level),
            )
            for group, order, amplitude, level in zip(groups, orders, found, noise, strict=True)
        ]
    return NamedOrders(tuple(lines), travel, tuple(parts))


def _needed_steps(orders: Sequence[float], beside: Sequence[float]) -> float:
    """Return the travel in full steps that separates the orders from one another, from others and from the mean."""
    each = np.unique(np.concatenate([[0.0], orders]))
    own = float(np.diff(each).min())
    apart = np.abs(np.subtract.outer(np.array(orders), np.array(beside)))
    # An order that equals one of the step rate can never be separated from it, and is left out here.
    other = float(apart[apart > 0.0].min(initial=np.inf))
    return max(ORDER.named_turns / min(own, other), ORDER.window_steps)


def _groups(
    wanted: Sequence[tuple[int, NamedLine, float]], others: Sequence[float], window: TravelWindow
) -> Iterator[list[tuple[int, NamedLine, float]]]:
    """Yield the named orders that a window separates from others, each with those that it does not separate from it."""
    least = ORDER.named_turns / window.travelled
    group: list[tuple[int, NamedLine, float]] = []
    for one in sorted(wanted, key=lambda one: one[2]):
        order = one[2]
        near = any(abs(order - q) < least for q in others)
        if order < least or near or not window.reaches(order):
            continue
        if group and order - group[0][2] >= least:
            yield group
            group = []
        group.append(one)
    if group:
        yield group


def _fit_window(
    window: TravelWindow, y: FloatArray, orders: FloatArray, others: Sequence[float]
) -> tuple[ComplexArray, FloatArray]:
    """Return the amplitudes of the named orders, (M,) complex, and the level of the noise at each, (M,)."""
    every = np.concatenate([orders, others])
    spans = [slice(k, k + PART) for k in range(0, y.size, PART)]
    count = 2 * every.size + 1
    normal, right = np.zeros((count, count)), np.zeros(count)
    for span in spans:
        rows = _rows(window.position[span], every)
        normal += rows @ rows.T
        right += rows @ y[span]
    solution = np.linalg.lstsq(normal, right, rcond=None)[0]
    probes = (orders[:, None] + np.array(PROBES) / window.travelled).ravel()
    off = np.zeros(probes.size, dtype=np.complex128)
    for span in spans:
        left = y[span] - _rows(window.position[span], every).T @ solution
        off += order_phasors(window.position[span], probes.tolist()).conj() @ left
    power = np.abs(2.0 * off / y.size) ** 2
    named = solution[1 : orders.size + 1] - 1j * solution[every.size + 1 : every.size + 1 + orders.size]
    return named, np.sqrt(power.reshape(orders.size, -1).mean(axis=1))


def _rows(position: FloatArray, orders: FloatArray) -> FloatArray:
    turning = order_phasors(position, orders.tolist())
    return np.concatenate([np.ones((1, position.size)), turning.real, turning.imag])
