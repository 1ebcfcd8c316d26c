"""Rules for what records can tell of a parameter, and how far a simulation can be predicted."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class VerdictRules:
    """Thresholds of the identifiability verdicts."""

    points: int = 8
    """Points of the box that are looked at, the file's own values first; a power of two. Of a record that is chaotic at
    some points only, two of the eight show it."""
    displaced: float = 1e-9
    """Share of its value, or its range, by which each parameter is displaced: a thousandth of what the best record
    tells."""
    rounding_change: float = 1e-6
    """Change of a sample over the whole range of a coordinate, in sigmas of its noise, that is rounding."""

    # The others are choices; no benchmark distinguishes values near them.

    partner: float = 0.9
    """Magnitude of the correlation from which another parameter has part in a ruined estimate."""
    involved: float = 0.2
    """Share of the largest component of a direction from which a parameter is named."""
    equal: float = 0.2
    """Relative difference of two components that count as the same."""
    most_relative: float = 100.0
    """Magnitude of standard error over value from which a parameter without two bounds is not known."""
    parts: int = 10
    """Equal parts of a record behind the instant at which runs come apart."""
    parts_apart: int = 8
    """Parts that have to hold a window apart for the runs to stay so."""
    fewest_windows: int = 40
    """Windows behind that instant, 0.2 s, from which this can be decided."""
    longest_s: float = 20.0
    """Length of a record that is looked at. It bounds the time of a check."""
    safe_share: float = 0.5
    """Share of the time in which runs come apart that a stretch may have."""
    least_excess: float = 1e-7
    """In SI units: a parameter this little above the one it never lies below is at its least, as static friction."""
    negligible_change: float = 1e-3
    """Change of all samples together over the whole range of a coordinate, in sigmas, that counts as zero."""
    look_s: float = 1.0
    """Part of each record that is looked at, from its first motion on."""


VERDICTS = VerdictRules()
