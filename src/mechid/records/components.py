"""Forces and moments that a table measures beside the drive torque, and their move to the mechanism's mounting point.

A table gives a force F and a moment M_O about its own reference point O. About the mounting point P, at r from O, the
moment is M_P = M_O - r x F; the force is the same. The torque about the drive axis is one of the three moments, so it
is moved like them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.records.record import Channel, Record
from mechid.signal.stored import map_samples

AXES = ("x", "y", "z")
FORCES = tuple(f"force_{axis}" for axis in AXES)
MOMENTS = tuple(f"moment_{axis}" for axis in AXES)
COMPONENTS = (*FORCES, *MOMENTS)
TORQUE = "torque"


@dataclass(frozen=True)
class Mounting:
    """How the mechanism stands on the table that measures it.

    Parameters
    ----------
    drive_axis : str
        The table's axis about which a positive drive torque turns: ``"x"``, ``"y"``, ``"z"``, or ``"-x"`` and so on.
    point_m : (float, float, float)
        From the table's reference point to the mechanism's mounting point, along the table's axes, m.
    """

    drive_axis: str
    point_m: tuple[float, float, float]

    @property
    def axis(self) -> int:
        """Number of the drive axis, 0 to 2."""
        return AXES.index(self.drive_axis[-1])

    @property
    def sense(self) -> float:
        """1 where a positive drive torque turns about the axis itself, -1 where it turns about its opposite."""
        return -1.0 if self.drive_axis.startswith("-") else 1.0

    @property
    def drive_moment(self) -> str:
        """The moment that is the drive torque."""
        return MOMENTS[self.axis]

    def lever(self, axis: int) -> dict[str, float]:
        """Return by which forces and factors, m, r x F turns about an axis; none where the lever arm is zero."""
        after, last = (axis + 1) % 3, (axis + 2) % 3
        factors = {FORCES[last]: self.point_m[after], FORCES[after]: -self.point_m[last]}
        return {force: factor for force, factor in factors.items() if factor}

    def levers(self, quantities: tuple[str, ...]) -> Iterator[tuple[str, Mapping[str, float]]]:
        """Yield each moment among a record's quantities, the torque too, with the forces that move it."""
        for quantity in quantities:
            if quantity == TORQUE:
                yield quantity, {force: self.sense * factor for force, factor in self.lever(self.axis).items()}
            elif quantity in MOMENTS:
                yield quantity, self.lever(MOMENTS.index(quantity))


def move_to_mounting_point(record: Record, mounting: Mounting) -> Record:
    """Return a record with its moments, the torque among them, about the mounting point; others as they are.

    A record without any component beside the torque stays as it is. The forces that a moment needs have to be there.
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
    """Return a moment less what each force adds to it by its part of the lever arm."""
    bridged = moment.bridged
    for _, force in forces:
        bridged = np.union1d(bridged, force.bridged)

    def subtract_forces(values: FloatArray, part: slice) -> FloatArray:
        for factor, force in forces:
            values = values - factor * force.data[part]
        return values

    return replace(moment, data=map_samples(moment.data, subtract_forces), bridged=bridged)
