"""Figures of simulated records: quantities over time, and the command."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import matplotlib as mpl
from matplotlib.figure import Figure

from mechid.analysis.commanded_rate import commanded_rate
from mechid.campaign import CampaignRecord
from mechid.command import MeasuredCommand
from mechid.ink.extremes import reduce_to_extremes
from mechid.ink.figures import STYLE, make_figure
from mechid.ink.palette import MODELLED
from mechid.ink.quantities import quantity_words
from mechid.ink.strips import Strip, draw_strips, rate_strip, strips_height
from mechid.simulation.simulator import TimeBase
from mechid.simulation.trajectory import Trajectory
from mechid.simulations.numbers import figure_name
from mechid.simulations.run import Simulated
from mechid.units import unit_words


def simulation_figures(found: Simulated) -> Iterator[tuple[str, Figure]]:
    """Yield a named figure of each record."""
    records = {record.name: record for record in found.campaign.records} if found.campaign else {}
    for name, run in found.trajectories.items():
        yield figure_name(name), _over_time(name, run, records.get(name))


def _over_time(name: str, run: Trajectory, record: CampaignRecord | None) -> Figure:
    base = _base(run)
    ends = (base.start_s, base.start_s + base.duration_s)
    strips = [
        Strip(f"{quantity_words(quantity)},\n{unit_words(quantity)}", reduce_to_extremes(values, base), MODELLED)
        for quantity, values in run.values.items()
    ]
    if record is not None and not isinstance(record.command, MeasuredCommand):
        strips.append(rate_strip(commanded_rate(record.command.rate, record.time_offset.value, base), ends))
    with mpl.rc_context(STYLE):
        return make_figure(partial(draw_strips, name, strips, ends), strips_height(len(strips)))


def _base(run: Trajectory) -> TimeBase:
    first, last = float(run.time[:1][0]), float(run.time[-1:][0])
    samples = run.time.size
    # A single sample defines no interval; any rate draws it.
    return TimeBase((samples - 1) / (last - first) if samples > 1 else 1.0, samples, first)
