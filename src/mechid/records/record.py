"""Record: channels sampled on one regular clock, in SI units, with their provenance."""

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
"""Cache of the noise floors of channels, by sample rate."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Channel:
    """Measured quantity of a record.

    Parameters
    ----------
    quantity : str
        One of the keys of `mechid.units.SI_UNIT`.
    unit : str
        The SI unit of `data`, e.g. ``"N*m"``.
    data : Series of N samples
        In `unit`, float64, finite, with conversion and gain applied. It is a contiguous array, or a series that is
        read piece by piece if it is long; ``data[:]`` reads all of it into memory.
    role : Role
        Output or input.
    column : str
        Name of the source column in the file.
    metadata : Mapping
        Metadata of the column in the file, such as serial number and sensitivity.
    scale : float
        Factor by which the file's numbers were multiplied.
    bridged : ndarray of int, shape (M,)
        Indices, ascending, of samples that replace missing ones and are not measured.
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
    """Record of one test run.

    Parameters
    ----------
    name : str
        Name of the record in the campaign.
    path : Path
        Source file.
    digest : str
        SHA-256 digest of the source file in hexadecimal notation.
    time_start_s : float
        Record time of the first sample; 0 if the file has no time column.
    sample_rate_hz : float
        Samples per second.
    channels : tuple of Channel
        Channels of equal length, in the order of the campaign.
    warnings : tuple of str
        Warnings about the file, one line each.
    start_time : str or None
        Date and time of the first sample of the file, ISO 8601, if the file states it.
    metadata : Mapping
        Further metadata of the file.
    treatments : tuple of Mapping
        Conditioning steps in order, each with ``step``, ``text``, and its figures.
    reading_s : float
        Reading time in s.
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
        """Source and conditioning of the samples, in plain types.

        Metadata of the file's other arrays, whose keys are paths, are omitted.
        """
        return {
            "file": self.path.name,
            "sha256": self.digest,
            "start_time": self.start_time,
            "metadata": {key: value for key, value in self.metadata.items() if "/" not in key},
            "channels": {c.quantity: {"column": c.column, "metadata": dict(c.metadata)} for c in self.channels},
            "conditioning": [dict(treatment) for treatment in self.treatments],
            "sample_rate_hz": self.sample_rate_hz,
            "duration_s": self.duration_s,
        }

    @property
    def samples(self) -> int:
        """Number of samples N of every channel."""
        return int(self.channels[0].data.size)

    @property
    def sample_interval_s(self) -> float:
        """Sample interval in s."""
        return 1.0 / self.sample_rate_hz

    @property
    def duration_s(self) -> float:
        """Time from the first to the last sample in s."""
        return (self.samples - 1) / self.sample_rate_hz

    @property
    def outputs(self) -> tuple[Channel, ...]:
        """Channels that the model must explain."""
        return tuple(channel for channel in self.channels if channel.role is Role.OUTPUT)

    @property
    def inputs(self) -> tuple[Channel, ...]:
        """Channels that drive the model."""
        return tuple(channel for channel in self.channels if channel.role is Role.INPUT)

    def channel(self, quantity: str) -> Channel:
        """Return the channel of `quantity`; raise RecordError if the record has none."""
        found = {channel.quantity: channel for channel in self.channels}
        if quantity not in found:
            near = did_you_mean(quantity, found) or "; it has " + ", ".join(found)
            raise RecordError(f'{self.name}: no channel "{quantity}"{near}')
        return found[quantity]

    def to_pandas(self) -> pd.DataFrame:
        """Return the channels in SI units as a DataFrame indexed by time in s (needs the extra ``dataframes``)."""
        import pandas as pd

        return pd.DataFrame({c.quantity: c.data[:] for c in self.channels}, index=pd.Index(self.time_s, name="time_s"))

    def to_xarray(self) -> xr.Dataset:
        """Return the channels as a Dataset over time in s with the attribute ``units`` (extra ``dataframes``)."""
        import xarray as xr

        channels = {c.quantity: ("time_s", c.data[:], {"units": c.unit}) for c in self.channels}
        return xr.Dataset(channels, coords={"time_s": self.time_s})

    @property
    def time_s(self) -> FloatArray:
        """Record time of each sample, (N,) s."""
        return self.time_start_s + np.arange(self.samples) / self.sample_rate_hz

    def plot(self, quantity: str | None = None, *, ax: Axes | None = None) -> Axes:
        """Plot a channel, by default the first one, over time and return the axes; without `ax`, new axes are created.

        Raises
        ------
        UsageError
            There is no such channel.
        """
        # Imported here so that reading records does not load the plotting code.
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
        """Return the broadband RMS of a channel in its quiet stretches, in SI units; None if none are declared."""
        found = [t["rms"] for t in self.treatments if t["step"] == "quiet" and t["channel"] == quantity]
        return float(found[0]) if found else None

    def noise_floor(self, quantity: str) -> float:
        """Return the standard deviation of a channel's white noise floor in SI units, without bridged samples."""
        channel = self.channel(quantity)
        # Cached because many callers need it and each evaluation takes ten milliseconds.
        known = _FLOORS.setdefault(channel, {})
        if self.sample_rate_hz not in known:
            known[self.sample_rate_hz] = noise_floor(channel.data, self.sample_rate_hz, rejected=channel.bridged)
        return known[self.sample_rate_hz]

    def blocks(self, size: int) -> Iterator[tuple[int, int]]:
        """Yield (start, stop) of consecutive blocks of at most `size` samples."""
        for start in range(0, self.samples, size):
            yield start, min(start + size, self.samples)
