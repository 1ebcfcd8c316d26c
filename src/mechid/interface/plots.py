"""Results drawn with Matplotlib, onto axes that are given or new ones, in the report's colours."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mechid.analysis.prediction import predict
from mechid.budgets.budget import Budget
from mechid.errors import UsageError, did_you_mean
from mechid.identification.result.fit import Fit
from mechid.ink.extremes import drawn
from mechid.ink.palette import LIMIT, MEASURED, MODELLED, RESIDUAL, SERIES, series
from mechid.ink.quantities import TIME, quantity_words
from mechid.records.record import Record
from mechid.simulation.simulator import TimeBase
from mechid.simulation.trajectory import Trajectory
from mechid.units import unit_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from mechid.budgets.mode_budget import ModeBudget

FULL_STEPS = "rate, full steps/s"


def plot_trajectory(run: Trajectory, quantity: str | None, ax: Axes | None) -> Axes:
    """Draw a simulated quantity over time; its extremes where there are more samples than a picture has columns."""
    quantity = _one_of(quantity, run.values, "quantity")
    axes, step_s = _axes(ax), float(run.time[1:2][0] - run.time[:1][0]) if run.time.size > 1 else 1.0
    base = TimeBase(1.0 / step_s, run.time.size, float(run.time[:1][0]))
    axes.plot(*drawn(run.values[quantity], base), color=MODELLED, linewidth=0.8, label="modelled")
    return _labelled(axes, TIME, quantity)


def plot_record(record: Record, quantity: str | None, ax: Axes | None) -> Axes:
    """Draw a measured channel over time; its extremes where there are more samples than a picture has columns."""
    channel = record.channel(_one_of(quantity, [c.quantity for c in record.channels], "channel"))
    base, axes = TimeBase(record.sample_rate_hz, record.samples, record.time_start_s), _axes(ax)
    axes.plot(*drawn(channel.data, base), color=MEASURED, linewidth=0.8, label="measured")
    axes.set_title(record.name, loc="left")
    return _labelled(axes, TIME, channel.quantity)


def plot_fit(fit: Fit, record: str | None, quantity: str | None, ax: Axes | None) -> Axes:
    """Draw what was measured of a record, offset and drift removed, what the fit says of it, and what is left."""
    campaign = fit.required_campaign
    name = _one_of(record, {r.name: r for r in campaign.records if r.data is not None}, "record")
    found = predict(campaign.record(name), fit)
    quantity = _one_of(quantity, found, "quantity")
    one, axes = found[quantity], _axes(ax)
    axes.plot(*drawn(one.level, one.base), color=MEASURED, linewidth=1.6, label="measured")
    axes.plot(*drawn(one.modelled, one.base), color=MODELLED, linewidth=0.8, label="modelled")
    axes.plot(*drawn(one.residual, one.base), color=RESIDUAL, linewidth=0.6, label="residual")
    axes.legend(loc="upper right", ncols=3)
    axes.set_title(name, loc="left")
    return _labelled(axes, TIME, quantity)


def plot_budget(made: Budget, mode: str | None, ax: Axes | None) -> Axes:
    """Draw each requirement's level over its limit, with its 95 % interval, as decides; of a mode its line of sight."""
    if mode is not None:
        modes = {one.mode.name: one for one in made.modes}
        return _plot_mode(modes[_one_of(mode, modes, "mode")], _axes(ax))
    axes, rows = _axes(ax), made.to_dict()["requirements"]
    decided = [row["decided"] for row in rows]
    share = 1.0 - np.array([[*reversed(one["margin95"]), one["margin"]] for one in decided])
    places = np.arange(len(rows))
    axes.hlines(places, share[:, 0], share[:, 1], color=series(0), linewidth=2.0, label="95 % interval")
    axes.plot(share[:, 2], places, "o", color=series(0), label="level")
    axes.axvline(1.0, color=LIMIT, linewidth=1.2, label="limit")
    axes.set_yticks(places, [f"{row['requirement']}\n{row['mode']}" for row in rows])
    axes.invert_yaxis()
    axes.set_xlabel("level over limit")
    axes.legend(loc="best")
    return axes


def _plot_mode(made: ModeBudget, axes: Axes) -> Axes:
    """Draw the RMS of the line of sight over the rate, or over time of a profile."""
    if made.course is not None:
        times, levels, over = made.course.window_times_s, made.course.windowed(), TIME
        names = made.course.axes
    else:
        times, levels, over = made.mode.rates, np.array([r.rms() for r in made.responses]), FULL_STEPS
        names = made.responses[0].axes
    axes.set_prop_cycle(color=SERIES)
    for name, level in zip(names, levels.T, strict=True):
        axes.plot(times, level, marker="." if len(times) < 40 else "", linewidth=0.8, label=name)
    if made.course is None and made.two_way:
        axes.set_prop_cycle(color=SERIES)
        for name, level in zip(names, np.array([r.rms() for r in made.two_way]).T, strict=True):
            axes.plot(times, level, "--", linewidth=0.8, label=f"{name}, two-way")
    axes.set_xlabel(over)
    axes.set_ylabel("line of sight, RMS, rad")
    axes.set_title(made.mode.name, loc="left")
    axes.legend(loc="best")
    return axes


def _axes(ax: Axes | None) -> Axes:
    if ax is not None:
        return ax
    from matplotlib import pyplot

    return pyplot.subplots(figsize=(6.9, 3.2), layout="constrained")[1]


def _labelled(axes: Axes, over: str, quantity: str) -> Axes:
    axes.set_xlabel(over)
    axes.set_ylabel(f"{quantity_words(quantity)}, {unit_words(quantity)}")
    return axes


def _one_of(name: str | None, known: Any, what: str) -> str:
    """Return the first that is known where none is named; refuse another name with the nearest that is known."""
    if name is None:
        return str(next(iter(known)))
    if name not in known:
        near = did_you_mean(name, known) or "; there are " + ", ".join(known)
        raise UsageError(f'plot: no {what} "{name}"{near}')
    return name
