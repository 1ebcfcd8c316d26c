"""Two ways past a window that stalls a growth: over it, as if it were not there, or from a little before it.

A growth stalls where one window of a record is not followed. Often what lies behind it would be, and tells the values
by which the window is followed as well: a leap leaves the windows of misfit out and counts what is behind them. Or the
fault began before the window that shows it: a retreat steps within shorter horizons.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.identification.output_error.misfit import Misfit
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.search.first_moments import Horizons
from mechid.identification.search.horizons import followed_samples, gate_window
from mechid.identification.search.settings import SEARCH
from mechid.identification.search.solve import solve


def leap(
    problem: Problem, q: FloatArray, gates: Horizons, least: Horizons, most: float
) -> tuple[FloatArray, Horizons] | None:
    """Return where steps lead that leave windows of misfit out and count what is behind them.

    None where that follows the records no further.

    Parameters
    ----------
    problem : Problem
    q : (n,)
        Where the growth has stalled.
    gates, least : mapping of record to int
        Samples followed there, and the fewest that count.
    most : float
        Mean square residual of a window that is still followed, in sigmas squared.
    """
    lost_before = math.inf
    for _ in range(SEARCH.leap_fits):
        ahead = {t.name: _ahead(problem, t, q, gates[t.name], most) for t in problem.targets}
        horizons = {name: stop for name, (stop, _) in ahead.items()}
        lost = sum(out.size - (stop - gates[name]) for name, (stop, out) in ahead.items() if out.size)
        if sum(horizons.values()) < SEARCH.leap_gain * sum(gates.values()) or lost >= lost_before:
            return None
        lost_before = lost
        masked = replace(problem, targets=tuple(without_samples(t, ahead[t.name][1]) for t in problem.targets))
        windows = {name: (0, stop) for name, stop in horizons.items()}
        q = solve(masked, q, windows, steps=SEARCH.leap_steps, tolerance=SEARCH.leap_tolerance).q
        found = _followed(problem, q, least, most)
        if sum(found.values()) > sum(gates.values()):
            return q, found
    return None


def retreat(
    problem: Problem, q: FloatArray, gates: Horizons, least: Horizons, most: float
) -> tuple[FloatArray, Horizons] | None:
    """Return where steps lead that do not count what is just before the horizons; None where no further.

    Parameters as of `leap`.
    """
    for moved in _retreats(problem, q, gates, least):
        found = _followed(problem, moved, least, most)
        if sum(found.values()) > sum(gates.values()):
            return moved, found
    return None


def _retreats(problem: Problem, q: FloatArray, gates: Horizons, least: Horizons) -> Iterator[FloatArray]:
    whole = {t.name: t.samples for t in problem.targets}
    for share in SEARCH.retreats:
        windows = {name: (0, n if n == whole[name] else max(int(share * n), least[name])) for name, n in gates.items()}
        yield solve(problem, q, windows, steps=SEARCH.retreat_steps, tolerance=SEARCH.retreat_tolerance).q


def without_samples(target: Target, samples: IntArray) -> Target:
    """Return a target of whose leading channel some samples do not count."""
    if not samples.size:
        return target
    leading = replace(target.leading, rejected=np.union1d(target.leading.rejected, samples))
    return replace(target, channels=(leading, *target.channels[1:]))


def _followed(problem: Problem, q: FloatArray, least: Horizons, most: float) -> Horizons:
    return {t.name: max(followed_samples(problem, t, q, most=most), least[t.name]) for t in problem.targets}


def _ahead(problem: Problem, target: Target, q: FloatArray, gate: int, most: float) -> tuple[int, IntArray]:
    """Return how far a record may count with its windows of misfit left out, and the samples of these.

    Up to the last window that is followed while no more than `SEARCH.leap_lost` of those behind the horizon are not.
    """
    none = np.zeros(0, dtype=np.int64)
    if gate == target.samples:
        return gate, none
    window = gate_window(target)
    stop = min(target.samples, gate + max((SEARCH.leap_horizons - 1) * gate, SEARCH.leap_windows * window))
    pieces = Misfit(problem.model, target.beginning(stop), q, (0, stop), block=SEARCH.short_block)
    r = np.concatenate([piece.residual(0) for piece in pieces]) / target.leading.sigma
    if not np.all(np.isfinite(r)):
        return gate, none
    r = r - np.median(r[: max(gate, SEARCH.leap_offset * window)])
    r[target.leading.rejected_within((0, stop))] = 0.0
    bad = np.mean(r[: r.size // window * window].reshape(-1, window) ** 2, axis=1) > most
    first = gate // window
    share = np.cumsum(bad[first:]) / np.arange(1, bad.size - first + 1)
    followed = np.flatnonzero((share <= SEARCH.leap_lost) & ~bad[first:])
    if not followed.size:
        return gate, none
    last = first + int(followed[-1]) + 1
    lost = np.convolve(bad[:last], np.ones(3), "same") > 0.0  # with the window to either side
    samples = (np.flatnonzero(lost)[:, None] * window + np.arange(window)).ravel()
    return (stop if last == bad.size else last * window), samples.astype(np.int64)
