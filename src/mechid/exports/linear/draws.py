"""Draws of the uncertain parameters from their covariance, restricted to physical values."""

from __future__ import annotations

import numpy as np

from mechid.arrays import FloatArray
from mechid.budgets.shares import deviations
from mechid.errors import FitError
from mechid.exports.linear.state_space import Uncertain
from mechid.plant.mechanism import Mechanism

MOST_TRIED = 100
"""Most draws per required draw; if fewer than one in so many is physical, the covariance is useless."""


def physical_draws(mechanism: Mechanism, uncertain: Uncertain, count: int, seed: int) -> FloatArray:
    """Draw physical parameter values, (count, k) in the units of the mechanism file, from the covariance.

    Raises
    ------
    FitError
        Too few draws are physical.
    """
    rng = np.random.default_rng(seed)
    kept: list[FloatArray] = []
    for _ in range(MOST_TRIED):
        if len(kept) >= count:
            break
        # Drawn in batches, since unphysical draws are rejected.
        tried = uncertain.values + deviations(uncertain.covariance, count, rng)
        kept += [draw for draw in tried if _is_physical(mechanism, dict(zip(uncertain.names, draw, strict=True)))]
    if len(kept) < count:
        raise FitError(
            f"fewer than one in {MOST_TRIED} draws from the covariance has values that can be: the estimate's standard "
            "errors are larger than its values; identify from more records, or export with --samples 0"
        )
    return np.array(kept[:count]).reshape(count, len(uncertain.names))


def _is_physical(mechanism: Mechanism, values: dict[str, float]) -> bool:
    declared = mechanism.plant.declarations
    inside = all(declared[name].lower <= value <= declared[name].upper for name, value in values.items())
    return inside and not any(True for _ in mechanism.with_values(values).contradictions())
