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
from mechid.identification.effects.augmented import AugmentedModel
from mechid.identification.effects.settings import IN_DIAGNOSIS
from mechid.identification.output_error.problem import Problem
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.first_moments import first_samples
from mechid.identification.search.gates import Growth
from mechid.identification.search.multistart import Candidate
from mechid.identification.search.settings import SEARCH
from mechid.identification.stages.budget import effects_budget
from mechid.identification.stages.families import EVERYTHING, TERMS_AND_RECORDS, Families, Family
from mechid.identification.stages.first_look import (
    FirstLook,
    look_at_first_moments,
    look_past_stall,
    pruned_look,
)
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.term_growth import Reached, free_where_stalled, grow_model, settle, state_so_far
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
    return replace(climb, state=climb.state.saying(BUDGET_SPENT)) if short and not climb.complete else climb


def _look(climb: Climb) -> Climb:
    """Free one family of effects at a time over the first moments, and grow what explains them without the rest."""
    starts = [climb.best.q, *climb.starts[: STAGES.other_starts]]
    tell = _teller(climb, "first moments")
    looks = look_at_first_moments(climb.families, starts, tell, climb.watch.journal)
    climb = replace(climb, looks=tuple(looks))
    if looks and looks[-1].model.added.law:
        law = looks[-1]
        climb = climb.at(_grow(climb, law.model, law.q, escapes=STAGES.law_escapes))
    return climb


def _grow_with_hum(climb: Climb) -> Climb:
    """Grow the mechanism as written with mains hum projected out: the first moments do not tell hum from motion."""
    for model in climb.families.with_hum():
        climb = climb.at(_grow(climb, model, climb.best.q, escapes=STAGES.small_escapes))
        if climb.complete:
            break
    return climb


def _is_unexplained(climb: Climb) -> bool:
    return climb.may_add and not climb.is_explained and not any(look.explains for look in climb.looks)


def _grow_small(climb: Climb) -> Climb:
    """Grow the effects that the first moments need."""
    looks = [look for look in climb.looks if not look.model.added.law]
    best = min(looks, key=lambda look: look.criterion)
    small = pruned_look(climb.families, best, _teller(climb, "first moments"), climb.watch.journal)
    escapes = STAGES.small_escapes if small.model.effects else STAGES.first_escapes
    return climb.at(_grow(climb, small.model, small.q, escapes=escapes))


def _look_again(climb: Climb) -> Climb:
    """Free one family at a time where the furthest growth has stalled, over windows that reach a little past it."""
    furthest = _furthest(climb)
    families = _families(climb, furthest)
    least = {t.name: round(STAGES.past_stall_s * t.base.sample_rate_hz) for t in climb.state.problem.targets}
    windows = {
        t.name: (0, min(t.samples, max(round(STAGES.past_stall * n), n + least[t.name])))
        for t in climb.state.problem.targets
        for n in [furthest.growth.horizons[t.name]]
    }
    tell = _teller(climb, "past the stall")
    journal = climb.watch.journal
    looks = look_past_stall(families, furthest.model, furthest.q, windows, tell, journal)
    for look in looks[: STAGES.second_looks]:
        try:
            small = pruned_look(families, look, tell, journal, windows)
        except WorkSpentError:
            break  # what has been grown so far is kept
        climb = climb.at(_grow(climb, small.model, small.q, escapes=STAGES.small_escapes))
        if climb.complete:
            break
    return climb


def _free(family: Family) -> Callable[[Climb], Climb]:
    """Return the rung that frees a family where the furthest growth has stalled, and grows what is needed there."""

    def attempt(climb: Climb) -> Climb:
        furthest = _furthest(climb)
        _, small = free_where_stalled(climb.watch, _families(climb, furthest), furthest, family)
        return climb.at(_grow(climb, small.model, small.q, escapes=STAGES.small_escapes))

    return attempt


def _grow_wide(climb: Climb) -> Climb:
    """Grow with all effects free, from where the furthest growth has stalled."""
    furthest = _furthest(climb)
    wide, _ = free_where_stalled(climb.watch, _families(climb, furthest), furthest, EVERYTHING)
    return climb.at(_grow(climb, wide.model, wide.q, escapes=STAGES.small_escapes))


def _plain(climb: Climb) -> Reached:
    """Return the growth of the mechanism as written."""
    written = climb.state.problem
    none = Growth(climb.best.q, {t.name: first_samples(t) for t in written.targets}, False, 0)
    return Reached(climb.families.bare, climb.growth or none)


def _furthest(climb: Climb) -> Reached:
    """Return the furthest growth."""
    plain, reached = _plain(climb), climb.reached
    return plain if reached is None else max((plain, reached), key=lambda one: one.share)


def _families(climb: Climb, reached: Reached) -> Families:
    """Return the families with the law of a growth."""
    law = reached.model.added.law
    return next((climb.families.with_law(one) for one in climb.families.laws() if one.name == law), climb.families)


def _grow(climb: Climb, model: AugmentedModel, q: FloatArray, *, escapes: int) -> Reached:
    return grow_model(climb.watch, model, q, climb.seed, escapes=escapes, leaps=STAGES.small_leaps)


def _teller(climb: Climb, stage: str) -> Callable[[str], None]:
    return lambda line: climb.watch.tell(stage, line)


def _can_free(climb: Climb) -> bool:
    return climb.may_add


def _keep_furthest(climb: Climb) -> Climb:
    """Keep the growth that has come furthest, with its effects, where no rung has come to the ends of all records."""
    reached = climb.reached
    assert climb.growth is not None
    assert reached is not None
    state = climb.watch.note(state_so_far(climb.state, reached))
    return replace(climb, state=state, growth=replace(reached.growth, q=state.q))


def _came_much_further(climb: Climb) -> bool:
    reached, growth = climb.reached, climb.growth
    if reached is None or growth is None or len(reached.model.effects) > IN_DIAGNOSIS.few:
        return False  # many effects together imitate whatever it is that is missing
    return reached.share > STAGES.much_further * growth.reached(climb.state.problem)


def _rung(name: str, applies: Callable[[Climb], bool], attempt: Callable[[Climb], Climb]) -> Rung:
    return Rung(name, applies, attempt, effects_budget)


EFFECTS = (
    _rung("effects named by the first moments", lambda climb: climb.may_add and not climb.is_explained, _look),
    _rung("mains hum", _is_unexplained, _grow_with_hum),
    _rung("those needed there, grown", lambda climb: any(not l.model.added.law for l in climb.looks), _grow_small),
    _rung("effects named where that stalls", _can_free, _look_again),
    _rung("effects freed where that stalls", _can_free, _free(TERMS_AND_RECORDS)),
    _rung("all effects freed where that stalls", _can_free, _free(EVERYTHING)),
    _rung("all effects freed where that stalls, again", _can_free, _free(EVERYTHING)),
    _rung("grown with all effects", _can_free, _grow_wide),
)
"""Rungs that add effects which the mechanism or its records may have."""
FURTHEST = Rung("the furthest that was reached", _came_much_further, _keep_furthest)
"""The last rung, which keeps what the others have come to."""
