"""Leaps and retreats: two ways past a window that stalls gated growth.

Growth stalls where one window of a record is not followed. The data after that window could often be followed, and
would determine the values with which the window is followed as well: a leap excludes windows of misfit and counts the
data after them. In other cases the fault begins before the window that shows it: a retreat takes steps within shorter
horizons.
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
    """Fit with windows of misfit excluded and the data after them counted; None if the records are followed no further.

    Parameters
    ----------
    problem : Problem
    q : (n,)
        Point at which the growth has stalled.
    gates, least : mapping of record to int
        Samples followed at `q`, and least horizons.
    most : float
        Largest mean square residual of a window that is followed, in sigmas squared.
    """
    # A further fit is worth its time only while the net loss falls: samples excluded less samples gained.
    loss_before = math.inf
    for _ in range(SEARCH.leap_fits):
        ahead = {t.name: _extended_horizon(problem, t, q, gates[t.name], most) for t in problem.targets}
        horizons = {name: stop for name, (stop, _) in ahead.items()}
        net_loss = sum(out.size - (stop - gates[name]) for name, (stop, out) in ahead.items() if out.size)
        if sum(horizons.values()) < SEARCH.leap_gain * sum(gates.values()) or net_loss >= loss_before:
            return None
        loss_before = net_loss
        masked = replace(problem, targets=tuple(exclude_samples(t, ahead[t.name][1]) for t in problem.targets))
        windows = {name: (0, stop) for name, stop in horizons.items()}
        q = solve(masked, q, windows, steps=SEARCH.leap_steps, tolerance=SEARCH.leap_tolerance).q
        found = _followed_horizons(problem, q, least, most)
        if sum(found.values()) > sum(gates.values()):
            return q, found
    return None


def retreat(
    problem: Problem, q: FloatArray, gates: Horizons, least: Horizons, most: float
) -> tuple[FloatArray, Horizons] | None:
    """Fit with the samples just before the horizons excluded; None if the records are followed no further.

    Parameters as for `leap`.
    """
    for moved in _retreats(problem, q, gates, least):
        found = _followed_horizons(problem, moved, least, most)
        if sum(found.values()) > sum(gates.values()):
            return moved, found
    return None


def _retreats(problem: Problem, q: FloatArray, gates: Horizons, least: Horizons) -> Iterator[FloatArray]:
    whole = {t.name: t.samples for t in problem.targets}
    for share in SEARCH.retreats:
        windows = {name: (0, n if n == whole[name] else max(int(share * n), least[name])) for name, n in gates.items()}
        yield solve(problem, q, windows, steps=SEARCH.retreat_steps, tolerance=SEARCH.retreat_tolerance).q


def exclude_samples(target: Target, samples: IntArray) -> Target:
    """Return a target with some samples of its leading channel excluded."""
    if not samples.size:
        return target
    leading = replace(target.leading, rejected=np.union1d(target.leading.rejected, samples))
    return replace(target, channels=(leading, *target.channels[1:]))


def _followed_horizons(problem: Problem, q: FloatArray, least: Horizons, most: float) -> Horizons:
    return {t.name: max(followed_samples(problem, t, q, most=most), least[t.name]) for t in problem.targets}


def _extended_horizon(problem: Problem, target: Target, q: FloatArray, gate: int, most: float) -> tuple[int, IntArray]:
    """Return the extended horizon of a record whose windows of misfit are excluded, and the samples of these windows.

    The horizon extends to the last followed window before which at most the share `SEARCH.leap_lost` of the windows
    past the gate is lost.
    """
    none = np.zeros(0, dtype=np.int64)
    if gate == target.samples:
        return gate, none
    window = gate_window(target)
    stop = min(target.samples, gate + max((SEARCH.leap_horizons - 1) * gate, SEARCH.leap_windows * window))
    pieces = Misfit(problem.model, target.truncate(stop), q, (0, stop), block=SEARCH.short_block)
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
    lost = np.convolve(bad[:last], np.ones(3), "same") > 0.0  # one more window on either side
    samples = (np.flatnonzero(lost)[:, None] * window + np.arange(window)).ravel()
    return (stop if last == bad.size else last * window), samples.astype(np.int64)
