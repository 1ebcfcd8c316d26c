"""Blocks of samples that a run yields, and the state of a run."""

from __future__ import annotations

from dataclasses import dataclass

from mechid.arrays import FloatArray
from mechid.simulation.switch_log import NO_JUMPS, Jumps


@dataclass(frozen=True)
class Block:
    """Samples `start` to `stop` of a run, as views that the next block overwrites.

    Attributes
    ----------
    y : (n, n_y)
    rate : (n, n_y), or (0, n_y) without sensitivities
    jacobian : (n, n_y, lanes), one lane per direction, zero in unused lanes; or (0, n_y, 0)
    jumps : Jumps
        Output jumps, if the run logs them; else none.
    """

    start: int
    stop: int
    y: FloatArray
    rate: FloatArray
    jacobian: FloatArray
    jumps: Jumps = NO_JUMPS


@dataclass(frozen=True, eq=False)
class State:
    """State of a run, or a state to start from at command time 0.

    Attributes
    ----------
    x : (n_x,)
        The plant's states.
    lanes : (n_x, m)
        Their derivatives along the directions of the run.
    """

    x: FloatArray
    lanes: FloatArray
