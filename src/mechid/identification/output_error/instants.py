"""What moves the instants of a record's samples: a time offset and a clock, whose derivatives follow from the rate."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign.campaign import CLOCK, TIME_OFFSET
from mechid.command.timing import PPM
from mechid.simulation.block import Block
from mechid.simulation.simulator import TimeBase

Slope = Callable[[TimeBase, Block, int, int], FloatArray]
"""dy/d(value) of an output, by its number, over the last n samples of a block of a time base, (n,)."""


def _of_time_offset(_base: TimeBase, block: Block, output: int, n: int) -> FloatArray:
    """Return minus the rate: a time offset shifts the whole run to later times."""
    return -block.rate[-n:, output]


def _of_clock(base: TimeBase, block: Block, output: int, n: int) -> FloatArray:
    """Return the rate times the record time's share: t (1 + c) runs ahead by t dc."""
    record_s = base.start_s + np.arange(block.stop - n, block.stop) * base.interval_s
    return PPM * record_s * block.rate[-n:, output]


INSTANTS: Mapping[str, Slope] = {TIME_OFFSET.key: _of_time_offset, CLOCK.key: _of_clock}
"""Parameters of a record's own that move the instants of its samples, by key."""
