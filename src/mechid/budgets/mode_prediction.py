"""Verdicts on the emission requirements of a budget, at the steady rates of its modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from mechid.budgets.budget_file import BudgetFile
from mechid.budgets.flying_mechanism import Estimate
from mechid.budgets.mode_budget import ModeBudget
from mechid.budgets.prediction import Prediction, TorqueOverRate, predict
from mechid.records.components import TORQUE


def predict_modes(file: BudgetFile, estimate: Estimate, modes: Sequence[ModeBudget]) -> tuple[Prediction, ...]:
    """Judge the torque on a held base against the emission requirements of a file.

    Parameters
    ----------
    file : BudgetFile
    estimate : Estimate
    modes : sequence of ModeBudget
        With the steady states at each rate; a profile has no lines and is not judged.
    """
    steady = [made for made in modes if made.states]
    torques = [
        TorqueOverRate(mode=made.mode, states=tuple(tuple(r.state for r in here) for here in made.states))
        for made in steady
    ]
    # The torque turns about the structure's axis, "rx", "ry" or "rz"; one made in code may have none.
    directions = (TORQUE, *(f"m{axis}" for axis in file.structure.axis[1:]))
    found = predict(file.emission, directions, torques, estimate, file.seed)
    profiles = [made.mode.name for made in modes if not made.states]
    if not profiles or not found:
        return found
    said = f"emission requirements: {', '.join(profiles)}: a profile has no steady lines and is not judged."
    return (replace(found[0], notes=(*found[0].notes, said)), *found[1:])
