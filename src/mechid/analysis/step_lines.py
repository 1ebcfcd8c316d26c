"""Orders of the step rate, and named orders, over a whole record: amplitude without noise, with its error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mechid.analysis.named_orders import NamedOrder
from mechid.analysis.order_tracking import OrderLine
from mechid.plant.mechanism import NamedLine


@dataclass(frozen=True, kw_only=True)
class StepLine:
    """One order of the step rate, averaged over windows of equal travel.

    Attributes
    ----------
    order : float
    windows : int
    amplitude, sigma : float
        Root of the mean power over the windows without noise, and its standard error, in the channel's unit.
    peak_rate, peak_amplitude : float
        Rate in full steps/s of the window with the largest amplitude, and that amplitude.
    """

    order: float
    windows: int
    amplitude: float
    sigma: float
    peak_rate: float
    peak_amplitude: float


@dataclass(frozen=True, kw_only=True)
class NamedStepLine:
    """One order that a mechanism names, averaged over windows of equal travel.

    Attributes
    ----------
    names : tuple of str
        Its name, and the names of lines that the record does not separate from it.
    words : str
    order : float
        Multiple of the step rate.
    per_turn : float
        Periods per turn of the rotor.
    windows : int
    amplitude, sigma : float
        Root of the mean power over the windows without noise, and its standard error, in the channel's unit.
    """

    names: tuple[str, ...]
    words: str
    order: float
    per_turn: float
    windows: int
    amplitude: float
    sigma: float


def average_named(found: Sequence[NamedOrder], named: Sequence[NamedLine]) -> tuple[NamedStepLine, ...]:
    """Average each named order over its windows, in the order of the mechanism."""
    by_position: dict[int, list[NamedOrder]] = {}
    for line in found:
        by_position.setdefault(line.position, []).append(line)
    return tuple(_of_named(named[k], by_position[k]) for k in sorted(by_position))


def _of_named(line: NamedLine, found: Sequence[NamedOrder]) -> NamedStepLine:
    noise = np.array([one.noise for one in found])
    power = np.array([abs(one.amplitude) for one in found]) ** 2 - noise**2
    # `noise` is the root mean square of both parts together, the error of either is smaller by the root of two.
    sigma = math.sqrt(float(np.mean(noise**2)) / 2.0 / noise.size)
    return NamedStepLine(
        names=found[0].names,
        words=line.words,
        order=found[0].order,
        per_turn=line.per_turn,
        windows=len(found),
        amplitude=math.sqrt(max(float(power.mean()), 0.0)),
        sigma=sigma,
    )


def average_orders(tracked: Sequence[OrderLine]) -> tuple[StepLine, ...]:
    """Average each order over its windows, in ascending order."""
    by_order: dict[float, list[OrderLine]] = {}
    for line in tracked:
        by_order.setdefault(line.order, []).append(line)
    return tuple(_of_order(order, by_order[order]) for order in sorted(by_order))


def _of_order(order: float, lines: Sequence[OrderLine]) -> StepLine:
    """Average one order over its windows.

    The error of the mean power is its scatter over the windows, or that expected from noise if it is larger:
    |c + n|^2 has the variance 4 e^2 |c|^2 + 4 e^4 with the error e of each part of n.
    """
    power, error = np.array([line.power() for line in lines]), np.array([line.errors[0] for line in lines])
    mean = float(power.mean())
    size = math.sqrt(max(mean, 0.0))
    by_noise = float(np.mean(4.0 * error**2 * np.maximum(power, 0.0) + 4.0 * error**4)) / power.size
    # A single window has no scatter, only the error expected from noise.
    by_scatter = float(power.var(ddof=1)) / power.size if power.size > 1 else 0.0
    spread = math.sqrt(max(by_noise, by_scatter))
    peak = int(np.argmax(power))
    return StepLine(
        order=order,
        windows=len(lines),
        amplitude=size,
        sigma=min(spread / (2.0 * size), math.sqrt(spread)) if size else math.sqrt(spread),
        peak_rate=lines[peak].rate,
        peak_amplitude=math.sqrt(max(float(power[peak]), 0.0)),
    )
