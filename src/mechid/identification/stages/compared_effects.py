"""Comparison of effects, single or a few at a time, by the misfit of the first moments or past a stall.

A start refined over the first 60 ms with one family of effects free takes about a second. Its cost per sample is 1 if
the missing effect is in the family, and 2 to 25 if it is not. The missing effect is therefore known before anything is
grown, and growth begins with few free parameters (docs/identification.md).
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
from mechid.identification.stages.first_look import FirstLook, first_windows, fit_look, prune_look
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.single_effects import choose_best_period, look_at_singles
from mechid.simulation.work import WorkSpentError, work_counter

DELAY = "record.delay"
COULOMB, STATIC = "friction.coulomb", "friction.static"
LISTED, WITH_SLOW = 2, 3
"""Number of kinds of single effects over long windows: of records and listed terms; with slow terms."""
SMALL, COMBINED = (RECORDS, TERMS, ALL_TERMS), (TERMS_AND_RECORDS, EVERYTHING)


@dataclass(frozen=True, eq=False)
class _FirstLooks:
    """Looks at the first moments: `found` has the best one of each model by its name. `tell` is called with lines."""

    families: Families
    tell: Callable[[str], None]
    journal: Journal
    found: dict[str, FirstLook] = field(default_factory=dict)

    def sorted_looks(self) -> list[FirstLook]:
        """Return all looks, with the one of least criterion last."""
        best = min(self.found.values(), key=lambda look: look.criterion, default=None)
        return [*(look for look in self.found.values() if look is not best), *([best] if best else [])]

    def singles(self, q: FloatArray) -> bool:
        """Look at the model without effects, then at the likeliest single effects.

        The result tells whether a look explains the first moments.
        """
        families = self.families
        bare = fit_look(families.bare, q, self.journal)
        if bare.explains:
            self.found[bare.model.name] = bare
            return True
        kinds = look_at_singles(families, families.bare, q, first_windows(families.plain), self.tell, self.journal)
        looks = [look for kind in kinds for look in kind]
        self.found.update({look.model.name: look for look in looks})
        return any(look.explains for look in looks)

    def of(self, some: Iterable[Family], points: Sequence[FloatArray], *, nearest: bool) -> bool:
        """Look at families from some points of the mechanism as written; tell whether one explains the first moments.

        With `nearest`, each family also starts from the best look whose effects it contains.
        """
        models = [model for model in map(self.families.model, some) if model.problem.size > self.families.plain.size]
        return any(
            self._add_look(
                model,
                [*(_nearest_points(model, self.found.values()) if nearest else ()), *self._plain_points(model, points)],
            )
            for model in models
        )

    def laws(self, points: Sequence[FloatArray], q: FloatArray) -> bool:
        """Look at laws from some points; tell whether any look explains the first moments.

        Laws that a delay imitates come first if delays help at `q`.
        """
        delays = self.found.get(DELAY)
        plain = fit_look(self.families.bare, q, self.journal)
        delayed = delays is not None and delays.cost < STAGES.delays_help * plain.cost
        some = sorted(self.families.laws(), key=lambda law: not (law.imitated_by and delayed))
        for model in map(self.families.model_with_law, some):
            self._add_look(model, _law_starts(model, self._plain_points(model, points)))
            if self.found[model.name].explains_surely:
                break
        return any(look.explains for look in self.found.values())

    def _add_look(self, model: AugmentedModel, points: Iterable[FloatArray]) -> bool:
        for point in points:
            look = fit_look(model, point, self.journal)
            # Fewer free parameters reach a lower cost in as many steps.
            if not look.explains and look.cost_per_sample < STAGES.prunable:
                less = prune_look(self.families, look, self.tell, self.journal)
                look = min(look, less, key=lambda one: one.cost)
            if model.name not in self.found or look.cost < self.found[model.name].cost:
                self.found[model.name] = look
            if look.explains:
                break
        look = self.found[model.name]
        left = f"{look.cost_per_sample:.3g} of the noise left of the first moments"
        self.tell(f"{model.name}: {model.problem.size} free, {left}")
        return look.explains

    def _plain_points(self, model: AugmentedModel, points: Iterable[FloatArray]) -> Iterator[FloatArray]:
        return (transfer_values(self.families.plain, q, model.problem) for q in points)


def look_at_first_moments(
    families: Families, q: FloatArray, tell: Callable[[str], None], journal: Journal
) -> list[FirstLook]:
    """Return looks at single effects from the best start as written; the one of least criterion comes last.

    Laws are included if the best single effect leaves more than the uncertainty of a record's noise.

    Parameters
    ----------
    families : Families
    q : (n,)
        Point of the mechanism as written.
    tell : callable
        Called with a line about each model.
    journal : Journal
    """
    looks = _FirstLooks(families, tell, journal)
    looks.singles(q)
    if not any(look.explains_surely for look in looks.found.values()):
        looks.laws([q], q)
    return looks.sorted_looks()


def look_at_second_effects(
    families: Families, before: Sequence[FirstLook], tell: Callable[[str], None], journal: Journal
) -> list[FirstLook]:
    """Return looks at pairs of effects: the best term and the best law so far, each with one more effect.

    Parameters
    ----------
    families : Families
    before : sequence of FirstLook
    tell, journal
        As for `look_at_first_moments`.
    """
    looks = _FirstLooks(families, tell, journal, {look.model.name: look for look in before})
    ordered, windows = sorted(before, key=lambda look: look.criterion), first_windows(families.plain)
    kinds = {bool(look.model.added.law): look for look in reversed(ordered)}
    for base in sorted(kinds.values(), key=lambda look: look.criterion):
        if base.cost_per_sample - 1.0 > STAGES.beside_worse * (ordered[0].cost_per_sample - 1.0):
            continue
        of = next((families.with_law(law) for law in families.laws() if law.name == base.model.added.law), families)
        found = [one for kind in look_at_singles(of, base.model, base.q, windows, tell, journal) for one in kind]
        looks.found.update({look.model.name: look for look in found})
        if any(look.explains for look in found):
            break
    return looks.sorted_looks()


def look_at_families(
    families: Families, before: Sequence[FirstLook], q: FloatArray, tell: Callable[[str], None], journal: Journal
) -> list[FirstLook]:
    """Return looks at all effects of one kind together, and at all effects at once.

    Parameters as for `look_at_first_moments`, with the looks at single effects in `before`.
    """
    looks = _FirstLooks(families, tell, journal, {look.model.name: look for look in before})
    _ = looks.of(SMALL, [q], nearest=True) or looks.of(COMBINED, [q], nearest=True)
    return looks.sorted_looks()


def look_at_hum(
    families: Families,
    plain: FirstLook,
    grid_hz: float,
    points: Sequence[FloatArray],
    tell: Callable[[str], None],
    journal: Journal,
) -> FirstLook | None:
    """Return the look at a model with hum of a grid projected out of the first moments.

    None if hum explains too little of the misfit without it: then the cause is not hum.

    Parameters
    ----------
    families : Families
    plain : FirstLook
        Look at the model without hum, laid out or without effects.
    grid_hz : float
    points : sequence of (n,)
        Points of that model, the best one first, tried until one explains the first moments.
    tell, journal
        As for `look_at_first_moments`.
    """
    first = {name: stop for name, (_, stop) in first_windows(families.plain).items()}
    best = plain
    for q in points:
        model = families.with_hum(plain.model, grid_hz, q, first)
        if model is None or plain.explains:
            return None
        look = fit_look(model, q, journal)
        tell(f"{model.name}: {look.cost_per_sample:.3g} of the noise left, {plain.cost_per_sample:.3g} without")
        best = min(best, look, key=lambda one: one.cost)
        if not hum_helps(best, plain):
            return None
        if best.explains:
            return best
    return best


def hum_helps(look: FirstLook, plain: FirstLook) -> bool:
    """Tell whether a look with hum leaves little of the misfit, beyond noise, of one without it."""
    return look.cost_per_sample - 1.0 <= STAGES.hum_helps * (plain.cost_per_sample - 1.0)


def look_past_stall(
    families: Families,
    here: FirstLook,
    windows: Windows,
    tell: Callable[[str], None],
    journal: Journal,
    *,
    tune: bool,
) -> Iterator[FirstLook]:
    """Yield looks that may be grown, over windows that extend a little past a stall of growth.

    The first one is the model with another number of periods of one of its terms, if that fits better. Then follow
    single effects or laws that explain far more than those before, and the best of them. The last is the best of the
    wide families, by the Bayesian criterion. Each look is computed only on request, because long windows take seconds
    per look.

    Parameters
    ----------
    families : Families
        With the law of the model.
    here : FirstLook
        Look at the grown model, from the end of its growth.
    windows : mapping of record to (first, stop)
    tell, journal
        As for `look_at_first_moments`.
    tune : bool
        Whether the number of periods is not yet known from longer windows.
    """
    base, steps = here.model, STAGES.second_steps
    term = next((name for name in base.effects if name in families.unlisted_terms), None)
    # A wrong number of periods hides other missing effects.
    if tune and term is not None:
        tuned = choose_best_period(families, here, term, windows, tell, journal, steps)
        if tuned is not here:
            yield tuned
    looks, grown = list[FirstLook](), list[FirstLook]()
    for number, kind in enumerate(_looks_by_kind(families, here, windows, tell, journal, steps, WITH_SLOW)):
        looks = sorted([*looks, *(kind or ())], key=lambda look: look.criterion)
        # Records' own values imitate terms, so a clear result of records alone is not grown before terms are tried.
        may_grow = (number > 0 and _stands_out(looks, here)) or kind is None
        if looks and may_grow and looks[0] not in grown:
            grown.append(looks[0])
            yield looks[0]
        if any(look.explains_misfit_of(here) for look in looks):
            break
    else:
        for family in (RECORDS, TERMS_AND_RECORDS, EVERYTHING):
            model = families.model(family, base)
            looks.append(fit_look(model, model.point_of(base, here.q), journal, windows, steps))
            tell(f"{model.name}: {looks[-1].cost_per_sample:.3g} of the noise left")
    yield from (look for look in sorted(looks, key=lambda look: look.criterion) if look not in grown)


def look_at_whole_records(
    families: Families, q: FloatArray, tell: Callable[[str], None], journal: Journal
) -> list[FirstLook]:
    """Return looks at the likeliest single effects, and at each law, over whole records, from an optimum without them.

    Detents of any number of periods are included only if no other effect stands out. A term or a law that leaves only
    noise and stands out ends the looks, as each law compiles a kernel, and so does their budget.
    """
    whole = families.plain.whole_windows()
    here = fit_look(families.bare, q, journal, whole, STAGES.whole_steps)
    looks = list[FirstLook]()
    with suppress(WorkSpentError), work_counter(whole_records_budget(families.plain)):
        for kind in _looks_by_kind(families, here, whole, tell, journal, STAGES.whole_steps, LISTED):
            looks = sorted([*looks, *(kind or ())], key=lambda look: look.criterion)
            if (kind is None or (looks and looks[0].settles)) and _stands_out(looks, here):
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
    """Yield looks with one more effect, kind by kind; None before detents of any number of periods.

    If a model follows more than the first moments, these detents come last: a missing detent would show in the first
    moments, and their scan takes longest. Slow terms come before laws past a stall, and after them over whole records,
    where their scan takes longer.
    """
    base = here.model
    singles = look_at_singles(families, base, here.q, windows, tell, journal, steps)
    yield from islice(singles, before_laws)
    for law in families.laws() if not base.added.law else ():
        model = families.model_with_law(law, base)
        starts = _law_starts(model, [model.point_of(base, here.q)])
        look = min((fit_look(model, q, journal, windows, steps) for q in starts), key=lambda one: one.cost)
        tell(f"{law.name} beside {base.name}: {look.cost_per_sample:.3g} of the noise left")
        yield [look]
    yield from islice(singles, WITH_SLOW - before_laws)
    yield None
    yield from singles


def _stands_out(looks: Sequence[FirstLook], here: FirstLook) -> bool:
    """Tell whether the first of some looks explains far more than all others."""
    gains = [here.cost - look.cost for look in looks]
    return bool(gains) and gains[0] > STAGES.clearly_more * max([0.0, *gains[1:]])


def _nearest_points(model: AugmentedModel, looks: Iterable[FirstLook]) -> list[FloatArray]:
    """Return the point of the best look whose effects are all in the model."""
    inside = [look for look in looks if not look.model.added.law and set(look.model.effects) <= set(model.effects)]
    nearest = min(inside, key=lambda look: look.cost, default=None)
    return [model.point_of(nearest.model, nearest.q)] if nearest else []


def _law_starts(model: AugmentedModel, points: Iterable[FloatArray]) -> Iterator[FloatArray]:
    """Yield starts of a law: unchanged, and for friction also with sliding friction far below static friction.

    Without the law, both friction values are the same mean of the true friction, and the law of Stribeck starts where
    they differ.
    """
    for q in points:
        values = model.problem.coordinates.values(q)
        if COULOMB in values and STATIC in values:
            # Friction starts only if both of its values exist.
            lower = {**values, COULOMB: STAGES.law_coulomb * values[STATIC]}
            yield model.problem.coordinates.clip(model.problem.coordinates.point(lower))
        yield q
