"""A picture of each record before any fit: its channels over time, what was bridged, and its command."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from mechid.analysis.commanded_rate import commanded_rate
from mechid.analysis.look import Drive, look_at
from mechid.campaign import CampaignRecord
from mechid.checks.numbers import has_one_rate
from mechid.command import MeasuredCommand
from mechid.ink.extremes import drawn
from mechid.ink.figures import STYLE, made, over_time
from mechid.ink.palette import MEASURED, ORDER, series
from mechid.ink.quantities import TIME, quantity_words
from mechid.looks.figures import look_figures
from mechid.records import Channel, Record, Role
from mechid.signal.runs import runs_of
from mechid.simulation.simulator import TimeBase
from mechid.units import unit_words

LEFT_SHARE = 0.14
CHANNEL_IN = 1.3
"""Height of a channel, inches."""
MOST_MARKED = 200
"""Gaps that are marked."""
RATE = "rate,\nfull steps/s"


def check_figures(records: Iterable[CampaignRecord]) -> Iterator[tuple[str, Figure]]:
    """Yield the picture of each record that was read, then its channels over frequency, with their names.

    The spectrum of a channel stands beside the lines that the command would make; where the rate varies they are drawn
    over time or rate.
    """
    for record in records:
        if record.data is not None:
            with mpl.rc_context(STYLE):
                draw = partial(_draw, record, record.data)
                yield record.name, made(draw, CHANNEL_IN * _rows(record, record.data) + 0.7)
            look = look_at(record.data, Drive(command=record.command, time_offset_s=record.time_offset.value))
            kinds = ("spectrum",) if has_one_rate(record, record.data) else ("spectrum", "waterfall")
            yield from look_figures([look], kinds)


def _rows(record: CampaignRecord, data: Record) -> int:
    return len(data.channels) + (not isinstance(record.command, MeasuredCommand))


def _draw(record: CampaignRecord, data: Record, figure: Any) -> None:
    """Draw the channels below one another, inputs in another colour, and the commanded rate last."""
    figure.subplots_adjust(left=LEFT_SHARE)
    base = TimeBase(data.sample_rate_hz, data.samples, data.time_start_s)
    axes = figure.subplots(_rows(record, data), 1, sharex=True, squeeze=False, gridspec_kw={"hspace": 0.12})[:, 0]
    for ax, channel in zip(axes, data.channels, strict=False):
        _draw_channel(ax, channel, base)
    if len(axes) > len(data.channels):
        rate = commanded_rate(record.command.rate, record.time_offset.value, base)
        ends = [base.start_s, base.start_s + data.duration_s]
        times = rate[:, 0] if len(rate) > 1 else ends
        axes[-1].plot(times, rate[:, 1] if len(rate) > 1 else [rate[0, 1]] * 2, color=series(1), linewidth=1.0)
        axes[-1].set_ylabel(RATE)
    axes[0].set_title(f"{record.name} ({record.use})", fontsize=8.0, loc="left")
    axes[-1].set_xlabel(TIME)
    axes[-1].set_xlim(base.start_s, base.start_s + data.duration_s)
    figure.align_ylabels(axes)


def _draw_channel(axes: Any, channel: Channel, base: TimeBase) -> None:
    is_input = channel.role is Role.INPUT
    over_time(axes, drawn(channel.data, base), series(0) if is_input else MEASURED, 0.7, channel.quantity)
    for first, stop in runs_of(channel.bridged)[:MOST_MARKED]:
        span = [base.start_s + (k - 0.5) / base.sample_rate_hz for k in (first, stop)]
        axes.axvspan(*span, color=ORDER, alpha=0.4, linewidth=0.0)
    words = f"{quantity_words(channel.quantity)}{' (input)' if is_input else ''}"
    axes.set_ylabel(f"{words},\n{unit_words(channel.quantity)}")
