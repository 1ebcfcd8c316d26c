"""A transducer that bends: what it gives falls short of the torque, the more the larger that is. A hint, in words."""

from __future__ import annotations

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.contradiction.alternatives import side_by_side
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.units import unit_words

EXPLAINS = 2.0
"""Times less than with a gain alone that is left with a bend, from which it is told of; a choice, not measured."""
LEAST = 0.05
"""By which share a record has to fall short at its largest; a choice, not measured."""


def bend_words(problem: Problem, q: FloatArray, target: Target) -> str:
    """Return how a record bends beside the model that other records have settled, as a clause; empty where it does not.

    Parameters
    ----------
    problem : Problem
        Of the records that agree.
    q : (n,)
        Where these are followed.
    target : Target
        The record that contradicts them, as much of it as is to be looked at.
    """
    modelled, measured = side_by_side(problem, np.asarray(q[: problem.space.size]), target.settled)
    largest = float(np.abs(modelled).max())
    if not np.isfinite(largest) or largest == 0.0:
        return ""
    y = modelled / largest
    (gain, cubic), bent = _fitted(np.stack((y, y**3)), measured)
    _, straight = _fitted(y[np.newaxis], measured)
    short = -cubic / gain if gain > 0.0 else 0.0
    if straight < EXPLAINS * bent or short < LEAST:
        return ""
    return (
        f"the larger its {target.leading.quantity.replace('_', ' ')}, the more it falls short of the others' model, by "
        f"{100.0 * short:.2g} % at {largest:.3g} {unit_words(target.leading.quantity)}, as where a transducer or its "
        "amplifier saturates"
    )


def _fitted(rows: FloatArray, y: FloatArray) -> tuple[FloatArray, float]:
    """Return by what to multiply each of some rows, (k, N), to come nearest to samples, and the norm of the rest."""
    factors = np.asarray(np.linalg.lstsq(rows.T, y, rcond=None)[0], dtype=np.float64)
    return factors, float(np.linalg.norm(y - factors @ rows))
