"""Measured line of one direction at one rate."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class EmissionLine:
    """One line of one direction at one rate; amplitudes are peak values in N or N m.

    `background` is the upper bound of the background's line at its frequency, 0 where there is none; `mains_hz` the
    multiple of the mains that it is, NaN where it is none; `order` likewise. `named` has the names of
    the mechanism's lines at its frequency, as those of its tooth meshes, joined by commas.
    """

    record: str
    rate: float
    direction: str
    frequency_hz: float
    order: float
    amplitude: float
    sigma: float
    background: float
    mains_hz: float
    named: str
    unit: str
