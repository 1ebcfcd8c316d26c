"""Time-frequency picture of a record with a varying step rate: spectrograms, orders and resonances."""

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
"""Most rows of an image; with more bins, a row shows the maximum of several."""
ABOVE_RATE, ABOVE_RESONANCE = 2.5, 1.2
"""Highest shown frequency, relative to the largest step rate and to the highest resonance."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SweepPicture:
    """Spectrograms of a stretch of a record and the model, without offset and drift.

    Attributes
    ----------
    time_s : (C,)
        Centres of the columns in record time.
    lowest_hz, row_hz : float
        Lower edge of the first row, half a bin below 0 Hz, and height of each.
    measured, modelled, residual : (F, C)
        Amplitudes in the channel's unit; NaN where the simulation failed.
    rate : (R, 2)
        Breakpoints of record time in s and step rate in full steps/s.
    orders : tuple of float
        Marked orders of the step rate.
    resonances : tuple of Resonance
        Resonances of the mechanism at the current settings.
    tops_hz : tuple of float
        Suggested upper frequencies, ascending: for the orders, and for resonances above them.
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
    """Compute the spectrograms of a shown stretch, up to the marked orders and resonances."""
    sample_rate = scene.base.sample_rate_hz
    window_s = usual_window_s(picture.measured.size / sample_rate)
    swinging = resonances(mechanism)
    tops = _tops(scene, max((r.frequency_hz for r in swinging), default=0.0))
    time, frequency, first = spectrogram(picture.measured, sample_rate, window_s, WINDOWS)
    others = [spectrogram(y, sample_rate, window_s, WINDOWS)[2] for y in (picture.modelled, picture.residual)]
    shown = max(int(np.searchsorted(frequency, tops[-1], side="right")), 2)
    # The maximum of several bins keeps narrow lines visible.
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
    """Return the upper frequencies, rounded to two digits so that they stay fixed while a resonance moves."""
    wanted = (ABOVE_RATE * scene.largest_rate, ABOVE_RESONANCE * highest_hz)
    orders, all_of_it = (min(two_digits(hz), 0.5 * scene.base.sample_rate_hz) for hz in wanted)
    return (orders, all_of_it) if all_of_it > orders else (orders,)


def two_digits(value: float) -> float:
    """Round up to two significant digits; 0 stays 0.

    Examples
    --------
    >>> two_digits(1066.0), two_digits(300.0), two_digits(0.0)
    (1100.0, 300.0, 0.0)
    """
    if value == 0.0:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    # The tolerance keeps a value of exactly two digits from being rounded up.
    return float(math.ceil(value / unit - 1e-9) * unit)


def _orders(scene: Scene) -> tuple[float, ...]:
    """Return the orders of the report, and that of the microsteps, which excites the housing."""
    steps = float(scene.record.command.microsteps)
    return (*ORDERS, steps) if steps > max(ORDERS) else ORDERS
