"""Command of microsteps whose phase values come from a table."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mechid.arrays import FloatArray
from mechid.command import Command, Excitation, RateProfile


@dataclass(frozen=True, kw_only=True, eq=False)
class TableCommand(Command):
    """Microstepping with a table of phase values.

    Attributes
    ----------
    table : (4 n, 2) float
        Fractions of the peak of phases A and B, from electrical angle 0 on.
    """

    table: FloatArray = field(default_factory=lambda: np.zeros((4, 2)))

    def excitation(self, duration_s: float) -> Excitation:
        """Return the table's values over a run's time."""
        times, index = self._edges(self.begun_s + duration_s)
        rows = len(self.table)
        return Excitation(initial=self.table[self._first_index % rows], times=times, values=self.table[index % rows])


def table_command(table: FloatArray, rate: float) -> Command:
    """Return the command of a table, (4 n, 2), at a rate in full steps/s."""
    microsteps = len(table) // 4
    return TableCommand(stepping="micro", microsteps=microsteps, rate=RateProfile.constant(rate), table=table)
