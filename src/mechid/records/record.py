"""A record: channels sampled on one regular clock, in SI, with where they came from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.errors import RecordError, did_you_mean
from mechid.records.spec import Role
from mechid.signal.noise import noise_floor
from mechid.signal.series import Series, no_samples

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes

_FLOORS: WeakKeyDictionary[Channel, dict[float, float]] = WeakKeyDictionary()
"""Floors of channels by their sample rate."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Channel:
    """One measured quantity.

    Parameters
    ----------
    quantity : str
        One of the keys of `mechid.units.SI_UNIT`.
    unit : str
        The SI unit of `data`, e.g. ``"N*m"``.
    data : Series of N samples
        In `unit`, float64, finite; conversion and gain are applied. An array, contiguous, or where it is long a series
        that is read piece by piece; ``data[:]`` is all of it in memory.
    role : Role
        Output or input.
    column : str
        The column it was read from, as its header names it.
    metadata : Mapping
        What the file says of it: serial number, sensitivity, ...
    scale : float
        What the file's numbers were multiplied by.
    bridged : ndarray of int, shape (M,)
        The samples, ascending, that stand for missing ones: no measurement.
    """

    quantity: str
    unit: str
    data: Series
    role: Role
    column: str
    metadata: Mapping[str, Any] = field(default_factory=dict)
    scale: float = 1.0
    bridged: IntArray = field(default_factory=no_samples)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Record:
    """One test run.

    Parameters
    ----------
    name : str
        The record's name in the campaign.
    path : Path
        The file it was read from.
    digest : str
        SHA-256 of that file, hexadecimal.
    time_start_s : float
        Record time of the first sample, 0 where the file has no time column.
    sample_rate_hz : float
        Samples per second.
    channels : tuple of Channel
        All of the same length, in the order of the campaign.
    warnings : tuple of str
        What is odd about the file and yet usable, one line each.
    start_time : str or None
        Date and time of the first sample of the file, ISO 8601, where the file tells.
    metadata : Mapping
        What else the file says of itself.
    treatments : tuple of Mapping
        What conditioning did to the samples, in order: ``step``, ``text``, and its figures.
    reading_s : float
        How long it took to read, s.
    """

    name: str
    path: Path
    digest: str
    time_start_s: float
    sample_rate_hz: float
    channels: tuple[Channel, ...]
    warnings: tuple[str, ...] = ()
    start_time: str | None = None
    metadata: Mapping[str, Any] = field(default_factory=dict)
    treatments: tuple[Mapping[str, Any], ...] = ()
    reading_s: float = 0.0

    @property
    def provenance(self) -> dict[str, Any]:
        """Where the samples come from and what was done to them, of plain types.

        Metadata of the file's other arrays, whose keys are paths, are left out.
        """
        return {
            "file": self.path.name,
            "sha256": self.digest,
            "start_time": self.start_time,
            "metadata": {key: value for key, value in self.metadata.items() if "/" not in key},
            "channels": {c.quantity: {"column": c.column, "metadata": dict(c.metadata)} for c in self.channels},
            "conditioning": [dict(treatment) for treatment in self.treatments],
        }

    @property
    def samples(self) -> int:
        """Number of samples N of every channel."""
        return int(self.channels[0].data.size)

    @property
    def sample_interval_s(self) -> float:
        """Seconds from one sample to the next."""
        return 1.0 / self.sample_rate_hz

    @property
    def duration_s(self) -> float:
        """Seconds from the first sample to the last."""
        return (self.samples - 1) / self.sample_rate_hz

    @property
    def outputs(self) -> tuple[Channel, ...]:
        """The channels that the model has to explain."""
        return tuple(channel for channel in self.channels if channel.role is Role.OUTPUT)

    @property
    def inputs(self) -> tuple[Channel, ...]:
        """The channels that drive the model."""
        return tuple(channel for channel in self.channels if channel.role is Role.INPUT)

    def channel(self, quantity: str) -> Channel:
        """Return the channel of `quantity`; RecordError where the record has none."""
        found = {channel.quantity: channel for channel in self.channels}
        if quantity not in found:
            near = did_you_mean(quantity, found) or "; it has " + ", ".join(found)
            raise RecordError(f'{self.name}: no channel "{quantity}"{near}')
        return found[quantity]

    def to_pandas(self) -> pd.DataFrame:
        """Return the channels by quantity, SI, as a DataFrame indexed by time in s (needs the extra ``dataframes``)."""
        import pandas as pd

        return pd.DataFrame({c.quantity: c.data[:] for c in self.channels}, index=pd.Index(self.time_s, name="time_s"))

    def to_xarray(self) -> xr.Dataset:
        """Return the channels by quantity as a Dataset over time in s, ``units`` among the attributes (likewise)."""
        import xarray as xr

        channels = {c.quantity: ("time_s", c.data[:], {"units": c.unit}) for c in self.channels}
        return xr.Dataset(channels, coords={"time_s": self.time_s})

    @property
    def time_s(self) -> FloatArray:
        """Record time of each sample, (N,) s."""
        return self.time_start_s + np.arange(self.samples) / self.sample_rate_hz

    def plot(self, quantity: str | None = None, *, ax: Axes | None = None) -> Axes:
        """Draw a channel over time, the first where none is named; return the axes, new ones without `ax`.

        Raises
        ------
        UsageError
            There is no such channel.
        """
        from mechid.ink.axes import Clock, axes_or_new, draw_over_time, one_of
        from mechid.ink.palette import MEASURED

        channel = self.channel(one_of(quantity, (c.quantity for c in self.channels), "channel"))
        axes, clock = axes_or_new(ax), Clock(self.sample_rate_hz, self.time_start_s)
        style: dict[str, Any] = {"color": MEASURED, "linewidth": 0.8, "label": "measured"}
        draw_over_time(axes, channel.data, clock, channel.quantity, **style)
        axes.set_title(self.name, loc="left")
        return axes

    def __repr__(self) -> str:
        names = ", ".join(channel.quantity for channel in self.channels)
        return f"<Record {self.name}: {names}; {self.samples} samples at {self.sample_rate_hz:.9g} Hz>"

    def quiet_rms(self, quantity: str) -> float | None:
        """Return the RMS of a channel in its quiet stretches, SI, with all colour; None where none are declared."""
        found = [t["rms"] for t in self.treatments if t["step"] == "quiet" and t["channel"] == quantity]
        return float(found[0]) if found else None

    def noise_floor(self, quantity: str) -> float:
        """Return the standard deviation of a channel's noise at its high-frequency floor, SI, beside bridged samples.

        It is worked out once: many ask, and each time takes ten milliseconds.
        """
        channel = self.channel(quantity)
        known = _FLOORS.setdefault(channel, {})
        if self.sample_rate_hz not in known:
            known[self.sample_rate_hz] = noise_floor(channel.data, self.sample_rate_hz, rejected=channel.bridged)
        return known[self.sample_rate_hz]

    def blocks(self, size: int) -> Iterator[tuple[int, int]]:
        """Yield (start, stop) of consecutive blocks of at most `size` samples."""
        for start in range(0, self.samples, size):
            yield start, min(start + size, self.samples)
