"""Lines of a budget at the orders that the mechanism names, as those of its tooth meshes."""

from __future__ import annotations

from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.budgets.budget import Budget
from mechid.budgets.mode_budget import ModeBudget
from mechid.budgets.settings import MOTION
from mechid.plant.mechanism import Mechanism

WITHIN = 10.0**-MOTION.digits
"""Distance of two orders within which they are one."""


def line_names(orders: FloatArray, mechanism: Mechanism) -> list[str]:
    """Return the name of the line at each order of the step rate, (n,), empty where the mechanism names none."""
    named = [(one.order, one.name) for one in mechanism.named_lines if one.order]
    return [next((name for q, name in named if abs(q - order) <= WITHIN), "") for order in orders.tolist()]


def named_line_numbers(budget: Budget, made: ModeBudget) -> list[dict[str, Any]]:
    """Return the lines at named orders at the worst rate of a mode: those of the model, and those that it lacks."""
    response, exerted, mechanism = made.responses[made.worst], made.emissions[made.worst], budget.estimate.mechanism
    words = {one.name: one.words for one in mechanism.named_lines}
    sight = np.zeros((exerted.orders.size, len(response.axes)))
    sight[: response.state.lines.size] = np.abs(response.phasors)
    return [
        {
            "name": name,
            "words": words[name],
            "order": float(exerted.orders[k]),
            "frequency_hz": float(exerted.frequency_hz[k]),
            "torque_Nm": float(abs(exerted.modelled[k])),
            "residual_Nm": float(exerted.residual[k]),
            "bound_Nm": float(exerted.bound[k]),
            "line_of_sight_rad": sight[k].tolist(),
        }
        for k, name in enumerate(line_names(exerted.orders, mechanism))
        if name
    ]
