"""Parameters of single records: their coordinates, shifts of instants, and means over all records."""

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
"""Function that returns dy/d(value) of an output, by index, over the last n samples of a block of a time base, (n,)."""


def _of_time_offset(_base: TimeBase, block: Block, output: int, n: int) -> FloatArray:
    """Return minus the rate: a time offset shifts the whole run to later times."""
    return -block.rate[-n:, output]


def _of_clock(base: TimeBase, block: Block, output: int, n: int) -> FloatArray:
    """Return the rate times record time: t (1 + c) advances by t dc."""
    record_s = base.start_s + np.arange(block.stop - n, block.stop) * base.interval_s
    return PPM * record_s * block.rate[-n:, output]


INSTANTS: Mapping[str, Slope] = {TIME_OFFSET.key: _of_time_offset, CLOCK.key: _of_clock}
"""Record parameters that shift the instants of its samples, by key."""


@dataclass(frozen=True)
class RecordCoordinate:
    """Coordinate that acts on some records only, in the file's unit.

    Attributes
    ----------
    records : tuple of str
        Names of its targets: one, or all that share it.
    parameter : Parameter
        Name, start and bounds.
    lane : int or None
        Lane of the kernel that carries its derivative; None if it only shifts instants.
    """

    records: tuple[str, ...]
    parameter: Parameter
    lane: int | None

    def slope(self, base: TimeBase, block: Block, output: int, n: int) -> FloatArray:
        """Return dy/d(value) of an output over the last n samples of a block of one of its records, (n,)."""
        moves = INSTANTS.get(self.parameter.declaration.key)
        if self.lane is None:
            assert moves is not None
            return moves(base, block, output, n)
        carried = block.jacobian[-n:, output, self.lane]
        return carried if moves is None else carried + moves(base, block, output, n)


@dataclass(frozen=True)
class Mean:
    """Constraint that the mean of a parameter that every record has of its own is the mechanism's value.

    Without it, the data could not distinguish a supply voltage that is higher in all records from a smaller torque
    constant, and the mechanism's resistance would be undetermined if every record had its own.

    Attributes
    ----------
    of : str
        The mechanism's parameter.
    own : tuple of str
        The records' values of it.
    sigma : float
        Standard deviation of the constraint, in the file's unit. If the records do not determine the mean, as for
        supplies, it is so small that the search never trades the mean for another parameter; the true uncertainty of
        the mean is `standard_error`.
    is_determined : bool
        Whether the records determine the mean: a known inertia shows a gain that all records share. The mean is then
        constrained as loosely as a single value.
    """

    of: str
    own: tuple[str, ...]
    sigma: float
    is_determined: bool = False

    def standard_error(self, values: Sequence[float]) -> float:
        """Return the standard deviation of the true mean about the mechanism's value.

        It is s / sqrt(K) with the scatter s of the records' values, (K,), which are draws about the mechanism's value.
        It has K - 1 degrees of freedom.
        """
        return float(np.std(values, ddof=1)) / math.sqrt(len(values))


def determines_mean(parameter: Parameter) -> bool:
    """Tell whether records determine the mean of their own values of a parameter, as they do for a gain."""
    return parameter.declaration.role is Role.TRANSDUCER_GAIN


def means_of(targets: Sequence[Target]) -> Iterator[Mean]:
    """Yield the means of parameters that every record has of its own, free and with a prior."""
    by_name: dict[str, list[Parameter]] = {}
    for p in (p for target in targets for p in target.free_parameters if p.replaces and p.sigma):
        by_name.setdefault(p.replaces, []).append(p)
    for name, own in by_name.items():
        if len(own) == len(targets) > 1:
            sigma, is_determined = min(p.sigma for p in own if p.sigma), determines_mean(own[0])
            within = 1.0 if is_determined else PROBLEM.mean_within
            yield Mean(name, tuple(p.name for p in own), within * sigma, is_determined)
