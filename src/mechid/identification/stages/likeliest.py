"""Ranking of single effects by the derivatives at one point of a model, terms of any number of periods among them.

With each effect all parameters of the model are free to make room. Of terms with neighbouring numbers of periods, which
short windows do not tell apart, the best one is returned.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence

from mechid.arrays import FloatArray
from mechid.identification.effects.augmented import AugmentedModel
from mechid.identification.effects.pruning import falls, groups_of
from mechid.identification.effects.scores import bayesian_penalty
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import combine_triangles
from mechid.identification.search.first_moments import first_window
from mechid.identification.search.multistart import robust_triangle
from mechid.identification.stages.families import ALL_TERMS, EVERYTHING, RECORDS, SLOW, Families, places_of
from mechid.identification.stages.settings import STAGES
from mechid.plant.detent import DETENT


def likeliest_effects(families: Families, base: AugmentedModel, q: FloatArray, windows: Windows) -> Iterator[list[str]]:
    """Yield single effects that would explain most of some windows beside a model, by kind, the likeliest first.

    First those of records, by themselves where the windows are longer than the first moments, with terms that are
    listed else; then friction over the angle, whose period the first moments do not tell, over longer windows only;
    then detents of any number of periods, of which long windows are judged by their first moments alone, unless
    friction over the angle explains far more than anything listed. A kind is ranked when it is asked for.

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
        lines = families.seen_lines if family.records else ()  # these have no derivatives
        yield [*_best(scores, STAGES.singles), *(name for name in lines if name not in base.effects)]
    most, slow = max(listed.values(), default=0.0), _scan_slow(families, base, q, windows)
    yield _best({name: score for name, score in slow.items() if score > STAGES.slow_share * most}, len(SLOW))
    if max(slow.values(), default=0.0) > STAGES.slow_alone * most:
        return
    numbers = _in_steps(families, base, DETENT)
    found = _scan(families, base, q, _at_most_long(families.plain, windows), numbers)
    detents = {name: score for name, score in found.items() if not _is_beside_better(name, numbers, found)}
    yield _best(detents, STAGES.singles)


def _are_first(families: Families, windows: Windows) -> bool:
    """Tell whether windows are the first moments."""
    return all(windows[t.name] == first_window(t) for t in families.plain.targets)


def _scan_slow(families: Families, base: AugmentedModel, q: FloatArray, windows: Windows) -> dict[str, float]:
    """Return what the likeliest slow term of each list explains beside a model; none over the first moments.

    First in steps, then every number of periods within one step of the likeliest.
    """
    found: dict[str, float] = {}
    if _are_first(families, windows):
        return found
    for table in SLOW:
        scores = _scan(families, base, q, windows, _in_steps(families, base, table))
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
    """Return what unlisted terms explain whose number of periods lies within one step of another one's."""
    here, own = families.periods(best), families.by_periods[families.unlisted[best].table]
    between = range(math.floor(here / step), math.ceil(here * step) + 1)
    near = [own[number] for number in between if number in own and own[number] not in known]
    return _scan(families, base, q, windows, near)


def _scan(
    families: Families, base: AugmentedModel, q: FloatArray, windows: Windows, names: Sequence[str]
) -> dict[str, float]:
    """Return what each unlisted term of a list explains beside a model, as many at once as there are places."""
    found: dict[str, float] = {}
    places = places_of(families.unlisted[names[0]].table) if names else 1
    for first in range(0, len(names), places):
        some = names[first : first + places]
        found |= _scores(base, q, windows, families.with_effects(base, some, (), "scanned"), some)
    return found


def _in_steps(families: Families, base: AugmentedModel, table: str) -> list[str]:
    """Return the terms of a list whose numbers of periods are looked at, in steps; none where the model has one."""
    own = families.by_periods.get(table, {})
    if not families.allows_terms or any(name in own.values() for name in base.effects):
        return []
    step, chosen, last = STAGES.slow_step if table in SLOW else STAGES.scan_step, list[str](), 0.0
    for number in sorted(own):
        if number >= step * last:
            chosen.append(own[number])
            last = number
    return chosen


def _at_most_long(plain: Problem, windows: Windows) -> Windows:
    """Return windows of so many seconds at most: the shortest as they are, of the others the first moments."""
    kept, left_s = {}, STAGES.scan_s
    for target in sorted(plain.targets, key=lambda t: windows[t.name][1]):
        left_s -= windows[target.name][1] / target.base.sample_rate_hz
        kept[target.name] = windows[target.name] if left_s > 0.0 else first_window(target)
    return kept


def _scores(
    base: AugmentedModel, q: FloatArray, windows: Windows, wide: AugmentedModel, names: Sequence[str] | None
) -> dict[str, float]:
    """Return what each effect that a wide model has beside another one explains, less k ln N."""
    at, problem = wide.point_of(base, q), wide.problem
    triangle = combine_triangles([robust_triangle(problem, at, windows), *problem.prior_triangles(at)])
    further = {n: own for n, own in wide.names_by_effect.items() if n not in base.effects}
    groups = groups_of(problem, {n: own for n, own in further.items() if names is None or n in names})
    penalty = bayesian_penalty(triangle.samples)
    found = falls(triangle, groups)
    return {name: fall - penalty * len(groups[name]) for name, fall in found.items() if math.isfinite(fall)}


def _is_beside_better(name: str, names: Sequence[str], found: Mapping[str, float]) -> bool:
    """Tell whether a neighbour in the scan explains more."""
    k, least = names.index(name), -math.inf
    near = (other for other in names[max(k - 1, 0) : k + 2] if other != name)
    return any(found.get(other, least) > found[name] for other in near)


def _best(scores: Mapping[str, float], most: int) -> list[str]:
    """Return the names of the best scores above none, the best first."""
    return sorted((name for name, score in scores.items() if score > 0.0), key=lambda name: -scores[name])[:most]


def effect_scores(families: Families, base: AugmentedModel, q: FloatArray) -> dict[str, float]:
    """Return what each effect beside a model that follows the records would explain of their first seconds.

    Detents of any number of periods are gone through over fewer of them, where neighbouring numbers look alike, and the
    likeliest and its neighbours compared over all.
    """
    windows, short = (_at_most(families.plain, s) for s in (STAGES.effect_scores_s, STAGES.effect_scan_s))
    found = _scores(base, q, windows, families.model(EVERYTHING, base), None)
    found |= _scan_slow(families, base, q, windows)
    numbers = _in_steps(families, base, DETENT)
    for best in _best(_scan(families, base, q, short, numbers), 1):
        found |= _scan_near(families, base, q, windows, best, STAGES.scan_step, ())
    return found


def _at_most(plain: Problem, seconds: float) -> Windows:
    """Return the windows of so many seconds at the beginning of each record."""
    return {t.name: (0, min(t.samples, round(seconds * t.base.sample_rate_hz))) for t in plain.targets}
