"""Record time and command time: when a command starts on the recorder's clock, and how fast that clock runs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias, TypeVar

from mechid.arrays import FloatArray

Instant = TypeVar("Instant", float, FloatArray)
PPM = 1e-6
ClockReference: TypeAlias = Literal["recorder", "driver"]
"""Whose time is the true one, in which the mechanism moves, where the two clocks differ."""
CLOCK_REFERENCES: tuple[ClockReference, ...] = ("recorder", "driver")


@dataclass(frozen=True)
class Timing:
    """command time = record time * (1 + 1e-6 `clock_ppm`) - `offset_s`.

    Attributes
    ----------
    offset_s : float
        Command time at record time 0, with the other sign: when the command starts, s.
    clock_ppm : float
        By how much the driver's clock runs faster than the recorder's: positive where a second of the recorder is more
        than one of the driver.
    reference : {"recorder", "driver"}
        Whose time is the true one: in it the mechanism moves, its values and outputs are in its seconds.
    """

    offset_s: float = 0.0
    clock_ppm: float = 0.0
    reference: ClockReference = "recorder"

    @property
    def scale(self) -> float:
        """Seconds of the driver's clock in one of the recorder's."""
        return 1.0 + PPM * self.clock_ppm

    @property
    def stretch(self) -> float:
        """Seconds of the driver's clock in one of true time."""
        return self.scale if self.reference == "recorder" else 1.0

    def command_s(self, record_s: Instant) -> Instant:
        """Return the command time of instants of record time, s."""
        return record_s * self.scale - self.offset_s

    def record_s(self, command_s: Instant) -> Instant:
        """Return the record time of instants of command time, s."""
        return (command_s + self.offset_s) / self.scale
