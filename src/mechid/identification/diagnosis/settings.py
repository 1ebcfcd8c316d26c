"""Settings for the description and the figures of a residual in a diagnosis."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DiagnosisSettings:
    """Sizes and thresholds. All are choices; none changes a result."""

    # Lines of a residual over position and over time.

    lines_named: int = 3
    """Largest number of lines in a description."""
    lines_removed: int = 20
    """Largest number of lines that are removed before the rest is examined again."""
    least_line_share: float = 0.05
    """Share of the residual's power from which lines are reported."""

    # Spectra, and the stretch in time with the largest residual of the mechanism as written.

    records_drawn: int = 3
    """Number of records whose spectra are drawn, those with the largest residuals."""
    groups: int = 400
    """Groups of bins in a spectrum."""
    periods: float = 8.0
    """Length of the stretch, in periods of the strongest line of the residual."""
    shortest_s: float = 0.05
    """Shortest stretch."""
    longest_s: float = 0.3
    """Longest stretch."""


DIAGNOSIS = DiagnosisSettings()
