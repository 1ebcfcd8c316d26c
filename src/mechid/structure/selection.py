"""Which of a file's degrees of freedom are the interface and the line of sight."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from mechid.errors import InputFileError

DIRECTIONS = ("tx", "ty", "tz", "rx", "ry", "rz")
"""Translations and rotations, in the order of Nastran's components and UFF's direction codes 1 to 6."""
ROTATIONS = DIRECTIONS[3:]


@dataclass(frozen=True)
class Location:
    """A degree of freedom of a file: a node and a direction, with the factor by which it counts.

    The factor of a rotation has no unit; that of a translation is in rad/m.
    """

    node: int
    direction: str
    factor: float = 1.0

    @property
    def component(self) -> int:
        """1 to 6, as Nastran counts."""
        return DIRECTIONS.index(self.direction) + 1


@dataclass(frozen=True, kw_only=True)
class Selection:
    """What to take of a file whose degrees of freedom have numbers instead of names.

    Parameters
    ----------
    interface : Location or None
        Where the mechanism stands, and its axis.
    line_of_sight : mapping of name to locations
        Each line of sight is the sum of its locations' motions by their factors.
    damping : float or None
        Share of critical, where the file has none.
    length_unit_m, mass_unit_kg : float
        The file's units in SI: 1e-3 and 1e3 for millimetre and tonne.
    highest_hz : float or None
        Modes above are kept only as static flexibility.
    directions : mapping of direction to str
        Names of a file's columns for further directions at the interface; files that number nodes need none.
    """

    interface: Location | None = None
    line_of_sight: Mapping[str, tuple[Location, ...]] = field(default_factory=dict)
    damping: float | None = None
    length_unit_m: float = 1.0
    mass_unit_kg: float = 1.0
    highest_hz: float | None = None
    directions: Mapping[str, str] = field(default_factory=dict)

    def refuse_directions(self, label: str, why: str) -> None:
        """Raise InputFileError where columns are named for directions of a file that needs none; `why` says so."""
        if self.directions:
            raise InputFileError(f"{label}: directions: {why}; leave it out")

    def required_interface(self, label: str) -> Location:
        """Return the interface; InputFileError where there is none or it is no rotation."""
        if self.interface is None:
            raise InputFileError(
                f'{label}: give interface = {{ node = 3, direction = "rz" }}: it names nodes by number'
            )
        if self.interface.direction not in ROTATIONS:
            found = self.interface.direction
            raise InputFileError(f'{label}: interface direction "{found}"; a torque turns: write "rx", "ry" or "rz"')
        return self.interface

    def required_line_of_sight(self, label: str) -> Mapping[str, tuple[Location, ...]]:
        """Return the lines of sight; InputFileError where there is none."""
        if not self.line_of_sight:
            raise InputFileError(
                f'{label}: give line_of_sight = [{{ name = "x", node = 1, direction = "rx" }}], one or more'
            )
        return self.line_of_sight
