"""Torque amplitude over the step rate, from a slow sweep: where a test is worth its time (Fig. 4 of Kornienko2013)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import find_peaks

from mechid.arrays import FloatArray
from mechid.command import Command, RateProfile
from mechid.plant.mechanism import Mechanism
from mechid.simulation.simulator import Simulator, TimeBase

SWEEP_S, SAMPLE_RATE_HZ = 60.0, 10_000.0
BINS = 120
PROMINENCE = 0.15
"""A peak rises so much of the largest amplitude above what surrounds it."""


@dataclass(frozen=True, eq=False)
class RateMap:
    """Amplitude over the step rate of one stepping.

    Attributes
    ----------
    stepping : str
    rates : (b,)
        Middle of each bin, full steps/s.
    amplitude : (b,)
        Half the distance of the highest from the lowest torque in the bin, N m; NaN where the simulation failed.
    spread : (2, b)
        Least and largest amplitude at each rate of all mechanisms that may be true, the one believed among them, N m.
    mechanisms : int
        How many these are.
    """

    stepping: str
    rates: FloatArray
    amplitude: FloatArray
    spread: FloatArray
    mechanisms: int

    @property
    def peaks(self) -> list[tuple[float, float]]:
        """Rate and amplitude of the peaks, the largest first."""
        curve = np.nan_to_num(self.amplitude)
        at, _ = find_peaks(curve, prominence=PROMINENCE * float(curve.max(initial=0.0)))
        found = [(float(self.rates[k]), float(curve[k])) for k in at]
        return sorted(found, key=lambda pair: -pair[1])


def rate_map(mechanism: Mechanism, others: Sequence[Mechanism], command: Command, highest: float) -> RateMap:
    """Return the amplitude over the rate from 0 to `highest` full steps/s, swept over a minute.

    Parameters
    ----------
    mechanism : Mechanism
    others : sequence of Mechanism
        That may be true besides: over them the amplitude is spread. May be empty.
    command : Command
        Its rate is replaced by the sweep.
    highest : float
    """
    profile = RateProfile.through([(0.0, 0.0), (SWEEP_S, highest)])
    base = TimeBase(SAMPLE_RATE_HZ, round(SWEEP_S * SAMPLE_RATE_HZ))
    simulator = Simulator(mechanism.plant, replace(command, rate=profile), base)
    own = _amplitudes(simulator, mechanism)
    each = np.array([own, *(_amplitudes(simulator, other) for other in others)])
    rates = (np.arange(BINS) + 0.5) * highest / BINS
    return RateMap(command.stepping, rates, own, _ends(each), len(each))


def _ends(each: FloatArray) -> FloatArray:
    """Return the least and the largest amplitude at each rate, (2, b), of the simulations that came so far.

    No quantiles: what is believed is one of the mechanisms, but seldom one from the middle. A catalogue that knows no
    second detent has less torque in microsteps than nearly all mechanisms that may be true.
    """
    failed = ~np.isfinite(each)
    ends = np.where(failed, np.inf, each).min(axis=0), np.where(failed, -np.inf, each).max(axis=0)
    return np.where(failed.all(axis=0), np.nan, ends)


def _amplitudes(simulator: Simulator, mechanism: Mechanism) -> FloatArray:
    """Return the amplitude in each bin of a sweep, (b,) N m."""
    low, high = np.full(BINS, np.inf), np.full(BINS, -np.inf)
    for block in simulator.run(mechanism.kernel_values()).blocks():
        at = np.arange(block.start, block.stop) * BINS // simulator.base.samples
        np.minimum.at(low, at, block.y[:, 0])
        np.maximum.at(high, at, block.y[:, 0])
    return np.asarray(0.5 * (high - low), dtype=np.float64)
