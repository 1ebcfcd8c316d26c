"""A record whose step rate varies, over time and frequency: spectrograms, orders of the rate, resonances."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mechid.analysis.order_tracking import ORDERS
from mechid.arrays import FloatArray
from mechid.plant.mechanism import Mechanism
from mechid.signal.spectrogram import WINDOWS, largest_rows, spectrogram, usual_window_s
from mechid.simulation.resonances import Resonance, resonances
from mechid.web.picture import Picture, Scene

MOST_ROWS = 600
"""Of an image; where there are more bins a row is the largest of several."""
ABOVE_RATE, ABOVE_RESONANCE = 2.5, 1.2
"""It is shown up to so many times the largest step rate, or the highest resonance."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SweepPicture:
    """A stretch of a record beside the model over time and frequency, offset and drift removed.

    Attributes
    ----------
    time_s : (C,)
        Middles of the columns, record time.
    lowest_hz, row_hz : float
        Lower edge of the first row, half a bin below 0 Hz, and height of each.
    measured, modelled, residual : (F, C)
        Amplitudes in the channel's unit; NaN where the simulation failed.
    rate : (R, 2)
        Record time in s and step rate in full steps/s, linear between.
    orders : tuple of float
        Of the step rate, that are marked.
    resonances : tuple of Resonance
        Of the mechanism as it is set.
    tops_hz : tuple of float
        Up to which frequencies a look is worth while, ascending: the orders, and the resonances above them.
    """

    time_s: FloatArray
    lowest_hz: float
    row_hz: float
    measured: FloatArray
    modelled: FloatArray
    residual: FloatArray
    rate: FloatArray
    orders: tuple[float, ...]
    resonances: tuple[Resonance, ...]
    tops_hz: tuple[float, ...]


def sweep_picture(scene: Scene, picture: Picture, mechanism: Mechanism) -> SweepPicture:
    """Return the spectrograms of a stretch that is shown, up to the orders and resonances that are marked."""
    sample_rate = scene.base.sample_rate_hz
    window_s = usual_window_s(picture.measured.size / sample_rate)
    swinging = resonances(mechanism)
    tops = _tops(scene, max((r.frequency_hz for r in swinging), default=0.0))
    time, frequency, first = spectrogram(picture.measured, sample_rate, window_s, WINDOWS)
    others = [spectrogram(y, sample_rate, window_s, WINDOWS)[2] for y in (picture.modelled, picture.residual)]
    shown = max(int(np.searchsorted(frequency, tops[-1], side="right")), 2)
    each = math.ceil(shown / MOST_ROWS)
    measured, modelled, residual = (largest_rows(amplitude[:shown], each) for amplitude in (first, *others))
    return SweepPicture(
        time_s=time + picture.start_s,
        lowest_hz=-0.5 * frequency[1],
        row_hz=each * frequency[1],
        measured=measured,
        modelled=modelled,
        residual=residual,
        rate=scene.rate,
        orders=_orders(scene),
        resonances=swinging,
        tops_hz=tops,
    )


def _tops(scene: Scene, highest_hz: float) -> tuple[float, ...]:
    """Return up to which frequencies it is shown, of two digits, so that they stand still while a resonance moves."""
    wanted = (ABOVE_RATE * scene.largest_rate, ABOVE_RESONANCE * highest_hz)
    orders, all_of_it = (min(two_digits(hz), 0.5 * scene.base.sample_rate_hz) for hz in wanted)
    return (orders, all_of_it) if all_of_it > orders else (orders,)


def two_digits(value: float) -> float:
    """Return the next number above that has two digits, and 0 for 0.

    Examples
    --------
    >>> two_digits(1066.0), two_digits(300.0), two_digits(0.0)
    (1100.0, 300.0, 0.0)
    """
    if value == 0.0:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(math.ceil(value / unit - 1e-9) * unit)


def _orders(scene: Scene) -> tuple[float, ...]:
    """Return the report's orders, and that of the microsteps, which excites the housing."""
    steps = float(scene.record.command.microsteps)
    return (*ORDERS, steps) if steps > max(ORDERS) else ORDERS
