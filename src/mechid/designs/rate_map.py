"""Torque amplitude over the step rate, from a slow sweep (Fig. 4 of Kornienko2013).

The sweep passes each bin of rates so slowly that the torque in it is that of a steady motion, and that the bin holds a
whole period of the motion: at 0.5 full steps/s four steps take 8 s.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import find_peaks

from mechid.arrays import FloatArray, IntArray
from mechid.command import Command, RateProfile
from mechid.designs.settings import RATE
from mechid.plant.mechanism import Mechanism
from mechid.simulation.repetition import repetition
from mechid.simulation.simulator import Simulator, TimeBase


@dataclass(frozen=True, eq=False)
class RateMap:
    """Amplitude over the step rate of one stepping.

    Attributes
    ----------
    stepping : str
    rates : (b,)
        Centre of each bin, full steps/s.
    amplitude : (b,)
        Half the peak-to-peak torque in the bin, N m: that of the steady motion with the largest torque at a rate in the
        bin. NaN where the simulation failed.
    spread : (2, b)
        Least and largest amplitude at each rate over all possible mechanisms, the assumed one included, N m.
    mechanisms : int
        Their number.
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
        at, _ = find_peaks(curve, prominence=RATE.prominence * float(curve.max(initial=0.0)))
        found = [(float(self.rates[k]), float(curve[k])) for k in at]
        return sorted(found, key=lambda pair: -pair[1])


@dataclass(frozen=True, eq=False)
class _Sweep:
    """Command that sweeps through all bins of rates.

    Attributes
    ----------
    edges : (b + 1,)
        Edges of the bins, full steps/s.
    times_s : (b + 1,)
        Times at which the sweep passes them; the rate rises linearly in between and is 0 before the first.
    """

    edges: FloatArray
    times_s: FloatArray

    @property
    def profile(self) -> RateProfile:
        """Rate over time."""
        return RateProfile.through(zip(self.times_s.tolist(), self.edges.tolist(), strict=True))

    @property
    def base(self) -> TimeBase:
        """Time base of the sweep."""
        return TimeBase(RATE.sample_rate_hz, round(float(self.times_s[-1]) * RATE.sample_rate_hz))

    def bins(self, start: int, stop: int) -> IntArray:
        """Return the bin of each sample, (stop - start,); -1 before the sweep begins."""
        passed = np.searchsorted(self.times_s, np.arange(start, stop) / RATE.sample_rate_hz, side="right")
        # A sample exactly on the last edge belongs to the last bin.
        return np.asarray(np.minimum(passed - 1, self.edges.size - 2), dtype=np.int64)


def rate_map(mechanism: Mechanism, others: Sequence[Mechanism], command: Command, highest: float) -> RateMap:
    """Return the amplitude over the rate from 0 to `highest` full steps/s, from a sweep.

    Parameters
    ----------
    mechanism : Mechanism
    others : sequence of Mechanism
        Further possible mechanisms, over which the amplitude is spread; may be empty.
    command : Command
        Its rate is replaced by the sweep.
    highest : float
    """
    steps = repetition(mechanism, voltages=command.mirrored_steps).steps
    sweep = _sweep(highest, max(steps, command.full_steps), command.full_steps)
    simulator = Simulator(mechanism.plant, replace(command, rate=sweep.profile), sweep.base)
    own = _amplitudes(simulator, sweep, mechanism)
    each = np.array([own, *(_amplitudes(simulator, sweep, other) for other in others)])
    return RateMap(command.stepping, 0.5 * (sweep.edges[1:] + sweep.edges[:-1]), own, _spread(each), len(each))


def _sweep(highest: float, steps: int, electrical: int) -> _Sweep:
    """Return a sweep whose bins each hold a number of full steps, if `RATE.longest_s` is long enough."""
    bins = min(max(round(highest / RATE.narrowest), RATE.least_bins), RATE.bins)
    edges = np.linspace(0.0, highest, bins + 1)
    middle = 0.5 * (edges[1:] + edges[:-1])
    # An electrical period is always held; a longer repetition is cut off at the longest dwell.
    each_s = np.maximum(np.minimum(steps / middle, RATE.longest_s), np.maximum(electrical / middle, RATE.shortest_s))
    return _Sweep(edges, RATE.settled_s + np.concatenate([[0.0], np.cumsum(each_s)]))


def _spread(each: FloatArray) -> FloatArray:
    """Return the least and the largest amplitude at each rate, (2, b), over the completed simulations.

    Quantiles are not used: the assumed mechanism is one of the possible ones, but seldom in the middle. For example, a
    catalogue without a second detent gives less torque in microsteps than nearly all possible mechanisms.
    """
    # A mechanism that failed at a rate must not hide the others there.
    failed = ~np.isfinite(each)
    ends = np.where(failed, np.inf, each).min(axis=0), np.where(failed, -np.inf, each).max(axis=0)
    return np.where(failed.all(axis=0), np.nan, ends)


def _amplitudes(simulator: Simulator, sweep: _Sweep, mechanism: Mechanism) -> FloatArray:
    """Return the amplitude in each bin of a sweep, (b,) N m."""
    low, high = np.full((2, sweep.edges.size - 1), [[np.inf], [-np.inf]])
    for block in simulator.run(mechanism.kernel_values()).blocks():
        at = sweep.bins(block.start, block.stop)
        swept = at >= 0
        # Many samples share a bin: plain indexed assignment would keep only the last of them.
        np.minimum.at(low, at[swept], block.y[swept, 0])
        np.maximum.at(high, at[swept], block.y[swept, 0])
    return np.asarray(0.5 * (high - low), dtype=np.float64)
