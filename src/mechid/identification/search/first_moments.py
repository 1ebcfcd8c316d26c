"""The first moments of a record, over which bad starts are told from good ones: a robust cost over 60 ms."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.output_error.misfit import Window, misfit_series_of
from mechid.identification.output_error.model import Model
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target

WINDOW_S = 0.06
"""Of each record, in which starts are judged: 100 of 100 random mechanisms were found with it (make recovery)."""
ROBUST_SIGMAS = 20.0
"""At which the soft loss bends: with it 100 of 100 were found (make recovery); not varied."""


def first_window(target: Target) -> Window:
    """Return the first window that counts."""
    return target.burn_in, min(target.samples, target.burn_in + round(WINDOW_S * target.base.sample_rate_hz))


def first_samples(target: Target) -> int:
    """Return how many samples the first window has."""
    first, stop = first_window(target)
    return stop - first


def first_residual(problem: Problem, target: Target, q: FloatArray) -> FloatArray:
    """Return the residuals of a target's channels over the first window, in sigmas, without their medians."""
    return np.asarray(first_residuals(problem.model, target, [q])[0])


def first_residuals(model: Model, target: Target, points: Sequence[FloatArray]) -> FloatArray:
    """Return the same at several points, one at least: a row each."""
    window = first_window(target)
    rooms = misfit_series_of(model, target, points, window)
    each = []
    for channel, series in zip(target.channels, zip(*rooms, strict=True), strict=True):
        rows = np.stack([room[:] for room in series])
        rows /= channel.sigma
        if channel.linear:
            rows -= np.median(rows, axis=1, keepdims=True)
        rows[:, channel.rejected_within(window)] = 0.0
        each.append(rows)
    return each[0] if len(each) == 1 else np.concatenate(each, axis=1)


def robust_cost(residual: FloatArray) -> float:
    """Return the soft-L1 cost at `ROBUST_SIGMAS`; inf where the simulation failed."""
    return float(robust_costs(residual[np.newaxis])[0])


def robust_costs(residuals: FloatArray) -> FloatArray:
    """Return that of each row."""
    with np.errstate(over="ignore", invalid="ignore"):  # what grew beyond all numbers failed too
        square = (residuals / ROBUST_SIGMAS) ** 2
        costs = 2.0 * ROBUST_SIGMAS**2 * np.sum(square / (1.0 + np.sqrt(1.0 + square)), axis=1)
    return np.where(np.isfinite(costs), costs, math.inf)
