"""Findings of a budget, one line each with a remedy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from mechid.analysis.residual_file import FILE_NAME as RESIDUAL_NAME
from mechid.budgets.budget_file import BudgetFile
from mechid.budgets.flying_mechanism import Estimate
from mechid.budgets.mode_budget import ModeBudget
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.settings import RESIDUALS
from mechid.budgets.side_source import SideSource
from mechid.budgets.steadiness import steadiness_words
from mechid.plant.flight import moving_base_objection
from mechid.structure import Modes


def findings(
    file: BudgetFile, estimate: Estimate, modes: Sequence[ModeBudget], side: SideSource | None = None
) -> Iterator[str]:
    """Yield the warnings of a budget."""
    yield from (f"{file.structure.name}: {line}" for line in file.structure.warnings)
    if estimate.outcome:
        yield f"{file.estimate.name}: {estimate.outcome} A budget based on it is no more reliable"
    yield from _doubtful_values(file, estimate)
    yield from _free_body(file)
    if estimate.residual is None:
        yield (
            f"{file.estimate.name}: there is no {RESIDUAL_NAME} of a torque record beside it, so that what the model "
            "lacks does not fly: mechid report makes it anew from records of the torque"
        )
    if side is not None:
        yield from _side_findings(file, side, modes)
    if objection := moving_base_objection(estimate.mechanism):
        yield objection
    for made in modes:
        yield from _excluded_lines(made.mode)
        if made.responses:
            yield from _steady_findings(file, made)
            yield from _residual_coverage(estimate, made)
            yield from steadiness_words(made)
        joined = bool(made.two_way) or made.two_way_course is not None
        if not joined and made.loop_gain > RESIDUALS.suffices:
            yield (
                f'mode "{made.mode.name}": |receptance x dynamic stiffness| reaches {made.loop_gain:.2g}, so that '
                "one-way is not enough: give the structure's modes for a two-way result"
            )


def _side_findings(file: BudgetFile, side: SideSource, modes: Sequence[ModeBudget]) -> Iterator[str]:
    """Yield the components that are not included, or only as a bound."""
    if side.absent:
        needs = ", ".join(dict.fromkeys(side.absent.values()))
        yield (
            f"{', '.join(side.absent)}: measured beside the torque and not counted: {file.structure.name} has no "
            f"response to {needs} at the interface. Give the structure with these directions"
        )
    for made in modes if side.flying_components else ():
        yield from _side_of_mode(side, made)


def _side_of_mode(side: SideSource, made: ModeBudget) -> Iterator[str]:
    name, command = made.mode.name, made.mode.command
    what = "the forces and moments beside the torque"
    if made.course is not None:
        yield f'mode "{name}": {what} are known at steady rates alone; its profile is that of the torque'
        return
    here = [(r.state.rate, r.side.here) for r in made.responses if r.side is not None]
    far = [rate for rate, at in here if at.far]
    if far:
        low, high = side.rates(command)
        yield (
            f'mode "{name}": at {len(far)} of {len(here)} rates, {min(far):.4g} to {max(far):.4g} steps/s, no record '
            f"is near: {what} count by magnitude, the larger of the rates beside; {low:.4g} to {high:.4g} steps/s were "
            "measured"
        )
    if any(at.outside for _, at in here):
        yield f'mode "{name}": above the rates measured, {what} are taken to grow with the rate squared'
    if not side.has_same_stepping(command):
        yield (
            f'mode "{name}": no record with {what} is stepped as it is ({command.stepping}): those of the others '
            "count, by magnitude"
        )


def _excluded_lines(mode: OperatingMode) -> Iterator[str]:
    """Name the line of the microsteps if it lies above the highest frequency."""
    if mode.microstep_hz > mode.highest_hz:
        order = mode.command.steps_per_full_step
        yield (
            f'mode "{mode.name}": lines above highest_hz = {mode.highest_hz:.6g} are not counted, among them '
            f"that of the microsteps, order {order}, which reaches {mode.microstep_hz:.6g} Hz"
        )


def _doubtful_values(file: BudgetFile, estimate: Estimate) -> Iterator[str]:
    """Yield flight values that may be meant in another unit."""
    declared = estimate.mechanism.plant.declarations
    for name, value in file.flight.values.items():
        if name in declared and (doubt := declared[name].doubt(value)):
            yield f"{file.flight.place}.values: {name} = {value:.9g}: {doubt}"


def _free_body(file: BudgetFile) -> Iterator[str]:
    model = file.structure.model
    slow = [r.name for r in file.requirements if r.index.row.needs_held_body]
    if isinstance(model, Modes) and model.rigid.any() and slow:
        yield (
            f"{file.structure.name}: its rigid body is free, and {', '.join(slow)} asks for absolute or drift errors; "
            "give [structure] attitude_control"
        )


def _residual_coverage(estimate: Estimate, made: ModeBudget) -> Iterator[str]:
    """Yield where the unmodelled torque is known less well than its bound indicates."""
    source, mode = estimate.residual, made.mode
    measured = source.measured_range(mode.command) if source else None
    if source is None or measured is None:
        return
    outside = [r.residual.rate for r in made.responses if r.residual is not None and r.residual.outside]
    if outside:
        yield (
            f'mode "{mode.name}": {min(outside):.4g} to {max(outside):.4g} steps/s are outside the {measured[0]:.4g} '
            f"to {measured[1]:.4g} steps/s of the records: what the model lacks there is not known; above, it is taken "
            "to grow with the rate squared. Record the torque at these rates"
        )
    if not source.has_same_stepping(mode.command):
        yield (
            f'mode "{mode.name}": no record is stepped as it is ({mode.command.stepping}); what the model lacks is '
            "that of the others. Record the torque in this stepping"
        )


def _steady_findings(file: BudgetFile, made: ModeBudget) -> Iterator[str]:
    name, at = made.mode.name, made.responses[made.worst]
    if at.uncovered > RESIDUALS.uncovered:
        low, high = file.structure.coverage_hz
        share = 100.0 * at.uncovered
        yield f'mode "{name}": {share:.2g} % of its torque is outside {low:.4g} to {high:.4g} Hz, not counted'
    unsteady = max(made.responses, key=lambda r: r.state.unsteady).state
    if unsteady.unsteady > RESIDUALS.unsteady:
        yield (
            f'mode "{name}": at {unsteady.rate:.6g} steps/s {100.0 * unsteady.unsteady:.2g} % of the torque does not '
            "repeat with the steps; it counts as random"
        )
