"""Parameters that belong to single records: those that move instants, and the mean of those that every record has."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign.campaign import CLOCK, TIME_OFFSET
from mechid.command.timing import PPM
from mechid.identification.output_error.settings import PROBLEM
from mechid.identification.output_error.target import Target
from mechid.parameter import Parameter, Role
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


@dataclass(frozen=True)
class Mean:
    """Values of one parameter of the mechanism that every record has of its own: their mean is the mechanism's.

    Without it nothing would tell a supply that is higher in all records from a smaller torque constant, and the
    mechanism's resistance would be unknown where every record has its own.

    Attributes
    ----------
    of : str
        The mechanism's parameter.
    own : tuple of str
        The records' values of it.
    sigma : float
        What the mean is held to it by, in the file's unit. Where nothing tells it, as of supplies, so small that the
        search never trades it for anything; how far the mean may truly be from it is `unknown`.
    is_determined : bool
        Whether the records tell the mean: a known inertia shows a gain that all records share. It is then held as
        loosely as one value is.
    """

    of: str
    own: tuple[str, ...]
    sigma: float
    is_determined: bool = False

    def standard_error(self, values: Sequence[float]) -> float:
        """Return the standard deviation of the true mean from the mechanism's value, known by len(own) - 1 degrees.

        s / sqrt(K) with s the scatter of the records' values, (K,): they are draws about the mechanism's.
        """
        return float(np.std(values, ddof=1)) / math.sqrt(len(values))


def determines_mean(parameter: Parameter) -> bool:
    """Tell whether the mean over all records of what each has of its own is told by them, as that of a gain is."""
    return parameter.declaration.role is Role.TRANSDUCER_GAIN


def means_of(targets: Sequence[Target]) -> Iterator[Mean]:
    """Yield the means of what every record has of its own, free and with a prior."""
    by_name: dict[str, list[Parameter]] = {}
    for p in (p for target in targets for p in target.free_parameters if p.replaces and p.sigma):
        by_name.setdefault(p.replaces, []).append(p)
    for name, own in by_name.items():
        if len(own) == len(targets) > 1:
            sigma, is_determined = min(p.sigma for p in own if p.sigma), determines_mean(own[0])
            within = 1.0 if is_determined else PROBLEM.mean_within
            yield Mean(name, tuple(p.name for p in own), within * sigma, is_determined)
