"""What is odd about a budget, each said in a line with its remedy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from mechid.budget.budget_file import BudgetFile
from mechid.budget.coupling import SUFFICES
from mechid.budget.flying_mechanism import Estimate
from mechid.budget.mode_budget import ModeBudget
from mechid.budget.operating_mode import OperatingMode
from mechid.budget.steadiness import told
from mechid.plant.flight import moving_base_objection
from mechid.structure import Modes

TOLD_UNCOVERED, TOLD_UNSTEADY = 0.05, 0.05


def findings(file: BudgetFile, estimate: Estimate, modes: Sequence[ModeBudget]) -> Iterator[str]:
    """Yield the warnings of a budget."""
    yield from (f"{file.structure.name}: {line}" for line in file.structure.warnings)
    if estimate.outcome:
        yield f"{file.estimate.name}: {estimate.outcome} A budget of it is worth no more"
    yield from _free_body(file)
    if objection := moving_base_objection(estimate.mechanism):
        yield objection
    for made in modes:
        yield from _cut(made.mode)
        if made.responses:
            yield from _steady(file, made)
            yield from told(made)
        joined = bool(made.two_way) or made.two_way_course is not None
        if not joined and made.loop_gain > SUFFICES:
            yield (
                f'mode "{made.mode.name}": |receptance x dynamic stiffness| reaches {made.loop_gain:.2g}, so that '
                "one-way is not enough: give the structure's modes for a two-way result"
            )


def _cut(mode: OperatingMode) -> Iterator[str]:
    """Name the line of the microsteps where it is above what counts."""
    if mode.microstep_hz > mode.highest_hz:
        order = mode.command.steps_per_full_step
        yield (
            f'mode "{mode.name}": lines above highest_hz = {mode.highest_hz:.6g} are not counted, among them '
            f"that of the microsteps, order {order}, which reaches {mode.microstep_hz:.6g} Hz"
        )


def _free_body(file: BudgetFile) -> Iterator[str]:
    model = file.structure.model
    slow = [r.name for r in file.requirements if r.index.row.needs_held_body]
    if isinstance(model, Modes) and model.rigid.any() and slow:
        yield (
            f"{file.structure.name}: its rigid body is free, and {', '.join(slow)} asks for absolute or drift errors; "
            "give [structure] attitude_control"
        )


def _steady(file: BudgetFile, made: ModeBudget) -> Iterator[str]:
    name, at = made.mode.name, made.responses[made.worst]
    if at.uncovered > TOLD_UNCOVERED:
        low, high = file.structure.coverage_hz
        share = 100.0 * at.uncovered
        yield f'mode "{name}": {share:.2g} % of its torque is outside {low:.4g} to {high:.4g} Hz, not counted'
    unsteady = max(made.responses, key=lambda r: r.state.unsteady).state
    if unsteady.unsteady > TOLD_UNSTEADY:
        yield (
            f'mode "{name}": at {unsteady.rate:.6g} steps/s {100.0 * unsteady.unsteady:.2g} % of the torque does not '
            "repeat with the steps; it counts as random"
        )
