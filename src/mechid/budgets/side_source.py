"""Other force and moment components measured on the bench, and their transfer to the structure."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mechid.analysis.components_file import SideRecord, SideRecords
from mechid.arrays import ComplexArray, FloatArray
from mechid.budgets.settings import RESIDUALS
from mechid.budgets.side_here import SideHere, interpolate_at_rate, pool_by_rate
from mechid.command import Command
from mechid.errors import InputFileError
from mechid.records.components import AXES, COMPONENTS, FORCES
from mechid.structure import Structure

FRAME = "frame = { x = [1, 0, 0], y = [0, 1, 0], z = [0, 0, 1] }"


@dataclass(frozen=True, eq=False)
class SideSource:
    """Forces and moments of the bench, and the structure on which they act.

    Parameters
    ----------
    measured : SideRecords
    frame : (3, 3)
        Columns are the bench's axes in the structure's frame.
    structure : Structure

    Raises
    ------
    InputFileError
        In that frame the bench's drive axis is not the structure's axis.
    """

    measured: SideRecords
    frame: FloatArray
    structure: Structure

    def __post_init__(self) -> None:
        mounting, axis = self.measured.mounting, self.structure.axis
        if not self.structure.directions:
            return
        found = self._drive
        if np.abs(np.abs(found) - np.eye(3)[AXES.index(axis[-1])]).max() > RESIDUALS.along:
            where = ", ".join(f"{cosine:.4g}" for cosine in found)
            raise InputFileError(
                f"the bench's drive axis {mounting.drive_axis} points along [{where}] of the "
                f"structure, where the torque acts about {axis}; write the bench's axes in its frame, as {FRAME}"
            )

    @property
    def _drive(self) -> FloatArray:
        """Axis of the structure about which a positive drive torque turns, (3,)."""
        mounting = self.measured.mounting
        return np.asarray(mounting.sense * self.frame[:, mounting.axis])

    @property
    def components(self) -> tuple[str, ...]:
        """Measured components."""
        return self.measured.records[0].components

    @cached_property
    def absent(self) -> dict[str, str]:
        """Components that do not fly, each with the first direction that the structure lacks for it."""
        held = (self.structure.axis, *self.structure.directions)
        lacking = {c: [d for d, _ in self._directions(c) if d not in held] for c in self.components}
        return {component: directions[0] for component, directions in lacking.items() if directions}

    @property
    def flying_components(self) -> tuple[str, ...]:
        """Components that reach the structure, (s,)."""
        return tuple(component for component in self.components if component not in self.absent)

    def transfer(self, frequency_hz: FloatArray) -> ComplexArray:
        """Return the line of sight per flying component, (n, m, s) rad/N or rad/(N m); 0 where unknown.

        A budget has the torque turn about the structure's axis. For the opposite sense all signs are reversed.
        """
        out = np.zeros(
            (frequency_hz.size, len(self.structure.line_of_sight), len(self.flying_components)), dtype=np.complex128
        )
        for k, component in enumerate(self.flying_components):
            for direction, cosine in self._directions(component):
                response = self.structure.along(direction, frequency_hz)
                assert response is not None
                out[:, :, k] += cosine * np.nan_to_num(response)
        return out * np.sign(self._drive.sum()) if self.flying_components else out

    def has_same_stepping(self, command: Command) -> bool:
        """Return whether any record has the command's stepping; otherwise all records are used, as bounds."""
        return self._records_for(command)[1]

    def rates(self, command: Command) -> tuple[float, float]:
        """Return the lowest and highest measured rate of a stepping."""
        rates = [at.rate for record in self._records_for(command)[0] for at in record.rates]
        return min(rates), max(rates)

    def at(self, command: Command, rate: float) -> SideHere:
        """Return the flying components at a rate."""
        records, alike = self._records_for(command)
        cells = pool_by_rate([at for record in records for at in record.rates])
        here = interpolate_at_rate(cells, self.components, abs(rate)).of(self.flying_components)
        return here if alike else here.without_phases()

    def _directions(self, component: str) -> list[tuple[str, float]]:
        """Return the directions of the structure along which a component acts, each with its cosine."""
        kind, cosines = "t" if component in FORCES else "r", self.frame[:, COMPONENTS.index(component) % 3]
        return [(kind + axis, float(c)) for axis, c in zip(AXES, cosines, strict=True) if abs(c) > RESIDUALS.rounding]

    def _records_for(self, command: Command) -> tuple[tuple[SideRecord, ...], bool]:
        wanted = (command.stepping, command.microsteps)
        alike = tuple(r for r in self.measured.records if (r.stepping, r.microsteps) == wanted)
        return (alike, True) if alike else (self.measured.records, False)
