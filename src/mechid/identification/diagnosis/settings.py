"""Settings of what a diagnosis says and draws of a residual."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DiagnosisSettings:
    """Sizes and thresholds; all are choices: none moves a result."""

    # What a residual goes with: the motion or time.

    lines_named: int = 3
    """Lines that are named."""
    lines_removed: int = 20
    """Lines that are removed before what is left is looked at again."""
    least_line_share: float = 0.05
    """Of the residual's power, from which lines are worth a word."""

    # Spectra, and the stretch in time where the mechanism as written misses most.

    records_drawn: int = 3
    """Records whose spectra are drawn: those of which the mechanism as written misses most."""
    groups: int = 400
    """Groups of bins in a spectrum."""
    periods: float = 8.0
    """Length of the stretch, in periods of the strongest line of what is missed."""
    shortest_s: float = 0.05
    """Shortest stretch."""
    longest_s: float = 0.3
    """Longest stretch."""


DIAGNOSIS = DiagnosisSettings()
