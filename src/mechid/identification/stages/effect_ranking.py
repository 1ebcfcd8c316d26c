"""Ranking of single effects by derivatives at one point of a model, including terms of any number of periods.

All parameters of the model stay free with each effect. Among terms with neighbouring numbers of periods, which short
windows do not distinguish, the best one is returned.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence

from mechid.arrays import FloatArray
from mechid.identification.effects.augmented import AugmentedModel
from mechid.identification.effects.pruning import cost_reductions, groups_of
from mechid.identification.effects.scores import bayesian_penalty
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import combine_triangles
from mechid.identification.search.first_moments import first_window
from mechid.identification.search.multistart import robust_triangle
from mechid.identification.stages.families import ALL_TERMS, EVERYTHING, RECORDS, SLOW, Families, places_of
from mechid.identification.stages.settings import STAGES
from mechid.plant.detent import DETENT


def rank_effects(families: Families, base: AugmentedModel, q: FloatArray, windows: Windows) -> Iterator[list[str]]:
    """Yield the single effects that would explain most of some windows, by kind, the likeliest first.

    Effects of records come first, on their own if the windows are longer than the first moments, otherwise together
    with listed terms. Friction over the angle follows, only for longer windows, because the first moments do not
    determine its period. Detents of any number of periods come last. Of long windows they are judged by the first
    moments only, and they are skipped if friction over the angle explains far more than any listed effect. A kind is
    ranked on request.

    Parameters
    ----------
    families : Families
    base : AugmentedModel
    q : (n,)
        A point of it.
    windows : mapping of record to (first, stop)
    """
    listed = dict[str, float]()
    for family in (EVERYTHING,) if _are_first(families, windows) else (RECORDS, ALL_TERMS):
        scores = _scores(base, q, windows, families.model(family, base), None)
        listed |= scores
        # Lines are projected out: without a parameter they have no derivatives to be ranked by.
        lines = families.seen_lines if family.records else ()
        yield [*_best(scores, STAGES.singles), *(name for name in lines if name not in base.effects)]
    most, slow = max(listed.values(), default=0.0), _scan_slow(families, base, q, windows)
    yield _best({name: score for name, score in slow.items() if score > STAGES.slow_share * most}, len(SLOW))
    if max(slow.values(), default=0.0) > STAGES.slow_alone * most:
        return
    numbers = _spaced_terms(families, base, DETENT)
    found = _scan(families, base, q, _limit_windows(families.plain, windows), numbers)
    detents = {name: score for name, score in found.items() if not _has_better_neighbour(name, numbers, found)}
    yield _best(detents, STAGES.singles)


def _are_first(families: Families, windows: Windows) -> bool:
    """Tell whether windows are the first moments."""
    return all(windows[t.name] == first_window(t) for t in families.plain.targets)


def _scan_slow(families: Families, base: AugmentedModel, q: FloatArray, windows: Windows) -> dict[str, float]:
    """Return the score of the likeliest slow term of each list; empty over the first moments.

    The numbers of periods are scanned in steps, then one by one within a step of the likeliest.
    """
    found: dict[str, float] = {}
    if _are_first(families, windows):
        return found
    for table in SLOW:
        scores = _scan(families, base, q, windows, _spaced_terms(families, base, table))
        for best in _best(scores, 1):
            scores |= _scan_near(families, base, q, windows, best, STAGES.slow_step, scores)
            found |= {name: scores[name] for name in _best(scores, 1)}
    return found


def _scan_near(
    families: Families,
    base: AugmentedModel,
    q: FloatArray,
    windows: Windows,
    best: str,
    step: float,
    known: Collection[str],
) -> dict[str, float]:
    """Return the scores of unlisted terms whose number of periods is within one step of another one's."""
    here, own = families.periods(best), families.by_periods[families.unlisted_terms[best].table]
    between = range(math.floor(here / step), math.ceil(here * step) + 1)
    near = [own[number] for number in between if number in own and own[number] not in known]
    return _scan(families, base, q, windows, near)


def _scan(
    families: Families, base: AugmentedModel, q: FloatArray, windows: Windows, names: Sequence[str]
) -> dict[str, float]:
    """Return the score of each unlisted term of a list, evaluated for as many at once as the plant has places."""
    found: dict[str, float] = {}
    table = families.unlisted_terms[names[0]].table if names else ""
    places = places_of(table) if names else 1
    for first in range(0, len(names), places):
        # All terms of a list share one plant, so a scan compiles no kernel; others of the list fill its last places.
        some = names[first : first + places]
        filled = [*some, *(name for name in families.by_periods[table].values() if name not in some)][:places]
        found |= _scores(base, q, windows, _model_for_scan(families, base, filled), some)
    return found


def _model_for_scan(families: Families, base: AugmentedModel, names: Sequence[str]) -> AugmentedModel:
    """Return a model with some more unlisted terms; of a slow list without places for the rest of the library.

    A kernel with all places takes three times as long to compile, and four times as long for a step.
    """
    if families.is_slow(names[0]):
        return base.lay_out_with(families.plain, names, families.record_tables)
    return families.with_effects(base, names, (), "scanned")


def _spaced_terms(families: Families, base: AugmentedModel, table: str) -> list[str]:
    """Return the terms of a list at spaced numbers of periods; empty if the model has a term of the list."""
    own = families.by_periods.get(table, {})
    if not families.allows_terms or any(name in own.values() for name in base.effects):
        return []
    step, chosen, last = STAGES.slow_step if table in SLOW else STAGES.scan_step, list[str](), 0.0
    for number in sorted(own):
        # Spacing by a factor, because neighbours look alike in proportion to their number.
        if number >= step * last:
            chosen.append(own[number])
            last = number
    return chosen


def _limit_windows(plain: Problem, windows: Windows) -> Windows:
    """Limit the total duration of windows: the shortest are kept, the others replaced by the first moments."""
    kept, left_s = {}, STAGES.scan_s
    for target in sorted(plain.targets, key=lambda t: windows[t.name][1]):
        left_s -= windows[target.name][1] / target.base.sample_rate_hz
        kept[target.name] = windows[target.name] if left_s > 0.0 else first_window(target)
    return kept


def _scores(
    base: AugmentedModel, q: FloatArray, windows: Windows, wide: AugmentedModel, names: Sequence[str] | None
) -> dict[str, float]:
    """Return the score of each effect of a wide model that another one lacks: the explained cost less k ln N."""
    at, problem = wide.point_of(base, q), wide.problem
    triangle = combine_triangles([robust_triangle(problem, at, windows), *problem.prior_triangles(at)])
    further = {n: own for n, own in wide.names_by_effect.items() if n not in base.effects}
    groups = groups_of(problem, {n: own for n, own in further.items() if names is None or n in names})
    penalty = bayesian_penalty(triangle.samples)
    found = cost_reductions(triangle, groups)
    return {name: fall - penalty * len(groups[name]) for name, fall in found.items() if math.isfinite(fall)}


def _has_better_neighbour(name: str, names: Sequence[str], found: Mapping[str, float]) -> bool:
    """Tell whether a neighbour in the scan explains more."""
    k, least = names.index(name), -math.inf
    near = (other for other in names[max(k - 1, 0) : k + 2] if other != name)
    return any(found.get(other, least) > found[name] for other in near)


def _best(scores: Mapping[str, float], most: int) -> list[str]:
    """Return the names of the best positive scores, the best first."""
    return sorted((name for name, score in scores.items() if score > 0.0), key=lambda name: -scores[name])[:most]


def effect_scores(families: Families, base: AugmentedModel, q: FloatArray) -> dict[str, float]:
    """Return the score of each effect over the first seconds of records that the model follows.

    Detents of any number of periods are scanned over less time, where neighbouring numbers look alike. The likeliest
    and its neighbours are then compared over all of it.
    """
    windows, short = (_at_most(families.plain, s) for s in (STAGES.effect_scores_s, STAGES.effect_scan_s))
    found = _scores(base, q, windows, families.model(EVERYTHING, base), None)
    found |= _scan_slow(families, base, q, windows)
    numbers = _spaced_terms(families, base, DETENT)
    for best in _best(_scan(families, base, q, short, numbers), 1):
        found |= _scan_near(families, base, q, windows, best, STAGES.scan_step, ())
    return found


def _at_most(plain: Problem, seconds: float) -> Windows:
    """Return windows of at most so many seconds at the beginning of each record."""
    return {t.name: (0, min(t.samples, round(seconds * t.base.sample_rate_hz))) for t in plain.targets}
