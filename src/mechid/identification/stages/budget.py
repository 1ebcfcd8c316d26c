"""Budgets of the ladder, in multiples of the work that a complete campaign of the same records takes."""

from __future__ import annotations

from mechid.identification.output_error.problem import Problem
from mechid.identification.search.first_moments import first_window
from mechid.identification.search.settings import SEARCH
from mechid.identification.stages.settings import STAGES
from mechid.simulation.work import RUNS_A_BATCH, work_of_run


def complete_work(problem: Problem) -> int:
    """Return the approximate work of an identification whose mechanism is complete (see `mechid.simulation.work`).

    It includes the multi-start over the first moments, the refinement of its best starts there, and growth and joint
    fits over whole records. The latter count as a number of steps, each a run with derivatives and one without.
    """
    parameters, free = len(problem.space.mechanism.plant.parameters), problem.coordinates.lanes
    first = sum(first_window(t)[1] for t in problem.targets)
    whole = sum(t.samples for t in problem.targets)
    # The starts are simulated in batches, which take less work than single runs.
    drawn = SEARCH.points * work_of_run(first, parameters, 0) // RUNS_A_BATCH
    steps = SEARCH.starts * SEARCH.robust_steps * first + STAGES.complete_steps * whole
    return problem.substeps * (drawn + work_of_run(steps, parameters, 0) + work_of_run(steps, parameters, free))


def effects_budget(problem: Problem) -> int:
    """Return the work up to which rungs free effects."""
    return STAGES.effects_budget * complete_work(problem)


def whole_records_budget(problem: Problem) -> int:
    """Return the work allowed for a comparison of effects over whole records that are all followed already."""
    return STAGES.whole_records_budget * complete_work(problem)


def ladder_budget(problem: Problem) -> int:
    """Return the work at which the ladder ends."""
    return STAGES.ladder_budget * complete_work(problem)
