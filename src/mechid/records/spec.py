"""What the campaign says of a record's file: which column is which channel, and the sample rate."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Role(StrEnum):
    """Whether a channel is explained by the model or drives it."""

    OUTPUT = "output"
    INPUT = "input"


@dataclass(frozen=True, kw_only=True)
class ChannelSpec:
    """One channel as the campaign asks for it.

    Parameters
    ----------
    quantity : str
        One of the keys of `mechid.units.SI_UNIT`, time excepted.
    column : str or int
        The column's header, with or without its unit, or its index from 0.
    unit : str or None
        Unit of the file's numbers; None leaves it to the header, and to SI where that has none.
    gain : float
        Multiplies the converted values: polarity, or a calibration.
    role : Role
        Output by default.
    """

    quantity: str
    column: str | int
    unit: str | None = None
    gain: float = 1.0
    role: Role = Role.OUTPUT


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
        None takes the rate from the time column.
    channels : tuple of ChannelSpec
        Empty means torque: in the second column, after the time, or in the first where
        `sample_rate_hz` is given.
    """

    name: str
    path: str
    sample_rate_hz: float | None = None
    channels: tuple[ChannelSpec, ...] = ()
