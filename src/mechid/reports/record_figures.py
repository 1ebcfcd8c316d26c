"""A picture of each record before any fit: its channels over time, what was bridged, and its command."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from mechid.analysis.look import Drive, look_at
from mechid.campaign import Campaign, CampaignRecord
from mechid.command import MeasuredCommand
from mechid.ink.extremes import drawn
from mechid.ink.figures import STYLE, made, over_time, write_figures
from mechid.ink.palette import MEASURED, ORDER, series
from mechid.ink.quantities import TIME, quantity_words
from mechid.looks.figures import look_figures
from mechid.records import Channel, Record, Role
from mechid.reports.curves import rate_over
from mechid.signal.runs import runs_of
from mechid.simulation.simulator import TimeBase
from mechid.units import unit_words
from mechid.writing import writable

LEFT_SHARE = 0.14
CHANNEL_IN = 1.3
"""Height of a channel, inches."""
MOST_MARKED = 200
"""Gaps that are marked."""
RATE = "rate,\nfull steps/s"


def write_record_figures(campaign: Campaign, folder: Path | str) -> list[Path]:
    """Write a picture of each record that was read and its spectra, as SVG and PNG, by the record's name.

    Parameters
    ----------
    campaign : Campaign
        With its records read.
    folder : Path
        Made with its parents where it is missing.

    Returns
    -------
    list of Path
        The SVG files.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    figures = record_figures(campaign.records)
    with writable(folder):
        write_figures(figures.items(), Path(folder))
        spectra = write_figures(_spectra(campaign.records), Path(folder))
    return [Path(folder) / f"{name}.svg" for name in (*figures, *spectra)]


def _spectra(records: Iterable[CampaignRecord]) -> Iterator[tuple[str, Figure]]:
    """Yield the spectrum of each channel that was read beside the lines that the command would make.

    Where the rate varies they are drawn over time or rate.
    """
    for record in records:
        if record.data is not None:
            look = look_at(record.data, Drive(command=record.command, time_offset_s=record.time_offset.value))
            yield from look_figures([look], ("spectrum",) if look.constant_rate else ("spectrum", "waterfall"))


def record_figures(records: Iterable[CampaignRecord]) -> dict[str, Figure]:
    """Return the picture of each record that was read, by name."""
    with mpl.rc_context(STYLE):
        return {
            r.name: made(partial(_draw, r, r.data), CHANNEL_IN * _rows(r, r.data) + 0.7)
            for r in records
            if r.data is not None
        }


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
        rate = rate_over(record, base)
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
