"""Calibration of a six-component table: loads as a matrix times the channels, in volts or in newtons.

With the channels v in the order of the components and the matrix C, the loads along the table's axes about its
reference point are F = C v. Off its diagonal C takes out the cross-talk between the components.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from mechid.arrays import FloatArray
from mechid.errors import RecordError
from mechid.records.components import COMPONENTS, Mounting
from mechid.records.record import Channel, Record
from mechid.signal.series import Series
from mechid.signal.stored_series import map_samples
from mechid.units import si_unit


@dataclass(frozen=True, kw_only=True, eq=False)
class Calibration:
    """Calibration matrix of a table.

    Parameters
    ----------
    matrix : ndarray, shape (6, 6)
        Loads (N, then N m) per channel (V, or N and N m), both in the order of `COMPONENTS`.
    in_volts : bool
        Whether the channels are voltages.
    uncertainty : float
        Standard error of its elements, relative to the sensitivities.
    source : str
        File or entry that it comes from, for messages.
    file : Path or None
    """

    matrix: FloatArray
    in_volts: bool
    uncertainty: float
    source: str
    file: Path | None = None

    def missing_components(self, quantities: tuple[str, ...], mounting: Mounting) -> tuple[str, ...]:
        """Return the components that channels of these quantities need for their loads, and that are not among them."""
        held = {at[0] for quantity in quantities if (at := mounting.component(quantity))}
        needed = {k for row in held for k in np.flatnonzero(self.matrix[row])}
        return tuple(COMPONENTS[k] for k in sorted(needed - held))


def calibrate(record: Record, calibration: Calibration, mounting: Mounting) -> Record:
    """Return a record whose forces and moments, including the torque, are calibrated loads in N and N m.

    Raises
    ------
    RecordError
        The loads need a component that was not recorded.
    """
    held = {at[0]: (channel, at[1]) for channel in record.channels if (at := mounting.component(channel.quantity))}
    if missing := calibration.missing_components(tuple(channel.quantity for channel in record.channels), mounting):
        raise RecordError(
            f'record "{record.name}": has no {", ".join(missing)}, which the calibration of [bench] needs for '
            f"{', '.join(channel.quantity for channel, _ in held.values())}; add the channels"
        )
    channels = {
        row: combine_channels(
            channel,
            [
                (sign * float(calibration.matrix[row, k]) * held[k][1], held[k][0])
                for k in map(int, np.flatnonzero(calibration.matrix[row]))
            ],
        )
        for row, (channel, sign) in held.items()
    }
    treatment = {
        "step": "calibrated",
        "text": f"{', '.join(one.quantity for one in channels.values())} calibrated by {calibration.source}",
    }
    rows = {channel.quantity: row for row, (channel, _) in held.items()}
    return replace(
        record,
        channels=tuple(channels[rows[one.quantity]] if one.quantity in rows else one for one in record.channels),
        treatments=(*record.treatments, treatment),
    )


def combine_channels(channel: Channel, parts: list[tuple[float, Channel]]) -> Channel:
    """Return a channel with the sum of others, given as factors and channels, in its own SI unit."""
    bridged = channel.bridged
    for _, other in parts:
        # A sample is measured only if it is in all channels that the load is made of.
        bridged = np.union1d(bridged, other.bridged)
    data = map_samples(channel.data, partial(_sum_parts, [(factor, other.data) for factor, other in parts]))
    return replace(channel, data=data, unit=si_unit(channel.quantity), bridged=bridged)


def _sum_parts(parts: list[tuple[float, Series]], values: FloatArray, part: slice) -> FloatArray:
    total = np.zeros(values.size)
    for factor, series in parts:
        total += factor * series[part]
    return total
