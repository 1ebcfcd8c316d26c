"""Conversion between the mechanism's time and the driver's time, if the two clocks differ.

Steps occur by the driver's clock; everything else happens in true time. If the recorder's time is the true one and the
driver's seconds are shorter by a factor s, the kernel runs in the driver's time as usual. Each parameter value is
multiplied by s to its power of time (`mechid.plant.time_powers`), and the outputs are scaled back.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.command import Timing
from mechid.command.timing import PPM
from mechid.plant.plant import Plant
from mechid.plant.time_powers import output_time_powers, time_powers, unit_time_power
from mechid.simulation.block import Block
from mechid.simulation.start import Start
from mechid.simulation.switch_log import Jumps


@dataclass(frozen=True, eq=False)
class TimeScale:
    """Factors that convert values from the mechanism's time to the driver's.

    Attributes
    ----------
    parameters : (n_p,)
        Factors on the kernel's parameters.
    outputs : (n_y,)
        Factors on the kernel's outputs, back to the mechanism's time.
    starts : dict of str to float
        Factors on the states of a start, by key.
    """

    parameters: FloatArray
    outputs: FloatArray
    starts: dict[str, float]

    def start(self, start: Start) -> Start:
        """Return a start in the driver's time."""
        lanes = {n: {k: self.starts[k] * slope for k, slope in own.items()} for n, own in start.lanes.items()}
        return replace(start, values={k: self.starts[k] * value for k, value in start.values.items()}, lanes=lanes)

    def block(self, block: Block) -> Block:
        """Return a block with its outputs in the mechanism's units; its jumps are converted already."""
        if np.all(self.outputs == 1.0):
            return block
        y, rate, jacobian = block.y * self.outputs, block.rate * self.outputs, block.jacobian * self.outputs[:, None]
        return replace(block, y=y, rate=rate, jacobian=jacobian)

    def jumps(self, jumps: Jumps) -> Jumps:
        """Return jumps in the mechanism's units."""
        return replace(jumps, rises=jumps.rises * self.outputs) if jumps.samples.size else jumps


def time_scale(plant: Plant, timing: Timing) -> TimeScale | None:
    """Return the factors for a record's timing; None if the mechanism's time is the driver's."""
    s = timing.stretch
    if s == 1.0:
        return None
    starts = {key: s ** unit_time_power(d.unit) for key, d in plant.starts.items()}
    return TimeScale(s ** time_powers(plant), s ** -output_time_powers(plant), starts)


def clock_direction(plant: Plant, p: FloatArray, timing: Timing) -> FloatArray:
    """Return the change of the kernel's parameters per unit of clock_ppm that is equivalent to a clock error, (n_p,).

    Zero if the driver keeps true time: a clock error then only shifts the sample instants.
    """
    return time_powers(plant) * p * _relative(timing)


def start_slopes(plant: Plant, start: Start, timing: Timing) -> dict[str, float]:
    """Return the same derivative of the states of a start, by key."""
    relative = _relative(timing)
    return {k: unit_time_power(plant.starts[k].unit) * value * relative for k, value in start.values.items()}


def output_slope(plant: Plant, output: int) -> float:
    """Return the relative change of an output with ``clock_ppm``, in addition to that through the parameters."""
    return -PPM * float(output_time_powers(plant)[output])


def _relative(timing: Timing) -> float:
    return PPM / timing.stretch if timing.reference == "recorder" else 0.0
