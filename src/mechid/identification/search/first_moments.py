"""The first moments of a record, over which bad starts are told from good ones: a robust cost over 60 ms."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mechid.identification.output_error.misfit import Window, misfit_series_of
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target

FloatArray = NDArray[np.float64]
WINDOW_S = 0.06
ROBUST_SIGMAS = 20.0


def first_window(target: Target) -> Window:
    """Return the first window that counts."""
    return target.burn_in, min(target.samples, target.burn_in + round(WINDOW_S * target.base.sample_rate_hz))


def first_samples(target: Target) -> int:
    """Return how many samples the first window has."""
    first, stop = first_window(target)
    return stop - first


def first_residual(problem: Problem, target: Target, q: FloatArray) -> FloatArray:
    """Return the residuals of a target's channels over the first window, in sigmas, without their medians."""
    return first_residuals(problem, target, [q])[0]


def first_residuals(problem: Problem, target: Target, points: Sequence[FloatArray]) -> list[FloatArray]:
    """Return the same at several points."""
    window = first_window(target)
    found = []
    for rooms in misfit_series_of(problem.model, target, points, window):
        series = [r[:] for r in rooms]
        for channel, r in zip(target.channels, series, strict=True):
            np.divide(r, channel.sigma, out=r)
            if channel.linear:
                np.subtract(r, np.median(r), out=r)
            r[channel.rejected_within(window)] = 0.0
        found.append(series[0] if len(series) == 1 else np.concatenate(series))
    return found


def robust_cost(residual: FloatArray) -> float:
    """Return the soft-L1 cost at `ROBUST_SIGMAS`; inf where the simulation failed."""
    if not np.all(np.isfinite(residual)):
        return math.inf
    square = (residual / ROBUST_SIGMAS) ** 2
    return float(2.0 * ROBUST_SIGMAS**2 * np.sum(square / (1.0 + np.sqrt(1.0 + square))))
