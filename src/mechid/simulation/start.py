"""A run's start off the rest where its command begins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.command import Command
from mechid.kernel.compiled import Buffers, Kernel, lane_places
from mechid.kernel.start import own_start


@dataclass(frozen=True, eq=False)
class Start:
    """A start of a record's own, off the rest where its command begins.

    Attributes
    ----------
    values : mapping of str to float
        By the keys of `Plant.starts`; what is not among them is zero.
    lanes : mapping of int to mapping of str to float
        By lane that carries a derivative: by how much each of the values moves with what it is the derivative to.
    """

    values: Mapping[str, float]
    lanes: Mapping[int, Mapping[str, float]] = field(default_factory=dict)


AT_REST = Start({})


def begin_off_rest(
    kernel: Kernel, buffers: Buffers, p: FloatArray, inputs: FloatArray, command: Command, start: Start
) -> None:
    """Let a run whose workspace stands at rest begin at a start of its own, with derivatives to parameters and start.

    Without such a start it stays at rest.

    Parameters
    ----------
    kernel : Kernel
    buffers : Buffers
        Before any block is consumed.
    p : (n_p,)
    inputs : (n_u,)
        Held at the start.
    command : Command
        Its angle there is where the rest is.
    start : Start
    """
    if not start.values:
        return
    module, w, theta_0 = kernel.module, buffers.w, command.start_angle_rad
    own = own_start(kernel.plant, p, inputs, theta_0, start.values)
    n = own.off.size
    x = w[int(module.AT_X) :][:n] + own.off
    x_p = w[int(module.AT_X_P) :][: n * p.size] + own.off_by_parameter.ravel()
    kernel.begin(p, buffers.directions, inputs, theta_0, x, x_p, buffers.discrete, w)
    w[int(module.AT_Z) :][: own.filter.size] = own.filter
    slopes = own.by_start * ~_held_at_rest(kernel, buffers)[:, None]
    keys = list(kernel.plant.starts)
    for lane, moved in start.lanes.items():
        for key, slope in moved.items():
            _carry(kernel, buffers, lane, slope * slopes[:, keys.index(key)])


def states_in(kernel: Kernel, buffers: Buffers) -> FloatArray:
    """Return the plant's states, then those of its filter, where a run stands, (n_x + n_f,)."""
    module, w = kernel.module, buffers.w
    return np.concatenate([w[int(module.AT_X) : int(module.END_X)], w[int(module.AT_Z) : int(module.END_Z)]])


def _held_at_rest(kernel: Kernel, buffers: Buffers) -> BoolArray:
    """Return which states, those of the filter behind them, friction holds at zero, (n_x + n_f,)."""
    modes = buffers.discrete[int(kernel.module.MODE) :]
    held = {
        state
        for switch, mode in zip(kernel.plant.switches, modes, strict=False)
        if [*switch.modes][mode] == switch.otherwise
        for guards in switch.guards.values()
        for guard in guards
        for state in guard.resets
    }
    return np.array([state in held for state in kernel.plant.begun_states])


def _carry(kernel: Kernel, buffers: Buffers, lane: int, slopes: FloatArray) -> None:
    """Add derivatives of the states and the filter's, (n_x + n_f,), to those at which a lane begins."""
    module = kernel.module
    for i, slope in enumerate(slopes):
        buffers.w[lane_places(module, int(module.ROW_S) + i, buffers.lanes)[lane]] += slope
    buffers.discrete[int(module.GROUPS) + lane // int(module.LANES_PER_GROUP)] = int(module.ALL)
