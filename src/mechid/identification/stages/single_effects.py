"""Looks at single effects in addition to a model, and the choice of the number of periods of a term."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

from mechid.arrays import FloatArray
from mechid.identification.computation.journal import Journal
from mechid.identification.effects.augmented import AugmentedModel
from mechid.identification.output_error.problem import Windows
from mechid.identification.search.settings import SEARCH
from mechid.identification.stages.effect_ranking import rank_effects
from mechid.identification.stages.families import Families
from mechid.identification.stages.first_look import FirstLook, fit_look
from mechid.identification.stages.settings import STAGES


def look_at_singles(
    families: Families,
    base: AugmentedModel,
    q: FloatArray,
    windows: Windows,
    tell: Callable[[str], None],
    journal: Journal,
    steps: int = SEARCH.robust_steps,
) -> Iterator[list[FirstLook]]:
    """Yield looks at a model with one more effect over some windows, for the likeliest single effects of each kind.

    A term of any number of periods is compared with its neighbours as long as these fit better, because the derivatives
    determine its number only roughly. A kind is computed on request, since looks at long windows take seconds.
    """

    def look(name: str) -> FirstLook:
        model = families.with_effect(base, name)
        found = fit_look(model, model.point_of(base, q), journal, windows, steps)
        tell(f"{name} beside {base.name}: {found.cost_per_sample:.3g} of the noise left")
        return found

    least = math.inf
    for names in rank_effects(families, base, q, windows):
        looks = {name: look(name) for name in names}
        name = min(looks, key=lambda one: looks[one].cost, default=None)
        found = [*looks.values()]
        if name is not None and name in families.unlisted_terms and looks[name].cost < least:
            best = choose_best_period(families, looks[name], name, windows, tell, journal, steps)
            found = [best, *(look for other, look in looks.items() if other != name)]
        least = min([least, *(look.cost for look in found)])
        yield found


def look_at_periods(
    families: Families,
    base: AugmentedModel,
    q: FloatArray,
    term: str,
    windows: Windows,
    tell: Callable[[str], None],
    journal: Journal,
) -> FirstLook:
    """Return the look at a model with the best number of periods of one of its terms."""
    here = fit_look(base, q, journal, windows, STAGES.whole_steps)
    return choose_best_period(families, here, term, windows, tell, journal, STAGES.whole_steps)


def choose_best_period(
    families: Families,
    look: FirstLook,
    term: str,
    windows: Windows,
    tell: Callable[[str], None],
    journal: Journal,
    steps: int,
) -> FirstLook:
    """Return a look with the best number of periods of a term, found by hill climbing with halved strides.

    For friction over the angle of rotor or output, both are tried: two periods a turn of the one are nearly 42 of the
    other, geared down 20 times.
    """

    def with_term(look: FirstLook, term: str, other: str) -> FirstLook:
        model, moved = families.with_other_term(look.model, term, other)
        values = look.model.problem.coordinates.values(look.q)
        point = model.problem.coordinates.point({moved.get(name, name): v for name, v in values.items()})
        compact = model.lay_out(families.plain)
        return fit_look(compact, compact.point_of(model, point), journal, windows, steps)

    def uphill(look: FirstLook, term: str) -> tuple[FirstLook, str]:
        stride, tried = max(round(STAGES.period_stride * families.periods(term)), 1), {term}
        while stride:
            here = families.periods(term)
            for number in (here - stride, here + stride):
                other = families.with_periods(term, number)
                if other is None or other in tried:
                    continue
                tried.add(other)
                found = with_term(look, term, other)
                if found.cost < look.cost:
                    look, term = found, other
            if families.periods(term) == here:
                stride //= 2
        return look, term

    best, term = uphill(look, term)
    counterpart = families.counterpart(term)
    if counterpart is not None:
        other, name = uphill(with_term(best, term, counterpart), counterpart)
        best, term = min((best, term), (other, name), key=lambda one: one[0].cost)
    periods = f"{families.periods(term)} periods in a turn"
    tell(f"{best.model.name}: {best.cost_per_sample:.3g} of the noise left with {periods}")
    return best
