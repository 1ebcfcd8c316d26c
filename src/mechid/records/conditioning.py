"""Conditioning of samples as declared by the campaign; each step is documented in the treatments."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.records.columns import Layout
from mechid.records.spec import Conditioning
from mechid.records.table import Clock, Table, column_label
from mechid.signal.decimation import PASS, affected_samples, anti_alias_filter, decimate
from mechid.signal.runs import runs_of
from mechid.signal.series import Series
from mechid.signal.stored_series import (
    WritableSeries,
    change_in_place,
    pieces_of,
    samples_at,
    stretch_in_place,
    write_at,
)

Treatment = Mapping[str, Any]
"""Description of a conditioning step: ``step``, ``text``, and its figures."""
MAX_LISTED_GAPS = 8
LARGEST_INDEX = 2.0**62
"""Limit of sample indices: no file has as many samples, and it fits into an integer."""
EDGE_TOLERANCE = 1e-6
"""Tolerance of a window's ends in sample intervals."""


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples of a record during conditioning.

    Parameters
    ----------
    clock : Clock
    data : tuple of WritableSeries
        N samples of each channel of the layout, in SI units: arrays, or temporary files for long series.
    treatments : tuple of Treatment
    bridged : mapping of int to ndarray of int
        Indices of bridged samples, ascending, by position in `data`.
    """

    clock: Clock
    data: tuple[WritableSeries, ...]
    treatments: tuple[Treatment, ...] = ()
    bridged: Mapping[int, IntArray] = field(default_factory=dict)

    def slice_between(self, start_s: float, stop_s: float) -> slice:
        """Return the slice of samples from `start_s` to `stop_s` of record time, both included."""
        places = ((t - self.clock.start_s) * self.clock.rate_hz for t in (start_s, stop_s))
        # Clipped before the conversion, because infinite times do not fit into an integer.
        first, last = (min(max(place, -LARGEST_INDEX), LARGEST_INDEX) for place in places)
        return slice(max(math.ceil(first - EDGE_TOLERANCE), 0), max(math.floor(last + EDGE_TOLERANCE) + 1, 0))

    def with_treatment(self, step: str, text: str, data: tuple[WritableSeries, ...], **figures: object) -> Samples:
        """Return a copy with new data and an additional treatment."""
        return replace(self, data=data, treatments=(*self.treatments, {"step": step, "text": text, **figures}))


Step = Callable[[Table, Layout, Conditioning, Samples], Samples]


def condition(table: Table, layout: Layout, how: Conditioning, samples: Samples) -> Samples:
    """Apply all conditioning steps to samples on a regular clock.

    Raises
    ------
    RecordError
        A gap is too long, or a step cannot be applied.
    """
    # The order matters: gaps are bridged before sums and filters would spread NaN, and the quiet stretches may lie
    # outside the window, so it is applied after them.
    steps: tuple[Step, ...] = (
        _cut_to_needed,
        _bridge_gaps,
        _cumulate,
        _subtract_quiet_line,
        _apply_window,
        _decimate_channels,
    )
    for step in steps:
        samples = step(table, layout, how, samples)
    return samples


def apply_limits(layout: Layout, how: Conditioning, data: Sequence[WritableSeries]) -> list[Treatment]:
    """Mark samples at or beyond their instrument's limits as missing, in place, and return the treatments."""
    treatments: list[Treatment] = []
    for column, values in zip(layout.channels, data, strict=True):
        if column.quantity not in how.limits:
            continue
        low, high = how.limits[column.quantity]
        count = sum(_mark_missing(values, part, low, high) for part in pieces_of(values))
        text = f"{column.quantity}: {count} samples on or beyond {low:.9g} or {high:.9g} counted as missing"
        treatments.append(
            {"step": "limits", "text": text, "channel": column.quantity, "limits": [low, high], "samples": count}
        )
    return treatments


def _mark_missing(room: WritableSeries, part: slice, low: float, high: float) -> int:
    """Mark the samples of a piece at or beyond limits as missing, and return their number."""
    values = room[part]
    beyond = (values <= low) | (values >= high)
    values[beyond] = np.nan
    room[part] = values
    return int(np.count_nonzero(beyond))


def _cut_to_needed(table: Table, layout: Layout, how: Conditioning, samples: Samples) -> Samples:
    """Drop samples outside the window and the quiet stretches, whose faults do not matter."""
    return samples if how.needed_s is None else _cut(table, samples, *how.needed_s)


def _cut(table: Table, samples: Samples, start_s: float, stop_s: float) -> Samples:
    rows = samples.slice_between(start_s, stop_s)
    data = tuple(stretch_in_place(values, rows.start, rows.stop) for values in samples.data)
    if data[0].size < 2:
        whole = samples.clock.start_s + (samples.data[0].size - 1) / samples.clock.rate_hz
        raise table.error(
            f"no samples from {start_s:.9g} s to {stop_s:.9g} s; it goes from {samples.clock.start_s:.9g} s "
            f"to {whole:.9g} s"
        )
    start = samples.clock.start_s + rows.start / samples.clock.rate_hz
    inside = {
        k: missing[(missing >= rows.start) & (missing < rows.stop)] - rows.start
        for k, missing in samples.bridged.items()
    }
    return replace(samples, clock=replace(samples.clock, start_s=start), data=data, bridged=inside)


def missing_samples(series: Series) -> IntArray:
    """Return the indices of samples that are not finite, ascending."""
    found = [part.start + np.flatnonzero(~np.isfinite(series[part])) for part in pieces_of(series)]
    return np.concatenate([np.zeros(0, dtype=np.int64), *found])


def missing_runs(missing: IntArray) -> IntArray:
    """Return the start and stop indices of each run of missing samples, shape (runs, 2)."""
    return np.array(runs_of(missing), dtype=np.int64).reshape(-1, 2)


def bridge(room: WritableSeries, missing: IntArray) -> None:
    """Replace missing samples, (M,) ascending, in place by linear interpolation between their neighbours.

    At the ends of the series the value of the only neighbour is used.
    """
    runs = missing_runs(missing)
    # Only the samples next to the gaps are read, so that a long series need not be in memory.
    beside = np.unique(np.concatenate((runs[:, 0] - 1, runs[:, 1])))
    beside = beside[(beside >= 0) & (beside < room.size)]
    write_at(room, missing, np.interp(missing, beside, samples_at(room, beside)))


def _bridge_gaps(table: Table, layout: Layout, how: Conditioning, samples: Samples) -> Samples:
    """Bridge missing samples; raise RecordError for gaps that are too long or at an end."""
    for k, (column, values) in enumerate(zip(layout.channels, samples.data, strict=True)):
        missing = missing_samples(values)
        if not missing.size:
            continue
        runs = missing_runs(missing)
        label = column_label(table.columns, column.index)
        lengths = (runs[:, 1] - runs[:, 0]) / samples.clock.rate_hz
        starts = samples.clock.start_s + runs[:, 0] / samples.clock.rate_hz
        longest = int(np.argmax(lengths))
        where = f"{label}: {int(runs[longest, 1] - runs[longest, 0])} samples missing from {starts[longest]:.9g} s on"
        if how.max_gap_s is None:
            raise table.error(f"{where}; max_gap_s = ... allows to bridge them, window_s to leave them out")
        if lengths[longest] > how.max_gap_s * (1.0 + EDGE_TOLERANCE):
            raise table.error(
                f"{where}, {lengths[longest]:.4g} s, longer than max_gap_s = {how.max_gap_s:.9g}; leave them out "
                "with window_s"
            )
        if runs[0, 0] == 0 or runs[-1, 1] == values.size:
            raise table.error(f"{label}: begins or ends with missing samples; leave them out with window_s")
        bridge(values, missing)
        count = int(np.sum(runs[:, 1] - runs[:, 0]))
        text = (
            f"{column.quantity}: {count} missing samples in {len(runs)} gaps bridged by straight lines, the longest "
            f"{lengths[longest]:.4g} s from {starts[longest]:.9g} s"
        )
        samples = samples.with_treatment(
            "gaps",
            text,
            samples.data,
            channel=column.quantity,
            samples=count,
            gaps=len(runs),
            longest_s=float(lengths[longest]),
            first_at_s=[float(start) for start in starts[:MAX_LISTED_GAPS]],
        )
        samples = replace(samples, bridged={**samples.bridged, k: missing})
    return samples


def _cumulate(table: Table, layout: Layout, how: Conditioning, samples: Samples) -> Samples:
    """Replace increments by their running sum; an encoder's counter that is cleared at each sample gives increments."""
    for column, values in zip(layout.channels, samples.data, strict=True):
        if column.quantity in how.cumulate:
            _sum_up(values)
            text = f"{column.quantity}: increments summed up from {samples.clock.start_s:.9g} s on"
            samples = samples.with_treatment(
                "cumulate", text, samples.data, channel=column.quantity, from_s=samples.clock.start_s
            )
    return samples


def _sum_up(room: WritableSeries) -> None:
    """Replace samples by their running sum, in place."""
    # The sum so far is added to the first sample of the next piece: the order of additions, and so the rounding, is
    # that of a single cumulative sum.
    so_far = 0.0
    for part in pieces_of(room):
        values = room[part]
        if part.start:
            values[0] += so_far
        room[part] = np.cumsum(values)
        so_far = float(room[part.stop - 1 : part.stop][0])


def _subtract_quiet_line(table: Table, layout: Layout, how: Conditioning, samples: Samples) -> Samples:
    """Subtract the straight line fitted to the quiet stretches, or the mean of a single stretch."""
    for column, values in zip(layout.channels, samples.data, strict=True):
        stretches = how.quiet_s.get(column.quantity, ())
        if not stretches:
            continue
        parts = [samples.slice_between(*stretch) for stretch in stretches]
        time = np.concatenate([np.arange(*part.indices(values.size)) for part in parts]) / samples.clock.rate_hz
        quiet = np.concatenate([values[part] for part in parts])
        if any(values[part].size < 2 for part in parts):
            raise table.error(f"{column.quantity}: a stretch of quiet_s lies outside the record")
        drift, offset = np.polyfit(time, quiet, 1) if len(parts) > 1 else (0.0, float(quiet.mean()))
        change_in_place(values, partial(_subtract_line, offset, drift, samples.clock.rate_hz))
        # Measured after the subtraction: the RMS that remains is noise.
        rms = _quiet_rms(np.concatenate([values[part] for part in parts]), how.decimate)
        at = f"{samples.clock.start_s:.9g} s"
        text = f"{column.quantity}: offset {offset:.6g} at {at} and drift {drift:.6g} /s subtracted, {rms:.3g} RMS left"
        samples = samples.with_treatment(
            "quiet",
            text,
            samples.data,
            channel=column.quantity,
            stretches_s=[list(stretch) for stretch in stretches],
            offset=float(offset),
            drift=float(drift),
            at_s=samples.clock.start_s,
            quiet_samples=int(quiet.size),
            rms=rms,
        )
    return samples


def _subtract_line(offset: float, drift: float, rate_hz: float, values: FloatArray, part: slice) -> FloatArray:
    """Return samples minus a line over the time since the first sample of the record."""
    return values - (offset + drift * np.arange(part.start, part.stop) / rate_hz)


def _quiet_rms(quiet: FloatArray, factor: int) -> float:
    """Return the RMS of quiet samples, after decimation if there are enough samples for the filter."""
    if factor > 1 and quiet.size > anti_alias_filter(factor).size:
        quiet = decimate(quiet, factor)[:]
    return float(np.sqrt(np.mean(quiet**2)))


def _apply_window(table: Table, layout: Layout, how: Conditioning, samples: Samples) -> Samples:
    if how.window_s is None:
        return samples
    cut = _cut(table, samples, *how.window_s)
    text = f"{how.window_s[0]:.9g} s to {how.window_s[1]:.9g} s of the record used"
    return cut.with_treatment("window", text, cut.data, window_s=list(how.window_s))


def _decimate_channels(table: Table, layout: Layout, how: Conditioning, samples: Samples) -> Samples:
    """Decimate all channels with the same filter, which keeps them aligned in time."""
    if how.decimate == 1:
        return samples
    taps = anti_alias_filter(how.decimate).size
    if samples.data[0].size <= taps:
        raise table.error(f"{samples.data[0].size} samples are too few to decimate by {how.decimate}")
    rate, before = samples.clock.rate_hz / how.decimate, samples.clock.rate_hz
    data = tuple(decimate(values, how.decimate) for values in samples.data)
    passed = 0.5 * PASS * rate
    text = (
        f"decimated by {how.decimate} from {before:.9g} Hz to {rate:.9g} Hz: low-pass of {taps} taps, flat to "
        f"{passed:.6g} Hz; what the mechanism does above is in the model and no longer in the record"
    )
    bridged = {
        k: affected_samples(missing, samples.data[k].size, how.decimate) for k, missing in samples.bridged.items()
    }
    done = samples.with_treatment("decimate", text, data, factor=how.decimate, taps=taps, pass_hz=passed, rate_hz=rate)
    return replace(done, clock=replace(samples.clock, rate_hz=rate), bridged=bridged)
