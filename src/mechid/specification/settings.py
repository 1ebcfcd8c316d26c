"""Definitions that an emission requirement leaves open."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SpecificationSettings:
    """Resolution and filter of the kinds of quantity."""

    resolution_hz: float = 1.0
    """Bin width of a power density where a requirement names none: the usual one of microvibration reports."""
    filter_order: int = 4
    """Order of the Butterworth prototype of the band-pass of a band peak."""
    guard: float = 2.56
    """Sample rate over the highest frequency that is judged: the usual margin of anti-alias filters."""
    window_s: float = 4.0
    """Longest window of a measured spectrum, and window of a predicted one where a kind has no resolution of its own:
    0.25 Hz a bin, so that orders of 2 steps/s stay apart, and a background of 4 s is long enough."""
    peak_s: float = 60.0
    """Time over which the largest value of a predicted random part is taken: the usual length of a run."""


SPECIFICATION = SpecificationSettings()
