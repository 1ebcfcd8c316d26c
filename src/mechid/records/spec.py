"""Declaration of a record file in the campaign: channels and their columns, clock, and conditioning."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from mechid.errors import RecordError


class Role(StrEnum):
    """Role of a channel: output explained by the model, input that drives it, or side measurement."""

    OUTPUT = "output"
    INPUT = "input"
    SIDE = "side"
    """Force or moment other than the drive torque, as implied by its quantity."""


class TimeStamps(StrEnum):
    """Interpretation of the file's time stamps."""

    STRICT = "strict"
    """The stamps must be regular."""
    REGULAR = "regular"
    """The samples are regular, but stamped late or early: the nearest regular clock is used."""
    RESAMPLE = "resample"
    """The stamps are the true times of irregular samples: the channels are interpolated onto a regular clock."""


VOLTAGE = "voltage"
"""Quantity by whose units a channel in volts is converted, until the calibration makes a load of it."""


@dataclass(frozen=True, kw_only=True)
class ChannelSpec:
    """Declaration of a channel in the campaign.

    Parameters
    ----------
    quantity : str
        One of the keys of `mechid.units.SI_UNIT`.
    column : str or int
        Name of the column, with or without its unit, its path, or its index from 0.
    unit : str or None
        Unit of the file's numbers; None for the unit stated in the file, or SI if there is none.
    gain : float or None
        Factor for the converted values, such as a polarity or a calibration. None means 1, not stated.
    role : Role
        Output by default.
    held : bool
        Whether an input is held constant between samples rather than interpolated linearly.
    in_volts : bool
        Whether the numbers are voltages that the calibration of ``[bench]`` makes loads of.
    """

    quantity: str
    column: str | int
    unit: str | None = None
    gain: float | None = None
    role: Role = Role.OUTPUT
    held: bool = False
    in_volts: bool = False

    def to_dict(self) -> dict[str, Any]:
        """Return the declaration as JSON can hold it; a column without a name by its index."""
        column = str(self.column)
        return {
            "quantity": self.quantity,
            "column": column,
            "unit": self.unit,
            "gain": self.gain,
            "role": str(self.role),
        }


@dataclass(frozen=True, kw_only=True)
class Conditioning:
    """Conditioning of the samples, applied in the order of these entries.

    Parameters
    ----------
    time_stamps : TimeStamps
    limits : Mapping
        Range of the instrument in SI units, by quantity; samples at or beyond it are missing.
    max_gap_s : float or None
        Maximum duration of gaps (samples not finite, beyond the limits, or never stamped) that are bridged by a
        straight line; None rejects any gap.
    cumulate : tuple of str
        Quantities whose samples are increments, to be replaced by their running sum.
    quiet_s : Mapping
        Stretches of record time in which a quantity is known to be zero, by quantity. The mean of one stretch, or the
        straight line through several, is subtracted.
    window_s : (float, float) or None
        Record time to keep, both ends included; None for all.
    decimate : int
        Decimation factor, with an anti-alias filter.
    """

    time_stamps: TimeStamps = TimeStamps.STRICT
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    max_gap_s: float | None = None
    cumulate: tuple[str, ...] = ()
    quiet_s: Mapping[str, tuple[tuple[float, float], ...]] = field(default_factory=dict)
    window_s: tuple[float, float] | None = None
    decimate: int = 1

    def __post_init__(self) -> None:
        """Validate the window.

        Raises
        ------
        RecordError
            The window ends before it begins, or an end is not a number.
        """
        if self.window_s is not None and not self.window_s[0] < self.window_s[1]:
            raise RecordError(f"window_s: found {list(self.window_s)}; write two numbers, the second above the first")

    @property
    def needed_s(self) -> tuple[float, float] | None:
        """Record time to be read, which covers the window and the quiet stretches; None for all."""
        if self.window_s is None:
            return None
        stretches = [self.window_s, *(stretch for each in self.quiet_s.values() for stretch in each)]
        return min(start for start, _ in stretches), max(stop for _, stop in stretches)


@dataclass(frozen=True, kw_only=True)
class RecordSpec:
    """Declaration of a record in the campaign.

    Parameters
    ----------
    name : str
        Name of the record in the campaign.
    path : str
        File name in the campaign, also used in messages.
    sample_rate_hz : float or None
        Sample rate; None for that of the file.
    channels : tuple of ChannelSpec
        Channels. If empty, the torque is read from the second column, after the time, or from the first one if
        `sample_rate_hz` is given; in a file whose columns have no order, from the column of that name.
    time : ChannelSpec or None
        Time column, if it cannot be found by its name.
    external_files : tuple of str
        Other files from which numbers may be taken, as named in the file.
    conditioning : Conditioning
    """

    name: str
    path: str
    sample_rate_hz: float | None = None
    channels: tuple[ChannelSpec, ...] = ()
    time: ChannelSpec | None = None
    external_files: tuple[str, ...] = ()
    conditioning: Conditioning = field(default_factory=Conditioning)
