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


SPECIFICATION = SpecificationSettings()
