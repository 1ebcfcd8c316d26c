"""First looks: what each family of effects leaves of the first moments that the mechanism as written does not explain.

A start refined over the first 60 ms with one family of effects free costs about a second, and leaves 1 of a sample's
noise where the missing effect is in the family, 2 to 25 times that where it is not. So what is missing is known before
anything is grown, and growth begins with few freedoms (docs/identification.md).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from mechid.arrays import FloatArray
from mechid.identification.computation.journal import Journal
from mechid.identification.effects.augmented import AugmentedModel
from mechid.identification.effects.scores import bayesian_penalty
from mechid.identification.output_error.identity import identity
from mechid.identification.output_error.problem import Problem, Windows, transfer_values
from mechid.identification.search.first_moments import first_window
from mechid.identification.search.multistart import NO_WINDOWS, Candidate, refine
from mechid.identification.search.settings import SEARCH
from mechid.identification.stages.families import (
    ALL_TERMS,
    EVERYTHING,
    RECORDS,
    TERMS,
    TERMS_AND_RECORDS,
    Families,
    Family,
)
from mechid.identification.stages.likeliest import likeliest_effects
from mechid.identification.stages.settings import STAGES

COULOMB, STATIC = "friction.coulomb", "friction.static"
SMALL, COMBINED = (RECORDS, TERMS, ALL_TERMS), (TERMS_AND_RECORDS, EVERYTHING)


@dataclass(frozen=True, eq=False)
class FirstLook:
    """A model refined over the first moments.

    Attributes
    ----------
    model : AugmentedModel
    q : (n,)
    cost : float
        Robust cost, priors counted, in sigmas squared.
    samples : int
        Of all channels.
    """

    model: AugmentedModel
    q: FloatArray
    cost: float
    samples: int

    @property
    def left(self) -> float:
        """Cost a sample."""
        return self.cost / self.samples

    @property
    def explains(self) -> bool:
        """Whether it leaves no more than noise of the first moments."""
        return self.left < SEARCH.explained

    @property
    def criterion(self) -> float:
        """Bayesian criterion: the cost, and ln N for each freedom (Schwarz 1978)."""
        return self.cost + self.model.problem.size * bayesian_penalty(self.samples)


def look_at_first_moments(
    families: Families, starts: Sequence[FloatArray], tell: Callable[[str], None], journal: Journal
) -> list[FirstLook]:
    """Return what the families leave of the first moments; the last one explains them, unless none does.

    Parameters
    ----------
    families : Families
    starts : sequence of (n,)
        Points of the mechanism as written: the best one, refined, then others as they were drawn.
    tell : callable
        Called with a line on each family.
    journal : Journal
    """
    looks: dict[str, FirstLook] = {}
    first, others = starts[0], starts[1:]

    def refined(model: AugmentedModel, points: Iterable[FloatArray]) -> bool:
        for point in points:
            found = refined_look(model, point, journal)
            if not found.explains and found.left < STAGES.prunable:  # fewer free ones come further in as many steps
                found = min(found, pruned_look(families, found, tell, journal), key=lambda look: look.cost)
            if model.name not in looks or found.cost < looks[model.name].cost:
                looks[model.name] = found
            if found.explains:
                break
        look = looks[model.name]
        tell(f"{model.name}: {model.problem.size} free, {look.left:.3g} of the noise left of the first moments")
        return look.explains

    def plain_points(model: AugmentedModel, some: Iterable[FloatArray]) -> Iterator[FloatArray]:
        return (transfer_values(families.plain, q, model.problem) for q in some)

    def families_tried(some: Iterable[Family], points: Sequence[FloatArray], *, nearest: bool) -> bool:
        models = [model for model in map(families.model, some) if model.problem.size > families.plain.size]
        return any(
            refined(model, [*(_from_nearest(model, looks.values()) if nearest else ()), *plain_points(model, points)])
            for model in models
        )

    def laws_tried(points: Sequence[FloatArray]) -> bool:
        delays = looks.get(RECORDS.name)
        plain = refined_look(families.bare, first, journal)
        delayed = delays is not None and delays.cost < STAGES.delays_help * plain.cost
        some = sorted(families.laws(), key=lambda law: not (law.imitated_by and delayed))
        models = map(families.by_law, some)
        return any(refined(model, _law_starts(model, plain_points(model, points))) for model in models)

    def singles_tried() -> bool:
        singles = look_at_singles(families, families.bare, first, first_windows(families.plain), tell, journal)
        looks.update({look.model.name: look for look in singles})
        return any(look.explains for look in singles)

    _ = (
        singles_tried()
        or families_tried(SMALL, [first], nearest=True)
        or laws_tried([first])
        or families_tried(COMBINED, [first], nearest=True)
        or families_tried(SMALL, others, nearest=False)
        or laws_tried(others[: STAGES.law_starts])
    )
    best = min(looks.values(), key=lambda look: look.criterion, default=None)
    return [*(look for look in looks.values() if look is not best), *([best] if best else [])]


def look_at_singles(
    families: Families,
    base: AugmentedModel,
    q: FloatArray,
    windows: Windows,
    tell: Callable[[str], None],
    journal: Journal,
    steps: int = SEARCH.robust_steps,
) -> list[FirstLook]:
    """Return what a model with one more effect leaves of some windows, for each of the likeliest single effects.

    A term of any number of periods is followed by its neighbours as long as these leave less: the derivatives tell
    its number roughly.
    """

    def look(name: str, start: tuple[AugmentedModel, FloatArray]) -> FirstLook:
        model = families.with_effect(base, name)
        found = refined_look(model, model.point_of(*start), journal, windows, steps)
        tell(f"{name} beside {base.name}: {found.left:.3g} of the noise left")
        return found

    looks = [look(name, (base, q)) for name in likeliest_effects(families, base, q, windows)]
    best = min(looks, key=lambda look: look.cost, default=None)
    new_first = sorted(best.model.effects, key=lambda name: name in base.effects) if best else []
    term = next((name for name in new_first if name in families.unlisted), None)
    if best is not None and term is not None:
        looks.append(_with_best_period(families, best, term, windows, tell, journal, steps))
    return looks


def look_at_periods(
    families: Families,
    base: AugmentedModel,
    q: FloatArray,
    term: str,
    windows: Windows,
    tell: Callable[[str], None],
    journal: Journal,
    steps: int = STAGES.whole_steps,
) -> FirstLook:
    """Return what a model leaves of some windows with the number of periods of one of its terms that leaves least."""
    here = refined_look(base, q, journal, windows, steps)
    return _with_best_period(families, here, term, windows, tell, journal, steps)


def _with_best_period(
    families: Families,
    look: FirstLook,
    term: str,
    windows: Windows,
    tell: Callable[[str], None],
    journal: Journal,
    steps: int,
) -> FirstLook:
    """Return a look with the number of periods of a term that leaves least, found uphill in halved strides."""
    stride, tried = max(round(STAGES.period_stride * families.periods(term)), 1), {term}
    while stride:
        here = families.periods(term)
        for number in (here - stride, here + stride):
            other = families.with_periods(term, number)
            if other is None or other in tried:
                continue
            tried.add(other)
            model, moved = families.with_other_term(look.model, term, other)
            values = look.model.problem.coordinates.values(look.q)
            point = model.problem.coordinates.point({moved.get(name, name): v for name, v in values.items()})
            found = refined_look(model, point, journal, windows, steps)
            if found.cost < look.cost:
                look, term = found, other
        if families.periods(term) == here:
            stride //= 2
    tell(f"{look.model.name}: {look.left:.3g} of the noise left with {families.periods(term)} periods in a turn")
    return look


def refined_look(
    model: AugmentedModel,
    q: FloatArray,
    journal: Journal,
    windows: Windows = NO_WINDOWS,
    steps: int = SEARCH.robust_steps,
) -> FirstLook:
    """Return a model refined over the first moments, or over other windows, from a point of it.

    Over the first half of them before the whole: there fewer switches between sticking and sliding have gone wrong.
    """
    windows = windows or first_windows(model.problem)
    halves = {name: (first, first + (stop - first) // 2) for name, (first, stop) in windows.items()}

    def work() -> dict[str, object]:
        begun = refine(model.problem, Candidate(q, 0.0), steps // 2, halves, priors=True)
        found = refine(model.problem, begun, steps, windows, priors=True)
        return {"q": found.q, "cost": found.cost}

    found = journal.step("first look", [identity(model.problem), q, windows, steps], work)
    samples = sum((windows[t.name][1] - windows[t.name][0]) * len(t.channels) for t in model.problem.targets)
    return FirstLook(model, found["q"], found["cost"], samples)


def first_windows(problem: Problem) -> Windows:
    """Return the windows of the first moments of all records."""
    return {t.name: first_window(t) for t in problem.targets}


def pruned_look(
    families: Families, look: FirstLook, tell: Callable[[str], None], journal: Journal, windows: Windows = NO_WINDOWS
) -> FirstLook:
    """Return a look without the effects that are not needed there, refined again; itself where it leaves too much."""
    if look.left >= STAGES.prunable or not look.model.names_by_effect:
        return look
    needed = look.model.needed(look.q, windows or first_windows(families.plain))
    if needed is None:
        return look
    tell(f"needed there: {effect_words(needed)}")
    less = look.model.keeping(families.plain, needed, ", ".join(needed) or "as written")
    found = refined_look(less, less.point_of(look.model, look.q), journal, windows)
    wider = less.widened(found.q, STAGES.at_edge, STAGES.wider)
    return found if wider is less else refined_look(wider, found.q, journal, windows)


def look_past_stall(
    families: Families,
    base: AugmentedModel,
    at: FloatArray,
    windows: Windows,
    tell: Callable[[str], None],
    journal: Journal,
) -> list[FirstLook]:
    """Return what each family leaves of windows that reach a little past where a growth has stalled, the best first.

    Each begins where the growth has ended; the best is the one of the least Bayesian criterion.

    Parameters
    ----------
    families : Families
        With the law of the model.
    base : AugmentedModel
        The model that was grown.
    at : (n,)
        Where its growth has ended.
    windows : mapping of record to (first, stop)
    tell, journal
        As of `look_at_first_moments`.
    """
    looks = look_at_singles(families, base, at, windows, tell, journal, STAGES.second_steps)
    new = {name for look in looks for name in look.model.effects if name not in base.effects}
    if any(look.explains for look in looks) or (new and all(map(families.is_slow, new))):
        return sorted(looks, key=lambda look: look.criterion)
    term = next((name for name in base.effects if name in families.unlisted), None)
    if term is not None:
        looks.append(look_at_periods(families, base, at, term, windows, tell, journal, STAGES.second_steps))
    laws = [families.by_law(law, base) for law in families.laws()] if not base.added.law else []
    wide = [families.model(family, base) for family in (RECORDS, TERMS_AND_RECORDS, EVERYTHING)]
    for model in [*laws, *wide]:
        if model is wide[0] and any(look.explains for look in looks):
            break
        look = refined_look(model, model.point_of(base, at), journal, windows, STAGES.second_steps)
        tell(f"{model.name}: {model.problem.size} free, {look.left:.3g} of the noise left a little past the horizons")
        looks.append(look)
    return sorted(looks, key=lambda look: look.criterion)


def effect_words(needed: Mapping[str, float]) -> str:
    """Return the names of effects, each with what it explains."""
    return ", ".join(f"{name} ({rise:.0f})" if rise else name for name, rise in needed.items()) or "none"


def look_at_whole_records(
    families: Families, q: FloatArray, tell: Callable[[str], None], journal: Journal
) -> list[FirstLook]:
    """Return what the likeliest single effects, and each law, leave of whole records from an optimum without them."""
    base, whole = families.bare, families.plain.whole()
    looks = look_at_singles(families, base, q, whole, tell, journal, STAGES.whole_steps)
    for law in families.laws():
        model = families.by_law(law)
        look = refined_look(model, model.point_of(base, q), journal, whole, STAGES.whole_steps)
        tell(f"{law.name}: {look.left:.4g} of the noise left")
        looks.append(look)
    return looks


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
