"""The ladder: named rungs by which a search comes to the ends of all records, tried in order until one does.

A rung begins from the furthest that any before it has come to; nothing that was reached is thrown away. The names of
those tried are kept, so that a report can say how the search arrived (`outcome.path` in estimate.json).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice

from mechid.arrays import FloatArray
from mechid.campaign import Campaign
from mechid.identification.effects.augmented import AugmentedModel
from mechid.identification.effects.settings import IN_DIAGNOSIS
from mechid.identification.output_error.problem import Windows
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.first_moments import first_samples
from mechid.identification.search.gates import Growth
from mechid.identification.search.multistart import Candidate
from mechid.identification.search.settings import SEARCH
from mechid.identification.stages.compared_effects import (
    look_at_first_moments,
    look_at_hum,
    look_from_other_starts,
    look_past_stall,
)
from mechid.identification.stages.families import EVERYTHING, TERMS_AND_RECORDS, Families, Family
from mechid.identification.stages.first_look import FirstLook, pruned_look, refined_look
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.single_effects import look_at_periods
from mechid.identification.stages.term_growth import Reached, free_where_stalled, grow_model, settle, state_so_far
from mechid.identification.stages.watch import Watch


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
    spent : int
        Rounds of all growths with effects free, each times its coordinates.
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
    spent: int = 0

    @property
    def at_raised(self) -> tuple[SearchState, Growth]:
        """State and growth at a raised noise level; as they are where none was raised."""
        assert self.growth is not None
        return self.raised or (self.state, self.growth)

    @cached_property
    def families(self) -> Families:
        """Effects that may be beside the mechanism as written."""
        return Families(self.state.problem, self.campaign)

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
        spent = self.spent + reached.growth.rounds * reached.problem.size
        if reached.growth.complete:
            settled = settle(self.watch, self.state, reached, self.seed)
            if settled is not None:
                return replace(self, state=settled[0], growth=settled[1], reached=best, spent=spent)
        return replace(self, reached=best, spent=spent)


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
    """

    name: str
    applies: Callable[[Climb], bool]
    attempt: Callable[[Climb], Climb]


def climb_ladder(climb: Climb, rungs: tuple[Rung, ...]) -> Climb:
    """Return the climb after the rungs that apply, in order, until all records are followed to their ends."""
    for number, rung in enumerate(rungs, 1):
        if climb.complete:
            break
        if rung.applies(climb):
            climb.watch.tell("ladder", f"rung {number} of {len(rungs)}: {rung.name}")
            climb = rung.attempt(replace(climb, tried=(*climb.tried, rung.name)))
    return climb


def _look(climb: Climb) -> Climb:
    """Free one family of effects at a time over the first moments, from the best start."""
    looks = look_at_first_moments(climb.families, climb.best.q, _teller(climb, "first moments"), climb.watch.journal)
    return _grow_law(replace(climb, looks=tuple(looks)))


def _look_elsewhere(climb: Climb) -> Climb:
    """Free them from other starts."""
    tell, others = _teller(climb, "first moments"), climb.starts[: STAGES.other_starts]
    looks = look_from_other_starts(climb.families, climb.looks, climb.best.q, others, tell, climb.watch.journal)
    return _grow_law(replace(climb, looks=tuple(looks)))


def _grow_law(climb: Climb) -> Climb:
    """Grow the law that explains most of the first moments, where one does."""
    law = climb.looks[-1] if climb.looks else None
    if law is None or not law.model.added.law:
        return climb
    return climb.at(_grow(climb, law.model, law.q, escapes=STAGES.law_escapes))


def _grow_with_hum(climb: Climb) -> Climb:
    """Grow the mechanism as written with mains hum projected out: the first moments do not tell hum from motion.

    Its frequency is read again where that stalls, from what is followed by then, as long as that leads further.
    """
    families, none, tell = climb.families, _plain(climb).growth, _teller(climb, "mains hum")
    points = [climb.best.q, *climb.starts[: STAGES.other_starts]]
    for grid_hz in families.unseen_grids:
        look = look_at_hum(families, grid_hz, points, tell, climb.watch.journal)
        if look is None:
            continue
        q, horizons, share = look.q, none.horizons, 0.0
        while (model := families.with_hum(grid_hz, q, horizons)) and not climb.complete:
            reached = _grow(climb, model, q, escapes=STAGES.small_escapes)
            if reached.growth.complete:
                whole = families.with_hum(grid_hz, reached.q, reached.growth.horizons)
                reached = replace(reached, model=whole or model)
            climb = climb.at(reached)
            if reached.share < STAGES.hum_further * share:
                break
            q, horizons, share = reached.q, reached.growth.horizons, reached.share
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
    return climb.at(_grow(climb, small.model, small.q, escapes=STAGES.small_escapes))


def _look_again(climb: Climb) -> Climb:
    """Compare effects where the furthest growth has stalled, and again where that comes much further."""
    tune = True
    while not climb.complete and _can_free(climb):
        before = furthest_growth(climb).share
        climb = _look_past(climb, tune=tune)
        if furthest_growth(climb).share < STAGES.look_further * before:
            break
        tune = False
    return climb


def _look_past(climb: Climb, *, tune: bool) -> Climb:
    """Free one family at a time over windows a little past a stall, and grow until one comes much further."""
    furthest = furthest_growth(climb)
    families = _families(climb, furthest)
    windows = _windows_past(furthest)
    tell = _teller(climb, "past the stall")
    journal = climb.watch.journal
    here = refined_look(furthest.model, furthest.q, journal, windows, STAGES.second_steps)
    for look in islice(look_past_stall(families, here, windows, tell, journal, tune=tune), STAGES.second_looks):
        small = pruned_look(families, look, tell, journal, windows)
        grown = _grow(climb, small.model, small.q, escapes=STAGES.small_escapes)
        climb = climb.at(with_periods_seen(climb, families, grown))
        if climb.complete or furthest_growth(climb).share >= STAGES.look_further * furthest.share:
            break
    return climb


def _windows_past(reached: Reached) -> Windows:
    """Return windows that reach a little past what a growth follows."""
    found = {}
    for target in reached.problem.targets:
        followed = reached.growth.horizons[target.name]
        least = followed + round(STAGES.past_stall_s * target.base.sample_rate_hz)
        found[target.name] = (0, min(target.samples, max(round(STAGES.past_stall * followed), least)))
    return found


def with_periods_seen(climb: Climb, families: Families, reached: Reached) -> Reached:
    """Return a growth, grown again where its longer windows tell another order of friction over the angle."""
    slow = next(filter(families.is_slow, reached.model.effects), None)
    if slow is None:
        return reached
    tell, windows = _teller(climb, "past the stall"), _windows_past(reached)
    look = look_at_periods(families, reached.model, reached.q, slow, windows, tell, climb.watch.journal)
    if look.model.effects == reached.model.effects:
        return reached
    again = _grow(climb, look.model, look.q, escapes=STAGES.small_escapes)
    return again if again.share >= reached.share else reached


def _free(family: Family) -> Callable[[Climb], Climb]:
    """Return the rung that frees a family where the furthest growth has stalled, and grows what is needed there."""

    def attempt(climb: Climb) -> Climb:
        furthest = furthest_growth(climb)
        _, small = free_where_stalled(climb.watch, _families(climb, furthest), furthest, family)
        return climb.at(_grow(climb, small.model, small.q, escapes=STAGES.small_escapes))

    return attempt


def _grow_wide(climb: Climb) -> Climb:
    """Grow with all effects free, from where the furthest growth has stalled."""
    furthest = furthest_growth(climb)
    wide, _ = free_where_stalled(climb.watch, _families(climb, furthest), furthest, EVERYTHING)
    return climb.at(_grow(climb, wide.model, wide.q, escapes=STAGES.small_escapes))


def _plain(climb: Climb) -> Reached:
    """Return the growth of the mechanism as written."""
    written = climb.state.problem
    none = Growth(climb.best.q, {t.name: first_samples(t) for t in written.targets}, False, 0)
    return Reached(climb.families.bare, climb.growth or none)


def furthest_growth(climb: Climb) -> Reached:
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
    return climb.may_add and climb.spent < STAGES.most_work


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


NAMED_EFFECTS = (
    Rung("mains hum", _is_unexplained, _grow_with_hum),
    Rung("effects named by the first moments", lambda climb: climb.may_add and not climb.is_explained, _look),
    Rung("effects named by the first moments of other starts", _is_unexplained, _look_elsewhere),
    Rung("those needed there, grown", lambda climb: any(not l.model.added.law for l in climb.looks), _grow_small),
)
"""Rungs that add the effects which the first moments name."""
FREED_EFFECTS = (
    Rung("effects named where that stalls", _can_free, _look_again),
    Rung("effects freed where that stalls", _can_free, _free(TERMS_AND_RECORDS)),
    Rung("all effects freed where that stalls", _can_free, _free(EVERYTHING)),
    Rung("all effects freed where that stalls, again", _can_free, _free(EVERYTHING)),
    Rung("grown with all effects", _can_free, _grow_wide),
)
"""Rungs that add effects where the furthest growth has stalled."""
FURTHEST = Rung("the furthest that was reached", _came_much_further, _keep_furthest)
"""The last rung, which keeps what the others have come to."""
