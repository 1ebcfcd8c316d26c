"""Commands given by measured channels: voltages, currents, a torque or a force as inputs."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.command.excitation import Excitation
from mechid.command.rate import RateProfile
from mechid.command.stepping import Command, Stepping
from mechid.command.waveform import Waveform


@dataclass(frozen=True, kw_only=True, eq=False)
class InputChannel:
    """Samples of one quantity in SI units, (n,); held between samples, or else interpolated linearly."""

    quantity: str
    held: bool = False
    samples: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredCommand(Command):
    """Command of a record with measured inputs; command time is record time since the first sample.

    Parameters
    ----------
    channels : tuple of InputChannel
        In the order of the plant's inputs; empty until the record's file is read.
    sample_rate_hz : float
        Sample rate of all channels.
    first_s : float
        Record time of the first sample.
    """

    stepping: Stepping = "full"
    microsteps: int = 1
    rate: RateProfile = field(default_factory=lambda: RateProfile.constant(0.0))
    waveform: Waveform = "cosine"
    channels: tuple[InputChannel, ...] = ()
    sample_rate_hz: float = 1.0
    first_s: float = 0.0

    @property
    def origin_s(self) -> float:
        """Record time at which the inputs begin, s."""
        return self.first_s

    def driven_by(self, channels: tuple[InputChannel, ...], sample_rate_hz: float, first_s: float) -> MeasuredCommand:
        """Return the command with the given channels."""
        return replace(self, channels=channels, sample_rate_hz=sample_rate_hz, first_s=first_s)

    def excitation(self, duration_s: float) -> Excitation:
        """Return value and slope of each channel from each sample on, up to a duration in s of command time.

        A held channel has its value and slope 0. An interpolated one has its first value throughout and the slope of
        each interval, from which the plant reconstructs it.
        """
        columns = [column for channel in self.channels for column in self._columns(channel)]
        table = np.stack(columns, axis=1) if columns else np.zeros((1, 0))
        times = np.arange(1, len(table)) / self.sample_rate_hz
        within = int(np.searchsorted(times, duration_s, side="right"))
        names = tuple(name for channel in self.channels for name in (channel.quantity, f"{channel.quantity}_slope"))
        return Excitation(
            initial=table[0].copy(),
            times=times[:within],
            values=np.ascontiguousarray(table[1 : 1 + within]),
            inputs=names,
        )

    def _columns(self, channel: InputChannel) -> tuple[FloatArray, FloatArray]:
        v = channel.samples
        if channel.held:
            return v, np.zeros_like(v)
        # The last sample has no successor, so its slope is 0.
        return np.full_like(v, v[0]), np.append(np.diff(v) * self.sample_rate_hz, 0.0)

    def max_edges_per_sample(self, h: float, duration_s: float) -> int:
        """Return 1: the inputs change once per sample."""
        return 1
