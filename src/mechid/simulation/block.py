"""What a run gives block by block, and where it stands."""

from __future__ import annotations

from dataclasses import dataclass

from mechid.arrays import FloatArray
from mechid.simulation.noted import NO_JUMPS, Jumps


@dataclass(frozen=True)
class Block:
    """Samples `start` to `stop` of a run, as views that the next block overwrites.

    Attributes
    ----------
    y : (n, n_y)
    rate : (n, n_y), or (0, n_y) without sensitivities
    jacobian : (n, n_y, lanes), one lane a direction, zero in those not used; or (0, n_y, 0)
    jumps : Jumps
        Where the run notes them, else none.
    """

    start: int
    stop: int
    y: FloatArray
    rate: FloatArray
    jacobian: FloatArray
    jumps: Jumps = NO_JUMPS


@dataclass(frozen=True, eq=False)
class State:
    """Where a run stands, or is to start from at command time 0.

    Attributes
    ----------
    x : (n_x,)
        The plant's states.
    lanes : (n_x, m)
        Their derivatives along the directions of the run.
    """

    x: FloatArray
    lanes: FloatArray
