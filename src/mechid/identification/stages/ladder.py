"""Ladder of a search: named rungs that are tried in order until all records are followed to their ends.

A rung starts from the furthest state of any rung before it, and nothing reached is discarded. The names of the rungs
tried are kept, so that a report can state the path of the search (`outcome.path` in estimate.json).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace

from mechid.arrays import FloatArray
from mechid.campaign import Campaign
from mechid.identification.output_error.problem import Problem
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.first_moments import first_samples
from mechid.identification.search.gates import Growth
from mechid.identification.search.multistart import Candidate
from mechid.identification.search.settings import SEARCH
from mechid.identification.stages.families import Families
from mechid.identification.stages.first_look import FirstLook
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.term_growth import GrownModel, settle
from mechid.identification.stages.watch import Watch
from mechid.simulation.work import WorkSpentError, suspend_counting, work_counter

BUDGET_SPENT = (
    "all records: the search for missing effects has ended at its budget, a multiple of the work of a search whose "
    f"mechanism is complete ({STAGES.effects_budget} times for effects, {STAGES.ladder_budget} times in all)"
)


@dataclass(frozen=True, eq=False)
class Climb:
    """State of a search on the ladder.

    Attributes
    ----------
    watch : Watch
    campaign : Campaign
    seed : int
    state : SearchState
        State of the mechanism as written, until a rung has followed all records.
    best : Candidate
        Best refined start of the mechanism as written.
    starts : tuple of (n,)
        Best starts before their refinement.
    growth : Growth or None
        Growth of the mechanism as written; that of the state once all records are followed.
    looks : tuple of FirstLook
        Looks at families of effects over the first moments, the best one last.
    reached : GrownModel or None
        Furthest growth with effects free.
    found : iterator of Candidate
        Further refined starts.
    raised : (SearchState, Growth) or None
        State and growth at a raised noise level.
    tried : tuple of str
        Names of the rungs so far.
    shared : dict of Problem to Families
        Families built so far.
    """

    watch: Watch
    campaign: Campaign
    seed: int
    state: SearchState
    best: Candidate
    starts: tuple[FloatArray, ...] = ()
    growth: Growth | None = None
    looks: tuple[FirstLook, ...] = ()
    reached: GrownModel | None = None
    found: Iterator[Candidate] = field(default_factory=lambda: iter(()))
    raised: tuple[SearchState, Growth] | None = None
    tried: tuple[str, ...] = ()
    shared: dict[Problem, Families] = field(default_factory=dict, repr=False)

    @property
    def state_at_raised_noise(self) -> tuple[SearchState, Growth]:
        """State and growth at a raised noise level, or at the known one if none was raised."""
        assert self.growth is not None
        return self.raised or (self.state, self.growth)

    @property
    def families(self) -> Families:
        """Effects that may be added to the mechanism as written, shared by all rungs."""
        problem = self.state.problem
        if problem not in self.shared:
            self.shared[problem] = Families(problem, self.campaign)
        return self.shared[problem]

    @property
    def complete(self) -> bool:
        """Whether all records are followed to their ends."""
        return self.growth is not None and self.growth.complete

    @property
    def is_explained(self) -> bool:
        """Whether the best start leaves no more than noise of the first moments."""
        samples = sum(first_samples(t) * len(t.channels) for t in self.state.problem.targets)
        return self.best.cost < SEARCH.explained * samples

    @property
    def may_add(self) -> bool:
        """Whether the campaign allows additional effects."""
        return self.campaign.options.terms or self.campaign.options.disturbances != "none"

    def with_growth(self, reached: GrownModel) -> Climb:
        """Return the climb with a further growth; if it follows all records, with the needed part of its effects."""
        best = reached if self.reached is None or reached.share > self.reached.share else self.reached
        if reached.growth.complete:
            # A complete growth must not be lost because the budget forbids a last fit.
            with suspend_counting():
                settled = settle(self.watch, self.state, reached, self.seed)
            if settled is not None:
                return replace(self, state=settled[0], growth=settled[1], reached=best)
        return replace(self, reached=best)


@dataclass(frozen=True)
class Rung:
    """Single attempt to follow the records further.

    Attributes
    ----------
    name : str
        Name in estimate.json and in the report.
    applies : callable
        Tells whether it can help.
    attempt : callable
        Returns the climb after it.
    budget : callable or None
        Returns, for a problem as written, the work of the whole ladder at which the rung ends, keeping the climb before
        it; None for a rung without limit.
    """

    name: str
    applies: Callable[[Climb], bool]
    attempt: Callable[[Climb], Climb]
    budget: Callable[[Problem], int] | None = None


def climb_ladder(climb: Climb, rungs: tuple[Rung, ...]) -> Climb:
    """Return the climb after the rungs that apply, in order, until all records are followed to their ends.

    A rung whose budget is spent is skipped; a running one ends when it is spent.
    """
    written, short = climb.state.problem, False
    with work_counter() as work:
        for number, rung in enumerate(rungs, 1):
            if climb.complete:
                break
            # The limit applies to the work of all rungs so far.
            work.limit = rung.budget(written) if rung.budget else math.inf
            short = short or work.is_spent
            if not work.is_spent and rung.applies(climb):
                climb.watch.tell("ladder", f"rung {number} of {len(rungs)}: {rung.name}")
                climb = replace(climb, tried=(*climb.tried, rung.name))
                with suppress(WorkSpentError):
                    climb = rung.attempt(climb)
                short = short or work.is_spent
    return replace(climb, state=climb.state.with_warnings(BUDGET_SPENT)) if short and not climb.complete else climb


def growth_as_written(climb: Climb) -> GrownModel:
    """Return the growth of the mechanism as written."""
    written = climb.state.problem
    none = Growth(climb.best.q, {t.name: first_samples(t) for t in written.targets}, False, 0)
    return GrownModel(climb.families.bare, climb.growth or none)


def furthest_growth(climb: Climb) -> GrownModel:
    """Return the growth that follows most samples, as written or with effects."""
    plain, reached = growth_as_written(climb), climb.reached
    return plain if reached is None else max((plain, reached), key=lambda one: one.share)
