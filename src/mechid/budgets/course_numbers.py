"""Profile results as plain data: windowed RMS over time with 95 % intervals, extremes of the line of sight."""

from __future__ import annotations

from typing import Any

import numpy as np

from mechid.budgets.budget import Budget
from mechid.budgets.mode_budget import ModeBudget
from mechid.budgets.profile_run import ProfileResponse
from mechid.budgets.settings import LEVEL
from mechid.budgets.shares import deviations


def course_of(budget: Budget, made: ModeBudget, course: ProfileResponse) -> dict[str, Any]:
    """Return the results of a profile: windowed RMS over time with its intervals, and extremes of the line of sight."""
    windowed = course.windowed_rms()
    peak = int(windowed.max(axis=1).argmax())
    time = course.window_times_s
    rates = np.interp(time, made.mode.command.rate.times_s, made.mode.command.rate.rates)
    # The first columns are the estimated parameters; those of the ensemble are spread, not uncertain.
    n = len(budget.estimate.names)
    by = np.zeros((LEVEL.samples, course.columns))
    rng = np.random.default_rng(budget.file.seed)
    by[:, :n] = deviations(budget.estimate.covariance, LEVEL.samples, rng)
    # The model discrepancy scales a whole draw: the lines of a profile cannot be told apart.
    draws = course.windowed_draws(by) * (
        1.0 + budget.estimate.discrepancy.overall * rng.normal(size=(LEVEL.samples, 1, 1))
    )
    two_way = made.two_way_course.rms().tolist() if made.two_way_course else None
    return {
        "duration_s": made.mode.duration_s,
        "rms_window_s": course.window_s,
        "worst_time_s": float(time[peak]),
        "worst_rate": float(rates[peak]),
        "torque_rms_Nm": float(course.windowed_torque_rms().max()),
        "line_of_sight_rms_rad": windowed.max(axis=0).tolist(),
        "line_of_sight_rms_two_way_rad": two_way,
        "windowed": {
            "time_s": time.tolist(),
            "rate": rates.tolist(),
            "torque_rms_Nm": course.windowed_torque_rms().tolist(),
            "rms_rad": windowed.T.tolist(),
            "rms_ci95_rad": np.moveaxis(np.quantile(draws, (0.025, 0.975), axis=0), 0, -1).swapaxes(0, 1).tolist(),
            "rms_two_way_rad": made.two_way_course.windowed_rms().T.tolist() if made.two_way_course else None,
        },
        "course": _extremes(course),
    }


def _extremes(course: ProfileResponse) -> dict[str, Any]:
    # Two values, least and largest, are kept for each stretch: no peak is lost between the points of a figure.
    stretches = min(LEVEL.course_samples // 2, len(course.series))
    edges = np.linspace(0, len(course.series), stretches + 1).astype(np.int64)[:-1]
    return {
        "time_s": (edges / course.series_rate_hz).tolist(),
        "least_rad": np.minimum.reduceat(course.series, edges, axis=0).T.tolist(),
        "largest_rad": np.maximum.reduceat(course.series, edges, axis=0).T.tolist(),
    }
