"""Figures of records before a fit: channels over time, bridged gaps, command and spectra."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial

import matplotlib as mpl
from matplotlib.figure import Figure

from mechid.analysis.commanded_rate import commanded_rate
from mechid.analysis.look import Drive, look_at
from mechid.campaign import CampaignRecord
from mechid.checks.numbers import has_one_rate
from mechid.command import MeasuredCommand
from mechid.ink.extremes import reduce_to_extremes
from mechid.ink.figures import STYLE, make_figure
from mechid.ink.palette import MEASURED, series
from mechid.ink.quantities import quantity_words
from mechid.ink.strips import Strip, draw_strips, rate_strip, strips_height
from mechid.looks.figures import look_figures
from mechid.records import Channel, Record, Role
from mechid.signal.runs import runs_of
from mechid.simulation.simulator import TimeBase
from mechid.units import unit_words

MOST_MARKED = 200
"""Most marked gaps."""


def check_figures(records: Iterable[CampaignRecord]) -> Iterator[tuple[str, Figure]]:
    """Yield named figures of each record: its channels over time, then over frequency.

    Spectra show the lines expected from the command. If the rate varies, they are drawn over time or rate.
    """
    for record in records:
        if record.data is not None:
            yield record.name, _over_time(record, record.data)
            look = look_at(record.data, Drive(command=record.command, time_offset_s=record.time_offset.value))
            kinds = ("spectrum",) if has_one_rate(record, record.data) else ("spectrum", "waterfall")
            yield from look_figures([look], kinds)


def _over_time(record: CampaignRecord, data: Record) -> Figure:
    """Draw the channels in strips, with inputs in another colour, and the commanded rate last."""
    base, ends = _base(data), (data.time_start_s, data.time_start_s + data.duration_s)
    strips = [_strip(channel, base) for channel in data.channels]
    if not isinstance(record.command, MeasuredCommand):
        strips.append(rate_strip(commanded_rate(record.command.rate, record.time_offset.value, base), ends))
    with mpl.rc_context(STYLE):
        draw = partial(draw_strips, f"{record.name} ({record.use})", strips, ends)
        return make_figure(draw, strips_height(len(strips)))


def _base(data: Record) -> TimeBase:
    return TimeBase(data.sample_rate_hz, data.samples, data.time_start_s)


def _strip(channel: Channel, base: TimeBase) -> Strip:
    is_input = channel.role is Role.INPUT
    # Half a sample on either side gives a single bridged sample a width.
    bridged = [
        (base.start_s + (first - 0.5) / base.sample_rate_hz, base.start_s + (stop - 0.5) / base.sample_rate_hz)
        for first, stop in runs_of(channel.bridged)[:MOST_MARKED]
    ]
    label = f"{quantity_words(channel.quantity)}{' (input)' if is_input else ''},\n{unit_words(channel.quantity)}"
    return Strip(label, reduce_to_extremes(channel.data, base), series(0) if is_input else MEASURED, bridged)
