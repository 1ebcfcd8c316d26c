"""Thresholds of the grade, of held-out records and of the messages of a result."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class GradeRules:
    """Thresholds that decide the grade of a fit."""

    consistency_z_limit: float = 4.0
    """Standard deviations of chance up to which the parts of the records agree: 17 campaigns with a complete model
    reached 0.9 at most, and of 41 with an effect left out 39 exceeded it."""

    held_out_excess: float = 2.0
    """Residual over the noise, and over the fitted records' own ratio, from which a held-out record is predicted badly.
    Complete models leave 0.95 to 1.06 times the noise of held-out records (docs/identification.md)."""
    record_excess: float = 2.0
    """Residual over the noise, and over the other records' ratio, from which a fitted record contains an effect that
    the model lacks. Complete models leave 0.95 to 1.06 times the noise; a knock of 0.1 s left 4.7 times the noise of
    one record of six and 1.01 times that of the others, with grade A."""
    held_out_lost_share: float = 0.5
    """Share of the measured RMS above which the residual of a badly predicted record means that it is not followed:
    half, as in each window of a fitted record (`signal.following`)."""

    # The others are choices; no benchmark distinguishes values near them.

    near_optimum: float = 0.1
    """Share of the cost that the quadratic may still predict to fall where a fit stopped at its limit of steps. Up to
    it the step counts in the errors; above it no optimum is near."""
    near_bound: float = 1e-3
    """Distance from a bound, as a share of the range, within which a fit that stopped short may be held by it."""
    least_of_noise: float = 0.5
    """Residual over noise below which the declared noise level is wrong: a residual contains all of the noise."""
    near_multiple: float = 0.01
    """Relative distance within which lines belong to one multiple of the grid frequency."""
    most_named: int = 8
    """Largest number of values that a warning names."""
    progress_interval_s: float = 1.0
    """Shortest time between two progress notes in the journal."""


@dataclass(frozen=True)
class HeldOutSettings:
    """First part of a held-out record, on which its own parameters are fitted. All values are choices."""

    first_share: float = 0.1
    """Least length of the first part, as a share of the record from where its motion begins."""
    largest_share: float = 0.5
    """Greatest length of the first part, as a share of the whole record."""
    first_steps: float = 16.0
    """Full steps in the first part: four electrical turns."""
    motion_share: float = 0.1
    """Share of the largest swing from which a record under a measured input counts as moving."""
    instants: int = 20_000
    """Instants at which the travel of a command is sampled."""
    most_offsets: int = 256
    """Largest number of time offsets on the grid over the declared range."""
    fine_offsets: int = 33
    """Time offsets on the fine grid around each of the best."""
    branches: int = 3
    """Number of best time offsets that are refined."""


GRADE = GradeRules()
HELD_OUT = HeldOutSettings()
