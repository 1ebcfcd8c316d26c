"""Forces and moments of a six-component table, and their transfer to the mechanism's mounting point.

A table measures a force F and a moment M_O about its reference point O. The moment about the mounting point P, at r
from O, is M_P = M_O - r x F; the force is the same. The torque about the drive axis is one of the three moments and is
transferred like them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.records.record import Channel, Record
from mechid.signal.stored_series import map_samples

AXES = ("x", "y", "z")
FORCES = tuple(f"force_{axis}" for axis in AXES)
MOMENTS = tuple(f"moment_{axis}" for axis in AXES)
COMPONENTS = (*FORCES, *MOMENTS)
TORQUE = "torque"


@dataclass(frozen=True)
class Mounting:
    """Position and orientation of the mechanism on the table.

    Parameters
    ----------
    drive_axis : str
        Axis of the table about which a positive drive torque acts: ``"x"``, ``"y"``, ``"z"``, or ``"-x"`` and so on.
    point_m : (float, float, float)
        Vector from the table's reference point to the mechanism's mounting point, along the table's axes, in m.
    """

    drive_axis: str
    point_m: tuple[float, float, float]

    @property
    def axis(self) -> int:
        """Index of the drive axis, 0 to 2."""
        return AXES.index(self.drive_axis[-1])

    @property
    def sense(self) -> float:
        """Sign of the drive torque about the axis, 1 or -1."""
        return -1.0 if self.drive_axis.startswith("-") else 1.0

    @property
    def drive_moment(self) -> str:
        """Moment about the drive axis."""
        return MOMENTS[self.axis]

    def component(self, quantity: str) -> tuple[int, float] | None:
        """Return the component of the table that a channel measures, 0 to 5, and its sign; None if it is none.

        Examples
        --------
        >>> Mounting("-z", (0.0, 0.0, 0.0)).component("torque")
        (5, -1.0)
        """
        if quantity == TORQUE:
            return 3 + self.axis, self.sense
        return (COMPONENTS.index(quantity), 1.0) if quantity in COMPONENTS else None

    def lever(self, axis: int) -> dict[str, float]:
        """Return the lever arms in m, by force, of the component of r x F about an axis; zero arms are omitted."""
        after, last = (axis + 1) % 3, (axis + 2) % 3
        factors = {FORCES[last]: self.point_m[after], FORCES[after]: -self.point_m[last]}
        return {force: factor for force, factor in factors.items() if factor}

    def levers(self, quantities: tuple[str, ...]) -> Iterator[tuple[str, Mapping[str, float]]]:
        """Yield each moment among a record's quantities, including the torque, with its lever arms by force."""
        for quantity in quantities:
            if quantity == TORQUE:
                yield quantity, {force: self.sense * factor for force, factor in self.lever(self.axis).items()}
            elif quantity in MOMENTS:
                yield quantity, self.lever(MOMENTS.index(quantity))


def move_to_mounting_point(record: Record, mounting: Mounting) -> Record:
    """Return a record with its moments, including the torque, about the mounting point.

    A record without force and moment channels is returned unchanged. The forces that a moment needs must be present.
    """
    held = {channel.quantity: channel for channel in record.channels}
    if not set(COMPONENTS) & set(held):
        return record
    moved = {
        quantity: _move_moment(held[quantity], [(factor, held[force]) for force, factor in forces.items()])
        for quantity, forces in mounting.levers(tuple(held))
        if forces
    }
    if not moved:
        return record
    treatment = {
        "step": "moved",
        "text": f"{', '.join(moved)} moved to the mounting point, at {list(mounting.point_m)} m",
        "point_m": list(mounting.point_m),
    }
    channels = tuple(moved.get(channel.quantity, channel) for channel in record.channels)
    return replace(record, channels=channels, treatments=(*record.treatments, treatment))


def _move_moment(moment: Channel, forces: list[tuple[float, Channel]]) -> Channel:
    """Return a moment minus the moments of forces, given as lever arms and channels."""
    # A sample is measured only if the moment and all forces are: bridged samples of any of them count as bridged.
    bridged = moment.bridged
    for _, force in forces:
        bridged = np.union1d(bridged, force.bridged)

    def subtract_forces(values: FloatArray, part: slice) -> FloatArray:
        for factor, force in forces:
            values = values - factor * force.data[part]
        return values

    return replace(moment, data=map_samples(moment.data, subtract_forces), bridged=bridged)
