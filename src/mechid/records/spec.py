"""Declaration of a record file by the campaign: which column is which channel, the clock, the conditioning."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from mechid.errors import RecordError


class Role(StrEnum):
    """Whether a channel is explained by the model, drives it, or is measured beside it."""

    OUTPUT = "output"
    INPUT = "input"
    SIDE = "side"
    """A force or moment beside the drive torque; its quantity says so."""


class TimeStamps(StrEnum):
    """What the file's time stamps are taken for."""

    STRICT = "strict"
    """Regular as they are, or the record is refused."""
    REGULAR = "regular"
    """Those of regular samples, stamped late or early: the regular clock nearest to them holds."""
    RESAMPLE = "resample"
    """True times of irregular samples: the channels are interpolated onto a regular clock."""


@dataclass(frozen=True, kw_only=True)
class ChannelSpec:
    """One channel as the campaign asks for it.

    Parameters
    ----------
    quantity : str
        One of the keys of `mechid.units.SI_UNIT`.
    column : str or int
        The column's name, with or without its unit, its path, or its index from 0.
    unit : str or None
        Unit of the file's numbers; None leaves it to the file, and to SI where that has none.
    gain : float or None
        Multiplies the converted values: polarity, or a calibration. None is 1, and says that nobody stated it.
    role : Role
        Output by default.
    held : bool
        Of an input: it is held from sample to sample; else it runs straight between them.
    """

    quantity: str
    column: str | int
    unit: str | None = None
    gain: float | None = None
    role: Role = Role.OUTPUT
    held: bool = False


@dataclass(frozen=True, kw_only=True)
class Conditioning:
    """What is done to the samples before they count as measured, in the order of these entries.

    Parameters
    ----------
    time_stamps : TimeStamps
    limits : Mapping
        By quantity, the range of its instrument in SI units: a sample on or beyond it is missing.
    max_gap_s : float or None
        Missing samples (not finite, beyond the limits, never stamped) are bridged by a straight line
        where they last no longer than this; None refuses any.
    cumulate : tuple of str
        Quantities whose samples are increments since the sample before: their running sum takes their place.
    quiet_s : Mapping
        By quantity, stretches of record time at which it is known to be zero: the constant, or with
        two stretches or more the straight line, through all of them is subtracted.
    window_s : (float, float) or None
        Record time that is kept, both ends included; None keeps all.
    decimate : int
        Keeps every so manieth sample, behind an anti-alias filter.
    """

    time_stamps: TimeStamps = TimeStamps.STRICT
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    max_gap_s: float | None = None
    cumulate: tuple[str, ...] = ()
    quiet_s: Mapping[str, tuple[tuple[float, float], ...]] = field(default_factory=dict)
    window_s: tuple[float, float] | None = None
    decimate: int = 1

    def __post_init__(self) -> None:
        """Refuse a window that ends before it begins, or that is no number.

        Raises
        ------
        RecordError
        """
        if self.window_s is not None and not self.window_s[0] < self.window_s[1]:
            raise RecordError(f"window_s: found {list(self.window_s)}; write two numbers, the second above the first")

    @property
    def needed_s(self) -> tuple[float, float] | None:
        """Record time that has to be read: the window and the quiet stretches; None is all."""
        if self.window_s is None:
            return None
        stretches = [self.window_s, *(stretch for each in self.quiet_s.values() for stretch in each)]
        return min(start for start, _ in stretches), max(stop for _, stop in stretches)


@dataclass(frozen=True, kw_only=True)
class RecordSpec:
    """A record as the campaign asks for it.

    Parameters
    ----------
    name : str
        The record's name in the campaign.
    path : str
        The file as the campaign names it; messages say it so.
    sample_rate_hz : float or None
        None takes the rate from the file.
    channels : tuple of ChannelSpec
        Empty means torque: in the second column, after the time, or in the first where
        `sample_rate_hz` is given; in a file whose columns have no order, the one of that name.
    time : ChannelSpec or None
        The time column, where it is not to be found by its name.
    external_files : tuple of str
        Other files that its numbers may come from, by the names that stand in the file.
    conditioning : Conditioning
    """

    name: str
    path: str
    sample_rate_hz: float | None = None
    channels: tuple[ChannelSpec, ...] = ()
    time: ChannelSpec | None = None
    external_files: tuple[str, ...] = ()
    conditioning: Conditioning = field(default_factory=Conditioning)
