"""Rungs of the ladder that add effects, and the last rung, which keeps the furthest growth."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import islice

from mechid.arrays import FloatArray
from mechid.identification.effects.augmented import AugmentedModel
from mechid.identification.effects.settings import IN_DIAGNOSIS
from mechid.identification.output_error.problem import Windows
from mechid.identification.stages.budget import effects_budget
from mechid.identification.stages.compared_effects import (
    hum_helps,
    look_at_families,
    look_at_first_moments,
    look_at_hum,
    look_at_second_effects,
    look_past_stall,
)
from mechid.identification.stages.families import TERMS_AND_RECORDS, Families
from mechid.identification.stages.first_look import FirstLook, first_windows, fit_look, prune_look
from mechid.identification.stages.ladder import Climb, Rung, furthest_growth, growth_as_written
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.single_effects import look_at_periods, look_at_singles
from mechid.identification.stages.start_growth import grow_starts, refine_best_start, refine_more_starts
from mechid.identification.stages.term_growth import GrownModel, free_family_at_stall, grow_model, unfinished_state
from mechid.simulation.work import WorkSpentError

KINDS_LISTED = 2
"""Kinds of single effects that are listed: of records and of terms."""


def _free_single(climb: Climb) -> Climb:
    """Free one effect at a time over the first moments, from the best start."""
    looks = look_at_first_moments(climb.families, climb.best.q, _teller(climb, "first moments"), climb.watch.journal)
    return _grow_law(replace(climb, looks=tuple(looks)))


def _free_single_past_stall(climb: Climb) -> Climb:
    """Free one listed effect at a time past the stall of the furthest growth, and grow one that explains it."""
    furthest = furthest_growth(climb)
    windows, tell, journal = _windows_past(furthest), _teller(climb, "past the stall"), climb.watch.journal
    here = fit_look(furthest.model, furthest.q, journal, windows, STAGES.second_steps)
    families = _families_with_law(climb, furthest)
    singles = look_at_singles(families, here.model, here.q, windows, tell, journal, STAGES.second_steps)
    for kind in islice(singles, KINDS_LISTED):
        look = min(kind, key=lambda one: one.criterion, default=here)
        if look is not here and look.explains_misfit_of(here):
            small = prune_look(families, look, tell, journal, windows)
            return climb.with_growth(_grow(climb, small.model, small.q, escapes=STAGES.small_escapes))
    return climb


def _grow_from_more_starts(climb: Climb) -> Climb:
    """Grow the mechanism as written from the best start behind the usual ones, if it explains more than those."""
    start = refine_more_starts(climb.watch, climb.state, climb.seed)
    if start is None or start.cost >= climb.best.cost:
        return climb
    problem, before = climb.state.problem, growth_as_written(climb).growth
    growth = grow_starts(climb.watch, climb.state, iter([start]), climb.seed, escapes=STAGES.first_escapes)
    better = growth.followed_share(problem) > before.followed_share(problem)
    return replace(climb, best=start, growth=growth) if better else climb


def _free_second(climb: Climb) -> Climb:
    """Free one more effect over the first moments in addition to the best one."""
    looks = look_at_second_effects(climb.families, climb.looks, _teller(climb, "first moments"), climb.watch.journal)
    climb = _grow_law(replace(climb, looks=tuple(looks)))
    best = min(climb.looks, key=lambda look: look.criterion)
    if climb.complete or best.explains:
        return climb
    base = best.model.lay_out(climb.families.plain)
    first = {name: stop for name, (_, stop) in first_windows(base.problem).items()}
    return _grow_beside_hum(climb, base, [base.point_of(best.model, best.q)], first)


def _free_families(climb: Climb) -> Climb:
    """Free the effects of a kind together over the first moments, from the best start."""
    tell, journal = _teller(climb, "first moments"), climb.watch.journal
    looks = look_at_families(climb.families, climb.looks, climb.best.q, tell, journal)
    return replace(climb, looks=tuple(looks))


def _grow_law(climb: Climb) -> Climb:
    """Grow the law that explains most of the first moments, if there is one; compare listed effects where it stalls."""
    law = climb.looks[-1] if climb.looks else None
    if law is None or not law.model.added.law or law.cost_per_sample >= STAGES.growable:
        return climb
    escapes, leaps = (STAGES.law_escapes, STAGES.small_leaps) if law.explains else (0, 0)
    climb = climb.with_growth(_grow(climb, law.model, law.q, escapes=escapes, leaps=leaps))
    return climb if climb.complete or climb.reached is not furthest_growth(climb) else _free_single_past_stall(climb)


def _grow_with_hum(climb: Climb) -> Climb:
    """Grow the mechanism as written with mains hum projected out.

    The first moments do not distinguish hum from motion. Where the records show the hum, the starts are drawn anew
    without it, since those drawn with it in the records imitate it.
    """
    for grid_hz in climb.families.seen_grids:
        climb = _grow_from_starts_beside_hum(climb, grid_hz)
    if climb.complete:
        return climb
    points = [climb.best.q, *climb.starts[: STAGES.other_starts]]
    return _grow_beside_hum(climb, climb.families.bare, points, growth_as_written(climb).growth.horizons)


def _grow_from_starts_beside_hum(climb: Climb, grid_hz: float) -> Climb:
    """Grow the mechanism as written from new starts with hum of a grid projected out, if that explains most of it."""
    families, bare = climb.families, climb.families.bare
    first = {name: stop for name, (_, stop) in first_windows(families.plain).items()}
    model = families.with_hum(bare, grid_hz, climb.best.q, first)
    start = None if model is None else refine_best_start(climb.watch, model.problem, climb.seed)
    if model is None or start is None:
        return climb
    plain, look = fit_look(bare, climb.best.q, climb.watch.journal), fit_look(model, start.q, climb.watch.journal)
    left = f"{look.cost_per_sample:.3g} of the noise left, {plain.cost_per_sample:.3g} without"
    climb.watch.tell("mains hum", f"{model.name}, new starts: {left}")
    return _grow_hum(climb, bare, grid_hz, look, first) if hum_helps(look, plain) else climb


def _grow_beside_hum(
    climb: Climb, base: AugmentedModel, points: Sequence[FloatArray], followed: Mapping[str, int]
) -> Climb:
    """Grow a model with mains hum of a grid that the records may hide, if hum explains most of its misfit.

    Parameters
    ----------
    climb : Climb
    base : AugmentedModel
        Laid out, or without effects.
    points : sequence of (n,)
    followed : mapping of record to int
        Samples that it follows at the points.
    """
    families, tell, journal = climb.families, _teller(climb, "mains hum"), climb.watch.journal
    grids = families.unseen_grids
    if not grids:
        return climb
    plain = fit_look(base, points[0], journal)
    for grid_hz in grids:
        look = look_at_hum(families, plain, grid_hz, points, tell, journal)
        climb = climb if look is None else _grow_hum(climb, base, grid_hz, look, followed)
        if climb.complete:
            break
    return climb


def _grow_hum(
    climb: Climb, base: AugmentedModel, grid_hz: float, look: FirstLook, followed: Mapping[str, int]
) -> Climb:
    """Grow a look with hum of a grid; the frequency is determined again as long as that leads further.

    Parameters
    ----------
    climb : Climb
    base : AugmentedModel
        The model without hum.
    grid_hz : float
    look : FirstLook
    followed : mapping of record to int
        Samples that it follows.
    """
    families = climb.families
    q, horizons, share = look.q, followed, 0.0
    while (model := families.with_hum(base, grid_hz, q, horizons)) and not climb.complete:
        reached = _grow(climb, model, q, escapes=STAGES.small_escapes)
        if reached.growth.complete:
            whole = families.with_hum(base, grid_hz, reached.q, reached.growth.horizons)
            reached = replace(reached, model=whole or model)
        climb = climb.with_growth(reached)
        if reached.share < STAGES.hum_further * share:
            break
        q, horizons, share = reached.q, reached.growth.horizons, reached.share
    return climb


def _is_unexplained(climb: Climb) -> bool:
    return climb.may_add and not climb.is_explained and not any(look.explains for look in climb.looks)


def _growable(climb: Climb) -> list[FirstLook]:
    return [look for look in climb.looks if not look.model.added.law and look.cost_per_sample < STAGES.growable]


def _grow_small(climb: Climb) -> Climb:
    """Grow the effects that the first moments need.

    Among effects that the first moments do not distinguish, the one that is followed furthest is used.
    """
    looks = sorted(_growable(climb), key=lambda look: look.criterion)
    alike = [look for look in looks[1:] if look.criterion - looks[0].criterion < STAGES.alike_looks]
    tell, journal = _teller(climb, "first moments"), climb.watch.journal
    small = [prune_look(climb.families, look, tell, journal) for look in [looks[0], *alike[: STAGES.singles - 1]]]
    small = list({look.model.effects: look for look in reversed(small)}.values())[::-1]
    model, q, grown = small[0].model, small[0].q, list[GrownModel]()
    if len(small) > 1:
        for look in small:
            grown.append(_grow(climb, look.model, look.q, escapes=0, leaps=0))
            climb = climb.with_growth(grown[-1])
            if climb.complete:
                return climb
        best = max(grown, key=lambda one: one.share)
        model, q = best.model, best.q
    escapes, leaps = (STAGES.small_escapes, STAGES.small_leaps) if model.effects else (0, 0)
    return climb.with_growth(_grow(climb, model, q, escapes=escapes, leaps=leaps))


def _free_past_stall(climb: Climb) -> Climb:
    """Compare effects where the furthest growth has stalled, and again if that leads much further."""
    tune = True
    while not climb.complete and _can_free(climb):
        before = furthest_growth(climb).share
        climb = _free_family_past_stall(climb, tune=tune)
        if not climb.complete and furthest_growth(climb).share < STAGES.look_further * before:
            furthest = furthest_growth(climb)
            climb = climb.with_growth(_grow(climb, furthest.model, furthest.q, escapes=STAGES.small_escapes))
        if furthest_growth(climb).share < STAGES.look_further * before:
            break
        tune = False
    return climb


def _free_family_past_stall(climb: Climb, *, tune: bool) -> Climb:
    """Free one family at a time over windows a little past a stall, and grow until one is followed much further."""
    furthest = furthest_growth(climb)
    families = _families_with_law(climb, furthest)
    windows = _windows_past(furthest)
    tell = _teller(climb, "past the stall")
    journal = climb.watch.journal
    here = fit_look(furthest.model, furthest.q, journal, windows, STAGES.second_steps)
    # Growth up to the end of the budget is kept.
    with suppress(WorkSpentError):
        for look in islice(look_past_stall(families, here, windows, tell, journal, tune=tune), STAGES.second_looks):
            small = prune_look(families, look, tell, journal, windows)
            grown = _grow(climb, small.model, small.q, escapes=0, leaps=0)
            if not grown.growth.complete and grown.share > STAGES.nearly_followed:
                grown = _grow(climb, grown.model, grown.q, escapes=STAGES.small_escapes)
            climb = climb.with_growth(tune_periods(climb, families, grown))
            if climb.complete or furthest_growth(climb).share >= STAGES.look_further * furthest.share:
                break
    return climb


def _windows_past(reached: GrownModel) -> Windows:
    """Return windows a little past the horizons; those of followed records are no longer than the others."""
    ends_s, stalled_s = dict[str, float](), list[float]()
    for target in reached.problem.targets:
        whole_s, followed = target.samples / target.base.sample_rate_hz, reached.growth.horizons[target.name]
        followed_s = followed / target.base.sample_rate_hz
        # A short horizon needs at least a fixed extension, for its window to show any effect.
        further_s = max(STAGES.past_stall * followed_s, followed_s + STAGES.past_stall_s)
        ends_s[target.name] = min(whole_s, further_s)
        if followed < target.samples:
            stalled_s.append(ends_s[target.name])
    longest_s = max(stalled_s, default=math.inf)
    return {t.name: (0, round(min(ends_s[t.name], longest_s) * t.base.sample_rate_hz)) for t in reached.problem.targets}


def tune_periods(climb: Climb, families: Families, reached: GrownModel) -> GrownModel:
    """Grow again if the longer windows of a growth show another number of periods of slow friction."""
    tell = _teller(climb, "past the stall")
    while slow := next(filter(families.is_slow, reached.model.effects), None):
        windows = _windows_past(reached)
        look = look_at_periods(families, reached.model, reached.q, slow, windows, tell, climb.watch.journal)
        if look.model.effects == reached.model.effects:
            break
        again = _grow(climb, look.model, look.q, escapes=STAGES.small_escapes)
        # Another number of periods may fit the windows and still be followed less far.
        if again.share < reached.share:
            break
        reached = again
    return reached


def _free_all(climb: Climb) -> Climb:
    """Free all terms and values of records where the furthest growth has stalled, and grow the needed ones."""
    furthest = furthest_growth(climb)
    small = free_family_at_stall(climb.watch, _families_with_law(climb, furthest), furthest, TERMS_AND_RECORDS)
    return climb.with_growth(_grow(climb, small.model, small.q, escapes=STAGES.small_escapes))


def _families_with_law(climb: Climb, reached: GrownModel) -> Families:
    """Return the families with the law of a growth."""
    law = reached.model.added.law
    return next((climb.families.with_law(one) for one in climb.families.laws() if one.name == law), climb.families)


def _grow(
    climb: Climb, model: AugmentedModel, q: FloatArray, *, escapes: int, leaps: int = STAGES.small_leaps
) -> GrownModel:
    if model.superset is not None and len(model.effects) <= IN_DIAGNOSIS.few:
        # A few effects are laid out on a plant of their own, whose steps are faster than the superset's.
        compact = model.lay_out(climb.families.plain)
        model, q = compact, compact.point_of(model, q)
    return grow_model(climb.watch, model, q, climb.seed, escapes=escapes, leaps=leaps)


def _teller(climb: Climb, stage: str) -> Callable[[str], None]:
    return lambda line: climb.watch.tell(stage, line)


def _can_free(climb: Climb) -> bool:
    return climb.may_add


def _keep_furthest(climb: Climb) -> Climb:
    """Keep the furthest growth, with its effects, if no rung has reached the ends of all records."""
    reached = climb.reached
    assert climb.growth is not None
    assert reached is not None
    state = climb.watch.note(unfinished_state(climb.state, reached))
    return replace(climb, state=state, growth=replace(reached.growth, q=state.q))


def _came_much_further(climb: Climb) -> bool:
    reached, growth = climb.reached, climb.growth
    if reached is None or growth is None or len(reached.model.effects) > IN_DIAGNOSIS.few:
        return False  # many effects together imitate any missing one
    return reached.share > STAGES.much_further * growth.followed_share(climb.state.problem)


def _rung(name: str, applies: Callable[[Climb], bool], attempt: Callable[[Climb], Climb]) -> Rung:
    return Rung(name, applies, attempt, effects_budget)


NAMED_EFFECTS = (
    _rung("mains hum", _is_unexplained, _grow_with_hum),
    _rung("effects named by the first moments", lambda climb: climb.may_add and not climb.is_explained, _free_single),
    _rung("an effect named where the mechanism as written stalls", _is_unexplained, _free_single_past_stall),
    _rung("more starts", _is_unexplained, _grow_from_more_starts),
    _rung("two effects named by the first moments", lambda c: _is_unexplained(c) and bool(c.looks), _free_second),
    _rung("effects of a kind named by the first moments", _is_unexplained, _free_families),
    _rung("those needed there, grown", lambda climb: bool(_growable(climb)), _grow_small),
)
"""Rungs that add effects named by the first moments."""
FREED_EFFECTS = (
    _rung("effects named where that stalls", _can_free, _free_past_stall),
    _rung("effects freed where that stalls", _can_free, _free_all),
)
"""Rungs that add effects where the furthest growth has stalled."""
FURTHEST = Rung("the furthest that was reached", _came_much_further, _keep_furthest)
"""Last rung, which keeps the furthest growth of the others."""
