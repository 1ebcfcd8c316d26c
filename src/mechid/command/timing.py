"""Conversion between record time and command time: offset and relative drift of the two clocks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias, TypeVar

from mechid.arrays import FloatArray

Instant = TypeVar("Instant", float, FloatArray)
PPM = 1e-6
ClockReference: TypeAlias = Literal["recorder", "driver"]
"""The clock that keeps true time, in which the mechanism moves, if the two clocks differ."""
CLOCK_REFERENCES: tuple[ClockReference, ...] = ("recorder", "driver")


@dataclass(frozen=True)
class Timing:
    """command time = record time * (1 + 1e-6 `clock_ppm`) - `offset_s`.

    Attributes
    ----------
    offset_s : float
        Record time at which the command starts, s: minus the command time at record time 0.
    clock_ppm : float
        Relative excess of the driver's clock rate over the recorder's, in ppm: positive if a second of the recorder
        is longer than a second of the driver.
    reference : {"recorder", "driver"}
        The clock that keeps true time; the mechanism's parameters and outputs are in its seconds.
    """

    offset_s: float = 0.0
    clock_ppm: float = 0.0
    reference: ClockReference = "recorder"

    @property
    def scale(self) -> float:
        """Seconds of the driver's clock per second of the recorder's."""
        return 1.0 + PPM * self.clock_ppm

    @property
    def stretch(self) -> float:
        """Seconds of the driver's clock per second of true time."""
        return self.scale if self.reference == "recorder" else 1.0

    def command_s(self, record_s: Instant) -> Instant:
        """Convert instants of record time to command time, s."""
        return record_s * self.scale - self.offset_s

    def record_s(self, command_s: Instant) -> Instant:
        """Convert instants of command time to record time, s."""
        return (command_s + self.offset_s) / self.scale
