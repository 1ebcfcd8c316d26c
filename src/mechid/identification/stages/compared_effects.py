"""Effects compared by what they leave of the first moments, or of what lies behind a stall, one or a few at a time.

A start refined over the first 60 ms with one family of effects free costs about a second, and leaves 1 of a sample's
noise where the missing effect is in the family, 2 to 25 times that where it is not. So what is missing is known before
anything is grown, and growth begins with few freedoms (docs/identification.md).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import islice

from mechid.arrays import FloatArray
from mechid.identification.computation.journal import Journal
from mechid.identification.effects.augmented import AugmentedModel
from mechid.identification.output_error.problem import Windows, transfer_values
from mechid.identification.stages.budget import whole_records_budget
from mechid.identification.stages.families import (
    ALL_TERMS,
    EVERYTHING,
    RECORDS,
    TERMS,
    TERMS_AND_RECORDS,
    Families,
    Family,
)
from mechid.identification.stages.first_look import FirstLook, first_windows, pruned_look, refined_look
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.single_effects import look_at_singles, with_best_period
from mechid.simulation.work import WorkSpentError, work_counter

DELAY = "record.delay"
COULOMB, STATIC = "friction.coulomb", "friction.static"
LISTED, WITH_SLOW = 2, 3
"""Kinds of single effects over long windows: of records and listed terms; with slow terms."""
SMALL, COMBINED = (RECORDS, TERMS, ALL_TERMS), (TERMS_AND_RECORDS, EVERYTHING)


@dataclass(frozen=True, eq=False)
class _FirstLooks:
    """Looks at the first moments, the best of each model by its name.

    Attributes
    ----------
    families : Families
    tell : callable
        Called with a line on each model.
    journal : Journal
    found : dict of str to FirstLook
    """

    families: Families
    tell: Callable[[str], None]
    journal: Journal
    found: dict[str, FirstLook] = field(default_factory=dict)

    def ordered(self) -> list[FirstLook]:
        """Return them, the one of the least criterion last."""
        best = min(self.found.values(), key=lambda look: look.criterion, default=None)
        return [*(look for look in self.found.values() if look is not best), *([best] if best else [])]

    def singles(self, q: FloatArray) -> bool:
        """Look at none, then at the likeliest single effects; tell whether that explains the first moments."""
        families = self.families
        bare = refined_look(families.bare, q, self.journal)
        if bare.explains:
            self.found[bare.model.name] = bare
            return True
        kinds = look_at_singles(families, families.bare, q, first_windows(families.plain), self.tell, self.journal)
        looks = [look for kind in kinds for look in kind]
        self.found.update({look.model.name: look for look in looks})
        return any(look.explains for look in looks)

    def of(self, some: Iterable[Family], points: Sequence[FloatArray], *, nearest: bool) -> bool:
        """Look at families from some points as written, and from the nearest look that they hold; tell the same."""
        models = [model for model in map(self.families.model, some) if model.problem.size > self.families.plain.size]
        return any(
            self._refined(
                model, [*(_from_nearest(model, self.found.values()) if nearest else ()), *self._plain(model, points)]
            )
            for model in models
        )

    def laws(self, points: Sequence[FloatArray], q: FloatArray) -> bool:
        """Look at laws from some points; first at those that a delay imitates, where delays help at `q`."""
        delays = self.found.get(DELAY)
        plain = refined_look(self.families.bare, q, self.journal)
        delayed = delays is not None and delays.cost < STAGES.delays_help * plain.cost
        some = sorted(self.families.laws(), key=lambda law: not (law.imitated_by and delayed))
        for model in map(self.families.by_law, some):
            self._refined(model, _law_starts(model, self._plain(model, points)))
            if self.found[model.name].explains_surely:
                break
        return any(look.explains for look in self.found.values())

    def _refined(self, model: AugmentedModel, points: Iterable[FloatArray]) -> bool:
        for point in points:
            look = refined_look(model, point, self.journal)
            if not look.explains and look.left < STAGES.prunable:  # fewer free ones come further in as many steps
                less = pruned_look(self.families, look, self.tell, self.journal)
                look = min(look, less, key=lambda one: one.cost)
            if model.name not in self.found or look.cost < self.found[model.name].cost:
                self.found[model.name] = look
            if look.explains:
                break
        look = self.found[model.name]
        self.tell(f"{model.name}: {model.problem.size} free, {look.left:.3g} of the noise left of the first moments")
        return look.explains

    def _plain(self, model: AugmentedModel, points: Iterable[FloatArray]) -> Iterator[FloatArray]:
        return (transfer_values(self.families.plain, q, model.problem) for q in points)


def look_at_first_moments(
    families: Families, q: FloatArray, tell: Callable[[str], None], journal: Journal
) -> list[FirstLook]:
    """Return what single effects leave of the first moments from the best start as written; the least criterion last.

    Laws too where what explains them leaves more than the noise of a record is uncertain by.

    Parameters
    ----------
    families : Families
    q : (n,)
        Of the mechanism as written.
    tell : callable
        Called with a line on each model.
    journal : Journal
    """
    looks = _FirstLooks(families, tell, journal)
    looks.singles(q)
    if not any(look.explains_surely for look in looks.found.values()):
        looks.laws([q], q)
    return looks.ordered()


def look_beside_best(
    families: Families, before: Sequence[FirstLook], tell: Callable[[str], None], journal: Journal
) -> list[FirstLook]:
    """Return what two effects leave of them: the one that leaves least, term and law, and one more beside it.

    Parameters
    ----------
    families : Families
    before : sequence of FirstLook
    tell, journal
        As of `look_at_first_moments`.
    """
    looks = _FirstLooks(families, tell, journal, {look.model.name: look for look in before})
    ordered, windows = sorted(before, key=lambda look: look.criterion), first_windows(families.plain)
    kinds = {bool(look.model.added.law): look for look in reversed(ordered)}
    for base in sorted(kinds.values(), key=lambda look: look.criterion):
        if base.left - 1.0 > STAGES.beside_worse * (ordered[0].left - 1.0):
            continue
        of = next((families.with_law(law) for law in families.laws() if law.name == base.model.added.law), families)
        found = [one for kind in look_at_singles(of, base.model, base.q, windows, tell, journal) for one in kind]
        looks.found.update({look.model.name: look for look in found})
        if any(look.explains for look in found):
            break
    return looks.ordered()


def look_at_families(
    families: Families, before: Sequence[FirstLook], q: FloatArray, tell: Callable[[str], None], journal: Journal
) -> list[FirstLook]:
    """Return what effects of a kind leave of them together, and all at once.

    Parameters as of `look_at_first_moments`, and the looks at single effects.
    """
    looks = _FirstLooks(families, tell, journal, {look.model.name: look for look in before})
    _ = looks.of(SMALL, [q], nearest=True) or looks.of(COMBINED, [q], nearest=True)
    return looks.ordered()


def look_at_hum(
    families: Families,
    plain: FirstLook,
    grid_hz: float,
    points: Sequence[FloatArray],
    tell: Callable[[str], None],
    journal: Journal,
) -> FirstLook | None:
    """Return what a model leaves of the first moments with hum of a grid projected out of them.

    None where that explains too little of what it leaves without: then it is not hum.

    Parameters
    ----------
    families : Families
    plain : FirstLook
        At the model without hum, laid out or with nothing beside.
    grid_hz : float
    points : sequence of (n,)
        Of that model, tried until one explains them, the best one first.
    tell, journal
        As of `look_at_first_moments`.
    """
    first = {name: stop for name, (_, stop) in first_windows(families.plain).items()}
    best = plain
    for q in points:
        model = families.with_hum(plain.model, grid_hz, q, first)
        if model is None or plain.explains:
            return None
        look = refined_look(model, q, journal)
        tell(f"{model.name}: {look.left:.3g} of the noise left of the first moments, {plain.left:.3g} without")
        best = min(best, look, key=lambda one: one.cost)
        excess = (best.left - 1.0) / (plain.left - 1.0)
        if excess > STAGES.hum_helps:
            return None
        if best.explains:
            return best
    return best


def look_past_stall(
    families: Families,
    here: FirstLook,
    windows: Windows,
    tell: Callable[[str], None],
    journal: Journal,
    *,
    tune: bool,
) -> Iterator[FirstLook]:
    """Yield looks that may be grown, over windows that reach a little past where a growth has stalled.

    First the model with another number of periods of a term that it has, where that leaves less; then a single effect
    or a law that explains far more than those before; the best of them; at last the best of wide families, by the
    Bayesian criterion. Each is looked at only when it is asked for: long windows take seconds a look.

    Parameters
    ----------
    families : Families
        With the law of the model.
    here : FirstLook
        At the model that was grown, from where its growth has ended.
    windows : mapping of record to (first, stop)
    tell, journal
        As of `look_at_first_moments`.
    tune : bool
        Whether the number of periods is not known from longer windows already.
    """
    base, steps = here.model, STAGES.second_steps
    term = next((name for name in base.effects if name in families.unlisted), None)
    if tune and term is not None:  # a wrong number of periods hides what else is missing
        tuned = with_best_period(families, here, term, windows, tell, journal, steps)
        if tuned is not here:
            yield tuned
    looks, grown = list[FirstLook](), list[FirstLook]()
    for number, kind in enumerate(_looks_by_kind(families, here, windows, tell, journal, steps, WITH_SLOW)):
        looks = sorted([*looks, *(kind or ())], key=lambda look: look.criterion)
        may_grow = (number > 0 and _is_clear(looks, here)) or kind is None  # records' own values imitate terms
        if looks and may_grow and looks[0] not in grown:
            grown.append(looks[0])
            yield looks[0]
        if any(look.explains_what_is_left_of(here) for look in looks):
            break
    else:
        for family in (RECORDS, TERMS_AND_RECORDS, EVERYTHING):
            model = families.model(family, base)
            looks.append(refined_look(model, model.point_of(base, here.q), journal, windows, steps))
            tell(f"{model.name}: {looks[-1].left:.3g} of the noise left")
    yield from (look for look in sorted(looks, key=lambda look: look.criterion) if look not in grown)


def look_at_whole_records(
    families: Families, q: FloatArray, tell: Callable[[str], None], journal: Journal
) -> list[FirstLook]:
    """Return what the likeliest single effects, and each law, leave of whole records from an optimum without them.

    Detents of any number of periods only where none of the others stands out; what its budget allows in any case.
    """
    whole = families.plain.whole()
    here = refined_look(families.bare, q, journal, whole, STAGES.whole_steps)
    looks = list[FirstLook]()
    with suppress(WorkSpentError), work_counter(whole_records_budget(families.plain)):
        for kind in _looks_by_kind(families, here, whole, tell, journal, STAGES.whole_steps, LISTED):
            looks = sorted([*looks, *(kind or ())], key=lambda look: look.criterion)
            if kind is None and _is_clear(looks, here):
                break
    return looks


def _looks_by_kind(
    families: Families,
    here: FirstLook,
    windows: Windows,
    tell: Callable[[str], None],
    journal: Journal,
    steps: int,
    before_laws: int,
) -> Iterator[list[FirstLook] | None]:
    """Yield what one more effect leaves, kind by kind; None before detents of any number of periods.

    Where a model follows more than the first moments these come last: a detent shows there, and a scan takes longest.
    Slow terms come before laws past a stall, and behind them over whole records, where a scan of them takes longer.
    """
    base = here.model
    singles = look_at_singles(families, base, here.q, windows, tell, journal, steps)
    yield from islice(singles, before_laws)
    for law in families.laws() if not base.added.law else ():
        model = families.by_law(law, base)
        starts = _law_starts(model, [model.point_of(base, here.q)])
        look = min((refined_look(model, q, journal, windows, steps) for q in starts), key=lambda one: one.cost)
        tell(f"{law.name} beside {base.name}: {look.left:.3g} of the noise left")
        yield [look]
    yield from islice(singles, WITH_SLOW - before_laws)
    yield None
    yield from singles


def _is_clear(looks: Sequence[FirstLook], here: FirstLook) -> bool:
    """Tell whether the first of some looks explains far more than all others."""
    gains = [here.cost - look.cost for look in looks]
    return bool(gains) and gains[0] > STAGES.clearly_more * max([0.0, *gains[1:]])


def _from_nearest(model: AugmentedModel, looks: Iterable[FirstLook]) -> list[FloatArray]:
    """Return the point of the look that explains most among those whose effects the model has."""
    inside = [look for look in looks if not look.model.added.law and set(look.model.effects) <= set(model.effects)]
    nearest = min(inside, key=lambda look: look.cost, default=None)
    return [model.point_of(nearest.model, nearest.q)] if nearest else []


def _law_starts(model: AugmentedModel, points: Iterable[FloatArray]) -> Iterator[FloatArray]:
    """Yield where a law begins: as it is, and of friction with the sliding one far below the static one.

    Without the law both are the same mean of what friction does, and Stribeck's begins where they differ.
    """
    for q in points:
        values = model.problem.coordinates.values(q)
        if COULOMB in values and STATIC in values:
            lower = {**values, COULOMB: STAGES.law_coulomb * values[STATIC]}
            yield model.problem.coordinates.clip(model.problem.coordinates.point(lower))
        yield q
