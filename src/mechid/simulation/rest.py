"""Outputs before command time 0, where the mechanism rests, with their derivatives."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from types import ModuleType

import numpy as np
import sympy as sp

from mechid.arrays import FloatArray
from mechid.kernel.compiled import lane_places
from mechid.plant.plant import Plant

Held = Callable[..., tuple[float, list[float]]]


def resting_outputs(
    plant: Plant, module: ModuleType, p: FloatArray, inputs: FloatArray, directions: FloatArray, w: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the outputs at rest, (n_y,), and their derivatives along the directions, (n_y, lanes).

    A state keeps its value at the start; an output that depends on the inputs alone, such as the current of an ideal
    source, takes that value; every other output, torques above all, is zero.

    Parameters
    ----------
    plant : Plant
    module : module
        The plant's kernel.
    p : (n_p,)
    inputs : (n_u,)
        Values before the first step.
    directions : (n_p, lanes)
    w : (SIZE,)
        The kernel's workspace at the start.
    """
    lanes = directions.shape[1]
    y, J = np.zeros(len(plant.outputs)), np.zeros((len(plant.outputs), lanes))
    for j, (expression, held) in enumerate(zip(plant.outputs.values(), _compile_held_outputs(plant), strict=True)):
        if expression in plant.states:
            i = plant.states.index(expression)
            y[j] = w[int(module.AT_X) + i]
            J[j] = w[lane_places(module, int(module.ROW_S) + i, lanes)]
        elif held is not None:
            y[j], slopes = held(*p, *inputs)
            J[j] = np.asarray(slopes) @ directions
    return y, J


@lru_cache(maxsize=32)
def _compile_held_outputs(plant: Plant) -> tuple[Held | None, ...]:
    """Compile each output that depends on inputs and parameters alone: its value and its parameter derivatives."""
    known = {*plant.parameters, *plant.inputs}
    compiled: list[Held | None] = []
    for output in plant.outputs.values():
        expression = sp.sympify(plant.expand(output))
        if expression.free_symbols <= known and expression.free_symbols & set(plant.inputs):
            slopes = [sp.diff(expression, s) for s in plant.parameters]
            compiled.append(sp.lambdify([*plant.parameters, *plant.inputs], (expression, slopes), modules="math"))
        else:
            compiled.append(None)
    return tuple(compiled)
