"""The ladder: named rungs by which a search comes to the ends of all records, tried in order until one does.

A rung begins from the furthest that any before it has come to; nothing that was reached is thrown away. The names of
those tried are kept, so that a report can say how the search arrived (`outcome.path` in estimate.json).
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
from mechid.identification.stages.term_growth import Reached, settle
from mechid.identification.stages.watch import Watch
from mechid.simulation.work import WorkSpentError, counted, uncounted

BUDGET_SPENT = (
    "all records: the search for what is missing has ended at its budget, as many times the work of a search whose "
    f"mechanism lacks nothing as it may take ({STAGES.effects_budget} for effects, {STAGES.ladder_budget} in all)"
)


@dataclass(frozen=True, eq=False)
class Climb:
    """Where a search stands on the ladder.

    Attributes
    ----------
    watch : Watch
    campaign : Campaign
    seed : int
    state : SearchState
        Of the mechanism as written, until a rung has followed all records.
    best : Candidate
        The best refined start of the mechanism as written.
    starts : tuple of (n,)
        The best starts as they were drawn.
    growth : Growth or None
        Of the mechanism as written; that of the state where this follows all records.
    looks : tuple of FirstLook
        What families of effects leave of the first moments, the best one last.
    reached : Reached or None
        The furthest growth with effects free.
    found : iterator of Candidate
        Further refined starts.
    raised : (SearchState, Growth) or None
        What a raised noise level comes to.
    tried : tuple of str
        Names of the rungs so far.
    shared : dict of Problem to Families
        Those put together so far.
    """

    watch: Watch
    campaign: Campaign
    seed: int
    state: SearchState
    best: Candidate
    starts: tuple[FloatArray, ...] = ()
    growth: Growth | None = None
    looks: tuple[FirstLook, ...] = ()
    reached: Reached | None = None
    found: Iterator[Candidate] = field(default_factory=lambda: iter(()))
    raised: tuple[SearchState, Growth] | None = None
    tried: tuple[str, ...] = ()
    shared: dict[Problem, Families] = field(default_factory=dict, repr=False)

    @property
    def at_raised(self) -> tuple[SearchState, Growth]:
        """State and growth at a raised noise level; as they are where none was raised."""
        assert self.growth is not None
        return self.raised or (self.state, self.growth)

    @property
    def families(self) -> Families:
        """Effects that may be beside the mechanism as written, put together once for all rungs."""
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
        """Whether effects may be added at all."""
        return self.campaign.options.terms or self.campaign.options.disturbances != "none"

    def at(self, reached: Reached) -> Climb:
        """Return the climb with a further growth; where it follows all records, with what of it they need."""
        best = reached if self.reached is None or reached.share > self.reached.share else self.reached
        if reached.growth.complete:
            with uncounted():  # what has arrived is not lost for want of a last fit
                settled = settle(self.watch, self.state, reached, self.seed)
            if settled is not None:
                return replace(self, state=settled[0], growth=settled[1], reached=best)
        return replace(self, reached=best)


@dataclass(frozen=True)
class Rung:
    """One way to come further.

    Attributes
    ----------
    name : str
        As estimate.json and the report have it.
    applies : callable
        Whether it can help.
    attempt : callable
        Returns the climb after it.
    budget : callable or None
        Work of the whole ladder, of a problem as written, at which it ends, its climb that before it; None of a rung
        that is tried to its end in any case.
    """

    name: str
    applies: Callable[[Climb], bool]
    attempt: Callable[[Climb], Climb]
    budget: Callable[[Problem], int] | None = None


def climb_ladder(climb: Climb, rungs: tuple[Rung, ...]) -> Climb:
    """Return the climb after the rungs that apply, in order, until all records are followed to their ends.

    A rung whose budget is spent is not tried; at work, it ends there.
    """
    written, short = climb.state.problem, False
    with counted() as work:
        for number, rung in enumerate(rungs, 1):
            if climb.complete:
                break
            work.limit = rung.budget(written) if rung.budget else math.inf
            short = short or work.is_spent
            if not work.is_spent and rung.applies(climb):
                climb.watch.tell("ladder", f"rung {number} of {len(rungs)}: {rung.name}")
                climb = replace(climb, tried=(*climb.tried, rung.name))
                with suppress(WorkSpentError):
                    climb = rung.attempt(climb)
                short = short or work.is_spent
    return replace(climb, state=climb.state.with_warnings(BUDGET_SPENT)) if short and not climb.complete else climb


def growth_as_written(climb: Climb) -> Reached:
    """Return the growth of the mechanism as written."""
    written = climb.state.problem
    none = Growth(climb.best.q, {t.name: first_samples(t) for t in written.targets}, False, 0)
    return Reached(climb.families.bare, climb.growth or none)


def furthest_growth(climb: Climb) -> Reached:
    """Return the furthest growth."""
    plain, reached = growth_as_written(climb), climb.reached
    return plain if reached is None else max((plain, reached), key=lambda one: one.share)
