"""Start of a run in a state other than rest."""

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
    """A start of a record's own, other than the rest where its command begins.

    Attributes
    ----------
    values : mapping of str to float
        By the keys of `Plant.starts`; missing keys are zero.
    lanes : mapping of int to mapping of str to float
        By the index of a lane: the derivative of each value with respect to the lane's quantity.
    """

    values: Mapping[str, float]
    lanes: Mapping[int, Mapping[str, float]] = field(default_factory=dict)


AT_REST = Start({})


def begin_from_start(
    kernel: Kernel, buffers: Buffers, p: FloatArray, inputs: FloatArray, command: Command, start: Start
) -> None:
    """Replace the rest start of a run by a given start, with derivatives with respect to parameters and start.

    Without start values the run stays at rest.

    Parameters
    ----------
    kernel : Kernel
    buffers : Buffers
        Of a run whose blocks are not consumed yet.
    p : (n_p,)
    inputs : (n_u,)
        Held at the start.
    command : Command
        Its start angle locates the rest position.
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
    # A state that friction holds at zero does not follow the start values.
    slopes = own.by_start * ~_held_at_rest(kernel, buffers)[:, None]
    keys = list(kernel.plant.starts)
    for lane, moved in start.lanes.items():
        for key, slope in moved.items():
            _add_lane_slopes(kernel, buffers, lane, slope * slopes[:, keys.index(key)])


def states_in(kernel: Kernel, buffers: Buffers) -> FloatArray:
    """Return the current states of the plant, then of its filter, (n_x + n_f,)."""
    module, w = kernel.module, buffers.w
    return np.concatenate([w[int(module.AT_X) : int(module.END_X)], w[int(module.AT_Z) : int(module.END_Z)]])


def _held_at_rest(kernel: Kernel, buffers: Buffers) -> BoolArray:
    """Return which states of the plant and of its filter are held at zero by friction, (n_x + n_f,)."""
    modes = buffers.discrete[int(kernel.module.MODE) :]
    held = {
        state
        for switch, mode in zip(kernel.plant.switches, modes, strict=False)
        if [*switch.modes][mode] == switch.otherwise
        for guards in switch.guards.values()
        for guard in guards
        for state in guard.resets
    }
    return np.array([state in held for state in kernel.plant.states_with_filter])


def _add_lane_slopes(kernel: Kernel, buffers: Buffers, lane: int, slopes: FloatArray) -> None:
    """Add derivatives of the states of plant and filter, (n_x + n_f,), to the initial values of a lane."""
    module = kernel.module
    for i, slope in enumerate(slopes):
        buffers.w[lane_places(module, int(module.ROW_S) + i, buffers.lanes)[lane]] += slope
    buffers.discrete[int(module.GROUPS) + lane // int(module.LANES_PER_GROUP)] = int(module.ALL)
