"""First sight of records in which every remedy has been tried: none is offered that does not make a record fit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from mechid.identification.contradiction.agreement_text import SAME_UNIT, TORQUE_UNITS
from mechid.identification.contradiction.first_sight import SCALES, FirstSight, first_sight
from mechid.identification.contradiction.record_sight import is_looked_at, own_rates, sight_of
from mechid.identification.contradiction.trial import GAIN, Trial, declared, strongest, trials
from mechid.identification.output_error.declaration import Reading
from mechid.identification.output_error.problem import Problem
from mechid.identification.search.settings import SEARCH
from mechid.units import to_si_factor

ALIKE = 3.0
"""Factor by which a usual unit may be off the one that the spectra suggest: they tell hundreds from thousands."""


def confirmed_sight(problem: Problem, factors: Mapping[str, float], seed: int = 0) -> FirstSight:
    """Return what is plainly otherwise than declared, where a short search confirms it.

    Parameters
    ----------
    problem : Problem
        All records as declared.
    factors : mapping of record to float
        What the numbers of its leading channel are multiplied by, to be in N m.
    seed : int
        Of the points of the box at which spectra are compared.
    """
    sight = first_sight(problem, seed)
    if sight.common_scale != 1.0:
        return _common(problem, sight, factors)
    for names, readings in _suspected(problem, sight, factors):
        sight = _judged(problem, sight, names, readings)
    return sight


def _suspected(
    problem: Problem, sight: FirstSight, factors: Mapping[str, float]
) -> Iterator[tuple[tuple[str, ...], list[dict[str, Reading]]]]:
    """Yield the records of each suspicion with the readings that may be meant, the suggested one first."""
    targets = {t.name: t for t in problem.targets}
    for name, taken in sight.otherwise.items():
        if taken.swapped is not None:
            if name < taken.swapped:
                pair = (name, taken.swapped)
                yield pair, [{one: sight.otherwise[one] for one in pair}]
        elif taken.scale != 1.0:
            same_way = [k for k in SCALES if (k > 1.0) == (taken.scale > 1.0)]
            scales = _usual_scales([taken.scale, *same_way], factors.get(name, 1.0))
            yield (name,), [{name: Reading(scale=scale)} for scale in scales]
        elif taken.rate is not None:
            yield (name,), [{name: replace(taken, rate=rate)} for rate in own_rates(sight_of(targets[name]))]
        else:
            yield (name,), [{name: taken}]


def _usual_scales(suggested: Sequence[float], factor: float) -> list[float]:
    """Return suggested scales, and those of usual units near any of them, each once."""
    units = [to_si_factor(unit, "torque") / factor for unit in TORQUE_UNITS]
    near = [
        u for u in units if any(1.0 / ALIKE < u / scale < ALIKE for scale in suggested) and abs(u - 1.0) > SAME_UNIT
    ]
    found: list[float] = []
    for scale in (*suggested, *near):
        if all(abs(scale / other - 1.0) > SAME_UNIT for other in found):
            found.append(scale)
    return found


def _judged(
    problem: Problem, sight: FirstSight, names: Sequence[str], readings: Sequence[Mapping[str, Reading]]
) -> FirstSight:
    """Return a first sight in which a suspicion of some records is confirmed, or is none."""
    as_declared, *tried = trials(problem, [declared(names), *readings])
    helping = _helping(as_declared, tried)
    others = {name: taken for name, taken in sight.otherwise.items() if name not in names}
    rest = replace(sight, otherwise=others, doubtful=sight.doubtful - set(names))
    if as_declared.explains:
        return rest
    if not helping:
        return replace(rest, unexplained=rest.unexplained | set(names))
    best, *rivals = helping
    found = {**others, **readings[best]}
    in_order = {name: found[name] for name in sight.otherwise}
    if not rivals:
        unsure = sight.doubtful & set(names) if len(names) > 1 else frozenset[str]()
        return replace(rest, otherwise=in_order, doubtful=rest.doubtful | unsure)
    further = {name: tuple(readings[k][name] for k in rivals) for name in names}
    return replace(rest, otherwise=in_order, doubtful=rest.doubtful | set(names), rivals={**rest.rivals, **further})


def _helping(as_declared: Trial, tried: Sequence[Trial]) -> list[int]:
    """Return which trials help, the best first, without those that fit clearly worse than the best."""
    order = sorted((k for k, one in enumerate(tried) if one.is_better_than(as_declared)), key=lambda k: tried[k].cost)
    most = max(GAIN * tried[order[0]].cost, SEARCH.good_cost) if order else 0.0
    return [k for k in order if tried[k].cost <= most]


def _common(problem: Problem, sight: FirstSight, factors: Mapping[str, float]) -> FirstSight:
    """Return what unit all records have, if any makes the strongest of them fit."""
    names = [t.name for t in strongest([t for t in problem.targets if is_looked_at(t)])]
    scales = _usual_scales([sight.common_scale], factors.get(names[0], 1.0))
    as_declared, *tried = trials(problem, [declared(names), *(dict.fromkeys(names, Reading(scale=k)) for k in scales)])
    if as_declared.explains:
        return replace(sight, common_scale=1.0)
    found = [scales[k] for k in _helping(as_declared, tried)]
    if not found:
        return replace(sight, common_scale=1.0, level=1.0 if sight.common_scale < 1.0 else -1.0)
    return replace(sight, common_scale=found[0], rival_scales=tuple(found[1:]))
