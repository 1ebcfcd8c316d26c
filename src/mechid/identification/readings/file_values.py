"""Wrong values of the mechanism file: a detector of wrong counts, and a search far beyond catalogue errors.

Poles and gear ratio are known exactly, or wrong by a factor or a tooth. A motor with half the poles makes steps twice
as large, and its detents come at other multiples of the step rate; a gear with another ratio moves the load by other
steps. Both are held while the search runs, which then finds no start. So where no start explains the first steps of
the records, the counts are varied. One is reported only where it explains them down to their noise.

With an inertia in g cm2 for kg m2, or with bounds that exclude the true value, no start explains even the first
moments of the records. Then each value is searched by itself, a thousand times further either way. The wrong one
explains them from there; the others, which can only compensate for it, do not. Such a value is reported, never used.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from mechid.campaign import mechanism_from_table, mechanism_text
from mechid.errors import InputFileError
from mechid.identification.computation.journal import Journal
from mechid.identification.computation.parallel import map_tasks
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.readings.agreement import explains
from mechid.identification.readings.finding import Confidence, DeclaredRecords, Finding
from mechid.identification.readings.rules import RULES
from mechid.identification.readings.trial import Trial, search_start, steps_window, strongest_records
from mechid.identification.search.multistart import Candidate, multistart, refine
from mechid.identification.search.settings import SEARCH
from mechid.parameter import Parameter, Status
from mechid.plant.detent import DETENT
from mechid.plant.mechanism import Mechanism

POLES, RATIO, INERTIA = "stepper.poles", "gear.ratio", "inertia"


@dataclass(frozen=True)
class OtherCount:
    """Counts that explain the first steps, with the values of the mechanism file.

    Attributes
    ----------
    found, declared : mapping of str to float
        By dotted name, in the file's units.
    cost : float
        Robust cost a sample, sigmas squared.
    """

    found: Mapping[str, float]
    declared: Mapping[str, float]
    cost: float

    @property
    def words(self) -> str:
        """The values, each with that of the file."""
        return " and ".join(
            f"{name} = {v:.4g} ({self.declared[name]:.4g} in the file)" for name, v in self.found.items()
        )


def find_wrong_counts(records: DeclaredRecords, earlier: Sequence[Finding] = ()) -> Iterator[Finding]:
    """Yield the other counts with which a start explains the first steps; nothing after an earlier finding."""
    # An earlier finding may explain the same misfit.
    found = [] if earlier else other_counts(records)
    if found:
        yield Finding(
            (),
            "count",
            "with the counts of the mechanism file no start explains their first steps; one does with "
            f"{', or with '.join(one.words for one in found)}: steps, detents and load then move as the records show",
            confidence=Confidence.AMBIGUOUS if len(found) > 1 else Confidence.CONFIRMED,
        )


def other_counts(records: DeclaredRecords) -> list[OtherCount]:
    """Return the counts and inertias any one of which explains the strongest records, likeliest first."""
    problem, mechanism = records.problem, records.problem.space.mechanism
    targets = strongest_records(records.readable)
    if not targets or POLES not in mechanism.parameters:
        return []
    part = replace(problem, targets=tuple(targets))
    windows = {t.name: steps_window(t) for t in targets}
    declared = search_start(part, part.targets, windows)
    if declared.explains:
        return []
    found: list[OtherCount] = []
    for names, other, trial in _vary(part, windows, declared):
        if trial.explains and RULES.count_gain * max(trial.cost, 1.0) <= declared.cost:
            values = {name: other.value(name) for name in names}
            of_file = {name: mechanism.value(name) for name in names}
            if all(abs(value / of_file[name] - 1.0) < RULES.same_count for name, value in values.items()):
                return []
            found.append(OtherCount(values, of_file, trial.cost))
            # No gear ratio compensates for steps of another size.
            if POLES in names:
                break
    return sorted(found, key=lambda one: one.cost)


def _vary(problem: Problem, windows: Windows, declared: Trial) -> Iterator[tuple[tuple[str, ...], Mechanism, Trial]]:
    """Yield the names of varied values, the mechanism with these at their best, and the trial."""
    mechanism = problem.space.mechanism
    poles = mechanism.parameters[POLES]
    for other in (factor * poles.value for factor in RULES.pole_factors):
        if poles.status is Status.KNOWN and other >= poles.declaration.lower and not other % 2.0:
            yield from _vary_poles(problem, windows, declared, other)
    if not _is_known(mechanism, RATIO):
        return
    at, trial = _best_ratio(problem, windows, declared)
    yield (RATIO,), at, trial
    if not trial.explains:
        return
    # Another ratio may only compensate for a wrong inertia: each known inertia is tried as well.
    for name, q in mechanism.parameters.items():
        if name.endswith(INERTIA) and q.status is Status.KNOWN and q.value > 0.0:
            part = _replace_mechanism(problem, mechanism.with_parameters({name: _widen_bounds(q)}))
            trial = search_start(part, part.targets, windows)
            yield (name,), part.space.at(part.coordinates.of_mechanism(trial.best.q)), trial


def _vary_poles(
    problem: Problem, windows: Windows, declared: Trial, poles: float
) -> Iterator[tuple[tuple[str, ...], Mechanism, Trial]]:
    """Yield mechanisms with other poles: with detents of the same periods, and of the same orders.

    Detents of the same periods have other orders, and their equations take seconds to compile. They are tried only
    where the changed step size alone brings the model nearer.
    """
    mechanism = problem.space.mechanism
    scale = mechanism.value(POLES) / poles
    changed = {POLES: poles} | {name: scale * mechanism.value(name) for name in _detent_periods(mechanism)}
    same_orders = mechanism.with_parameters(
        {name: replace(mechanism.parameters[name], value=value) for name, value in changed.items()}
    )
    nearer = _search(problem, same_orders, windows)
    if nearer.cost >= declared.cost:
        return
    table = tomllib.loads(mechanism_text(mechanism))
    table["stepper"]["poles"] = poles
    try:
        same_periods = mechanism_from_table(table, "other poles")
    except InputFileError:  # a user's own block is found only beside the mechanism file, not from a table in memory
        pass
    else:
        measured = same_periods.plant.with_outputs([*mechanism.plant.outputs])
        same_periods = replace(same_periods, plant=measured)
        yield (POLES,), same_periods, _search(problem, same_periods, windows)
    yield tuple(changed), same_orders, nearer


def _detent_periods(mechanism: Mechanism) -> list[str]:
    return [name for name in mechanism.parameters if name.startswith(f"{DETENT}.") and name.endswith("period_deg")]


def _search(problem: Problem, mechanism: Mechanism, windows: Windows) -> Trial:
    """Return the best start with another mechanism."""
    part = _replace_mechanism(problem, mechanism)
    return search_start(part, part.targets, windows)


def _best_ratio(problem: Problem, windows: Windows, declared: Trial) -> tuple[Mechanism, Trial]:
    """Return the mechanism with the ratio that explains the records best, found from start to start, and its trial."""
    from scipy.optimize import minimize_scalar  # takes 0.1 s to load, and most records need no search

    q = problem.space.mechanism.parameters[RATIO]
    tried: dict[float, Trial] = {1.0: declared}

    def at(factor: float) -> Mechanism:
        return problem.space.mechanism.with_parameters({RATIO: replace(q, value=factor * q.value)})

    def cost(factor: float) -> float:
        # The optimum moves little between near ratios: the best start of the nearest one is a warm start.
        nearest = min(tried, key=lambda one: abs(one / factor - 1.0))
        part = _replace_mechanism(problem, at(factor))
        tried[float(factor)] = search_start(part, part.targets, windows, [tried[nearest].best.q])
        return tried[float(factor)].cost

    for factors in (RULES.ratio_factors, [1.0 / factor for factor in RULES.ratio_factors]):
        for factor in factors:
            cost(factor)
    best = min(tried, key=lambda factor: tried[factor].cost)
    if tried[best].cost * RULES.ratio_promising < declared.cost:
        around = sorted(tried)
        k = around.index(best)
        limits = around[max(k - 1, 0)], around[min(k + 1, len(around) - 1)]
        minimize_scalar(cost, bounds=limits, method="bounded", options={"xatol": 1e-3, "maxiter": 12})
        best = min(tried, key=lambda factor: tried[factor].cost)
    return at(best), tried[best]


def _is_known(mechanism: Mechanism, name: str) -> bool:
    return name in mechanism.parameters and mechanism.parameters[name].status is Status.KNOWN


def _widen_bounds(q: Parameter) -> Parameter:
    return replace(q, status=Status.FREE, min=q.value / RULES.inertia_factor, max=q.value * RULES.inertia_factor)


def _replace_mechanism(problem: Problem, mechanism: Mechanism) -> Problem:
    return replace(problem, space=SearchSpace(mechanism))


def find_wrong_values(
    problem: Problem, seed: int, tell: Callable[[str], None], journal: Journal | None = None
) -> list[Finding]:
    """Return findings on wrong values of the mechanism file, the likeliest first.

    Parameters
    ----------
    problem : Problem
        Records whose first moments no start within the file's bounds explains.
    seed : int
    tell : callable
        Called with the name of each searched parameter.
    journal : Journal or None
        Stores the starts, so that a run can be resumed.
    """
    found: list[tuple[float, Parameter, float]] = []
    for parameter in filter(_may_be_wrong, problem.space.mechanism.parameters.values()):
        tell(parameter.name)
        other = _widen_range(problem, parameter)
        starts = multistart(other, seed, other.workers, journal=journal)[: SEARCH.batch]
        refined = map_tasks(partial(refine, other, steps=SEARCH.robust_steps), starts, other.workers)
        best = min(refined, key=lambda c: c.cost, default=Candidate(other.start, math.inf))
        value = other.space.values(other.coordinates.of_mechanism(best.q))[parameter.name]
        if explains(other, best) and _is_beyond(parameter, value):
            found.append((best.cost, parameter, value))
    found.sort(key=lambda one: one[0])
    likely = [one for one in found if one[0] <= RULES.value_rivals * found[0][0]]
    confidence = Confidence.CONFIRMED if len(likely) == 1 else Confidence.AMBIGUOUS
    return [
        Finding((), "value", _value_words(q, value), confidence=confidence, parameter=q.name) for _, q, value in likely
    ]


def _value_words(q: Parameter, found: float) -> str:
    """Return a sentence on the value that was found and the one in the file."""
    declared = f"between {q.min:.4g} and {q.max:.4g}" if q.is_free else f"{q.value:.4g}"
    window_ms = 1e3 * SEARCH.first_window_s
    return (
        f"With the values and bounds of the mechanism file no start explains the first {window_ms:g} ms of the "
        f"records; with {q.name} at about {found:.3g} {q.declaration.unit} ({declared} in the file) one does."
    )


def _may_be_wrong(q: Parameter) -> bool:
    """Tell whether a parameter may be wrong by a factor: it is positive and has a unit of its own."""
    d = q.declaration
    plain = not (d.structural or q.tied_to or (d.typical and q.is_free))
    return plain and d.unit not in ("1", "deg", "rad") and q.value > 0.0 and d.lower >= 0.0


def _widen_range(problem: Problem, q: Parameter) -> Problem:
    """Free a parameter in a wide range about its value, searched on a logarithmic scale."""
    d = q.declaration
    wide = replace(
        q,
        declaration=replace(d, spread=RULES.value_factor, typical=None),
        min=max(q.value / RULES.value_factor, d.lower),
        max=min(q.value * RULES.value_factor, d.upper),
        status=Status.FREE,
    )
    priors = {name: prior for name, prior in problem.priors.items() if name != q.name}
    space = SearchSpace(problem.space.mechanism.with_parameters({q.name: wide}))
    return replace(problem, space=space, priors=priors)


def _is_beyond(q: Parameter, value: float) -> bool:
    """Tell whether a value lies outside the file's bounds, or outside the usual error of catalogue values."""
    if q.is_free:
        return not q.min <= value <= q.max
    return abs(math.log(value / q.value)) > math.log(q.declaration.spread)
