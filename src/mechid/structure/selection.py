"""Selection of the degrees of freedom of a file that form the interface and the line of sight."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from mechid.errors import InputFileError

DIRECTIONS = ("tx", "ty", "tz", "rx", "ry", "rz")
"""Translations and rotations, in the order of Nastran's components and of UFF's direction codes 1 to 6."""
ROTATIONS = DIRECTIONS[3:]


@dataclass(frozen=True)
class Location:
    """Degree of freedom of a file: node, direction, and weighting factor.

    The factor of a rotation is dimensionless; that of a translation is in rad/m.
    """

    node: int
    direction: str
    factor: float = 1.0

    @property
    def component(self) -> int:
        """Component number from 1 to 6 as in Nastran."""
        return DIRECTIONS.index(self.direction) + 1


@dataclass(frozen=True, kw_only=True)
class Selection:
    """Selection from a file whose degrees of freedom are numbered rather than named.

    Parameters
    ----------
    interface : Location or None
        Node at which the mechanism is mounted, and the mechanism's axis.
    line_of_sight : mapping of name to locations
        Each line of sight is the weighted sum of the motions of its locations.
    damping : float or None
        Ratio of critical damping, used if the file has none.
    length_unit_m, mass_unit_kg : float
        Units of the file in SI units: 1e-3 and 1e3 for millimetre and tonne.
    highest_hz : float or None
        Modes above this frequency contribute their static flexibility only.
    directions : mapping of direction to str
        Column names for further directions at the interface; not needed for files with numbered nodes.
    """

    interface: Location | None = None
    line_of_sight: Mapping[str, tuple[Location, ...]] = field(default_factory=dict)
    damping: float | None = None
    length_unit_m: float = 1.0
    mass_unit_kg: float = 1.0
    highest_hz: float | None = None
    directions: Mapping[str, str] = field(default_factory=dict)

    def refuse_directions(self, label: str, why: str) -> None:
        """Raise InputFileError, with the reason `why`, if columns are named in a selection that must not have any."""
        if self.directions:
            raise InputFileError(f"{label}: directions: {why}; leave it out")

    def required_interface(self, label: str) -> Location:
        """Return the interface; raise InputFileError if there is none or it is not a rotation."""
        if self.interface is None:
            raise InputFileError(f'{label}: its nodes are numbered; give interface = {{ node = 3, direction = "rz" }}')
        if self.interface.direction not in ROTATIONS:
            found = self.interface.direction
            raise InputFileError(f'{label}: interface direction "{found}" is not a rotation; write "rx", "ry" or "rz"')
        return self.interface

    def required_line_of_sight(self, label: str) -> Mapping[str, tuple[Location, ...]]:
        """Return the lines of sight; raise InputFileError if there is none."""
        if not self.line_of_sight:
            raise InputFileError(
                f'{label}: give line_of_sight = [{{ name = "x", node = 1, direction = "rx" }}], one or more'
            )
        return self.line_of_sight
