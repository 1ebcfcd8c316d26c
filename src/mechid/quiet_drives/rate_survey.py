"""Level over the rate for each stepping: recommended and forbidden rates, quiet bands, pairs of rates.

The bound of a level is its mean over draws of the covariance plus 1.645 standard deviations. A stepping is named
``full``, ``half``, ``micro16``, and ``table`` for microsteps with the found table.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from mechid.arrays import FloatArray
from mechid.plant.mechanism import Mechanism
from mechid.quiet_drives.periodic_torque import PeriodicTorque
from mechid.quiet_drives.quantity import TORQUE, Quantity
from mechid.quiet_drives.settings import QUIET

RECOMMENDED, ALLOWED, FORBIDDEN, LOST = "recommended", "allowed", "forbidden", "loses steps"


@dataclass(frozen=True, eq=False)
class SteppingCurve:
    """Level of one stepping over the rate.

    Attributes
    ----------
    stepping : str
    rates : (r,)
        Full steps/s.
    level, bound : (r,)
        RMS of the lines in N m or rad, and its 95 % bound; NaN where steps are lost.
    verdicts : tuple of str, (r,)
        `RECOMMENDED`, `ALLOWED`, `FORBIDDEN` or `LOST`.
    """

    stepping: str
    rates: FloatArray
    level: FloatArray
    bound: FloatArray
    verdicts: tuple[str, ...]


@dataclass(frozen=True)
class Band:
    """Neighbouring rates of one stepping with the same verdict, full steps/s; `worst` is their largest bound."""

    stepping: str
    verdict: str
    low: float
    high: float
    worst: float


@dataclass(frozen=True)
class Pair:
    """Two rates that alternate to a mean rate, with the least mean-square bound.

    Attributes
    ----------
    mean, low, high : float
        Full steps/s.
    share : float
        Share of the time at the higher rate.
    stepping : str
    rms : float
        Root of the mean square of the bounds.
    alone : float
        Bound at the mean rate alone; NaN where steps are lost there.
    """

    mean: float
    low: float
    high: float
    share: float
    stepping: str
    rms: float
    alone: float


@dataclass(frozen=True, eq=False)
class Survey:
    """Curves of all steppings, their bands and the best pairs; `limit` separates forbidden rates."""

    curves: tuple[SteppingCurve, ...]
    bands: tuple[Band, ...]
    pairs: tuple[Pair, ...]
    limit: float


def survey(
    mechanisms: Sequence[Mechanism],
    tables: Mapping[str, FloatArray],
    rates: FloatArray,
    mean_rates: Sequence[float],
    limit: float | None,
    quantity: Quantity = TORQUE,
) -> Survey:
    """Return the level of each stepping over the rate.

    Parameters
    ----------
    mechanisms : sequence of Mechanism
        The nominal one first, then draws.
    tables : mapping of str to (4 n, 2)
        Table of each stepping.
    rates : (r,)
        Full steps/s.
    mean_rates : sequence of float
        Mean rates for which a pair is looked for.
    limit : float or None
        Bound above which a rate is forbidden; None takes `QUIET.loud_ratio` times the median of all steppings' bounds.
    quantity : Quantity
    """
    found = np.array(
        [[_level_and_bound(mechanisms, table, float(rate), quantity) for rate in rates] for table in tables.values()]
    )
    bounds = found[:, :, 1]
    heard = bounds[np.isfinite(bounds)]
    median = float(np.median(heard)) if heard.size else 0.0
    if limit is None:
        limit = QUIET.loud_ratio * median
    quiet = min(float(np.quantile(heard, QUIET.quiet_quantile)) if heard.size else 0.0, limit)
    curves = tuple(
        SteppingCurve(name, rates, own[:, 0], own[:, 1], tuple(_verdict(b, quiet, limit) for b in own[:, 1]))
        for name, own in zip(tables, found, strict=True)
    )
    bands = tuple(band for curve in curves for band in _bands(curve))
    pairs = tuple(pair for mean in mean_rates for pair in [_best_pair(curves, mean)] if pair is not None)
    return Survey(curves, bands, pairs, limit)


def widest_bands(found: Survey, verdict: str = RECOMMENDED, count: int = QUIET.most_bands) -> list[Band]:
    """Return the widest bands of a verdict, by their width in octaves."""
    own = [band for band in found.bands if band.verdict == verdict and band.high > band.low]
    return sorted(own, key=lambda band: -band.high / band.low)[:count]


def _level_and_bound(
    mechanisms: Sequence[Mechanism], table: FloatArray, rate: float, quantity: Quantity
) -> tuple[float, float]:
    levels = []
    for mechanism in mechanisms:
        lines = PeriodicTorque(mechanism, rate, quantity).lines(table)
        if lines is None:
            return float("nan"), float("nan")
        levels.append(lines.level)
    spread = float(np.std(levels[1:], ddof=1)) if len(levels) > 2 else 0.0
    return levels[0], max(float(np.mean(levels)), levels[0]) + QUIET.quantile * spread


def _verdict(bound: float, quiet: float, limit: float) -> str:
    if not np.isfinite(bound):
        return LOST
    return RECOMMENDED if bound <= quiet else FORBIDDEN if bound > limit else ALLOWED


def _bands(curve: SteppingCurve) -> list[Band]:
    out = []
    for verdict, group in groupby(range(curve.rates.size), key=lambda k: curve.verdicts[k]):
        own = list(group)
        worst = float(np.max(curve.bound[own])) if verdict != LOST else float("nan")
        out.append(Band(curve.stepping, verdict, float(curve.rates[own[0]]), float(curve.rates[own[-1]]), worst))
    return out


def _best_pair(curves: Sequence[SteppingCurve], mean: float) -> Pair | None:
    """Return the pair of rates of one stepping that alternate to a mean rate with the least mean square."""
    best: Pair | None = None
    for curve in curves:
        square = np.where(np.isfinite(curve.bound), curve.bound, np.inf) ** 2
        below, above = np.flatnonzero(curve.rates <= mean)[::-1], np.flatnonzero(curve.rates >= mean)
        for i in below:
            for j in above:
                low, high = float(curve.rates[i]), float(curve.rates[j])
                share = (mean - low) / (high - low) if high > low else 0.0
                rms = float(np.sqrt((1.0 - share) * square[i] + share * square[j]))
                # Nearer rates come first, so that equal pairs leave the nearest.
                if np.isfinite(rms) and (best is None or rms < best.rms * (1.0 - 1e-9)):
                    alone = float(np.interp(mean, curve.rates, curve.bound))
                    best = Pair(mean, low, high, share, curve.stepping, rms, alone)
    return best
