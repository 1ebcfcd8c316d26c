"""Command of microsteps whose phase values come from an array."""

from __future__ import annotations

from mechid.arrays import FloatArray
from mechid.command import Command, RateProfile
from mechid.command.phase_table import ROWS_A_FULL_STEP, PhaseTable


def phase_table(values: FloatArray) -> PhaseTable:
    """Return an array of phase values, (4 n, 2), as the table of a command."""
    return tuple((a, b) for a, b in values.tolist())


def table_command(values: FloatArray, rate: float) -> Command:
    """Return the command of a table, (4 n, 2), at a rate in full steps/s."""
    microsteps = len(values) // ROWS_A_FULL_STEP
    return Command(stepping="micro", microsteps=microsteps, rate=RateProfile.constant(rate), table=phase_table(values))
