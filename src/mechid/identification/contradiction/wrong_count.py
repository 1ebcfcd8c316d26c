"""Poles and gear ratio against the records: counts that are known exactly, or wrong by a factor or a tooth.

A motor with half the poles makes steps twice as large, and its detents come at other multiples of the step rate; a
gear with another ratio moves the load by other steps. Both are held while the search runs, which then finds no start.
So where no start explains the first steps of the records, the counts are varied. One is reported only where it
explains them to their noise.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from mechid.campaign import mechanism_from_table, mechanism_text
from mechid.errors import InputFileError
from mechid.identification.contradiction.record_sight import is_looked_at
from mechid.identification.contradiction.trial import Trial, search_start, steps_window, strongest
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.space import SearchSpace
from mechid.parameter import Parameter, Status
from mechid.plant.detent import DETENT
from mechid.plant.mechanism import Mechanism

POLES, RATIO, INERTIA = "stepper.poles", "gear.ratio", "inertia"
POLE_FACTORS = (2.0, 0.5)
"""Teeth of the rotor for poles, and steps a turn for poles."""
RATIO_FACTORS = (1.03, 1.1, 1.3, 2.0)
"""Factors and inverse factors by which a ratio is varied before the best one is looked for in between."""
PROMISING = 1.2
"""Times the cost of the file's ratio over that of the best of these, from which it is looked for in between."""
LEAST_GAIN = 2.0
"""Times the cost of other counts that the file's cost at least, where others are reported. Without a false alarm in 11
campaigns of benchmarks/first_sight.py, three of them with a model that lacks the housing or detents."""
SAME = 0.01
"""Relative distance from the file's value up to which another one is the same count: its better start is luck of the
search, since the file's values then explain the records as well. A tooth of a gear of 50 is 0.02."""
FACTOR = 2.0
"""By how much a known inertia may be off where it is looked for. A choice, not measured."""


@dataclass(frozen=True)
class OtherCount:
    """Values of the mechanism file that explain the first steps, and those that the file has.

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


def wrong_count_lines(problem: Problem) -> list[str]:
    """Return a line where no start explains the first steps with the file's counts, and one does with others."""
    found = other_counts(problem)
    if not found:
        return []
    return [
        "all records: with the counts of the mechanism file no start explains their first steps; one does with "
        f"{', or with '.join(one.words for one in found)}: steps, detents and load then move as the records show"
    ]


def other_counts(problem: Problem) -> list[OtherCount]:
    """Return the counts, and inertias, with any one of which the strongest records are explained, the likeliest first.

    Parameters
    ----------
    problem : Problem
        All records as declared.
    """
    mechanism = problem.space.mechanism
    targets = strongest([t for t in problem.targets if is_looked_at(t)])
    if not targets or POLES not in mechanism.parameters:
        return []
    part = replace(problem, targets=tuple(targets))
    windows = {t.name: steps_window(t) for t in targets}
    declared = search_start(part, part.targets, windows)
    if declared.explains:
        return []
    found: list[OtherCount] = []
    for names, other, trial in _others(part, windows, declared):
        if trial.explains and LEAST_GAIN * max(trial.cost, 1.0) <= declared.cost:
            values = {name: other.value(name) for name in names}
            of_file = {name: mechanism.value(name) for name in names}
            if all(abs(value / of_file[name] - 1.0) < SAME for name, value in values.items()):
                return []
            found.append(OtherCount(values, of_file, trial.cost))
            if POLES in names:  # no ratio makes up for steps of another size
                break
    return sorted(found, key=lambda one: one.cost)


def _others(problem: Problem, windows: Windows, declared: Trial) -> Iterator[tuple[tuple[str, ...], Mechanism, Trial]]:
    """Yield the names of what is varied, the mechanism with it at its best, and the trial."""
    mechanism = problem.space.mechanism
    poles = mechanism.parameters[POLES]
    for other in (factor * poles.value for factor in POLE_FACTORS):
        if poles.status is Status.KNOWN and other >= poles.declaration.lower and not other % 2.0:
            yield from _with_poles(problem, windows, declared, other)
    if not _is_known(mechanism, RATIO):
        return
    at, trial = _best_ratio(problem, windows, declared)
    yield (RATIO,), at, trial
    if not trial.explains:
        return
    for name, q in mechanism.parameters.items():  # a ratio may stand for an inertia that is wrong
        if name.endswith(INERTIA) and q.status is Status.KNOWN and q.value > 0.0:
            part = _with_mechanism(problem, mechanism.with_parameters({name: _looked_for(q)}))
            trial = search_start(part, part.targets, windows)
            yield (name,), part.space.at(part.coordinates.of_mechanism(trial.best.q)), trial


def _with_poles(
    problem: Problem, windows: Windows, declared: Trial, poles: float
) -> Iterator[tuple[tuple[str, ...], Mechanism, Trial]]:
    """Yield mechanisms with other poles: with detents of the same periods, and of the same orders.

    Detents of the same periods have other orders, whose equations take seconds to compile: so they come only where the
    other steps alone bring the model nearer.
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
    except InputFileError:  # a block of the user's own, whose file lies beside the mechanism's
        pass
    else:
        yield (POLES,), same_periods, _search(problem, same_periods, windows)
    yield tuple(changed), same_orders, nearer


def _detent_periods(mechanism: Mechanism) -> list[str]:
    return [name for name in mechanism.parameters if name.startswith(f"{DETENT}.") and name.endswith("period_deg")]


def _search(problem: Problem, mechanism: Mechanism, windows: Windows) -> Trial:
    """Return the best start with another mechanism."""
    part = _with_mechanism(problem, mechanism)
    return search_start(part, part.targets, windows)


def _best_ratio(problem: Problem, windows: Windows, declared: Trial) -> tuple[Mechanism, Trial]:
    """Return the mechanism with the ratio that explains the records best, found from start to start, and its trial."""
    from scipy.optimize import minimize_scalar  # takes 0.1 s to load, and most records need no search

    q = problem.space.mechanism.parameters[RATIO]
    tried: dict[float, Trial] = {1.0: declared}

    def at(factor: float) -> Mechanism:
        return problem.space.mechanism.with_parameters({RATIO: replace(q, value=factor * q.value)})

    def cost(factor: float) -> float:
        nearest = min(tried, key=lambda one: abs(one / factor - 1.0))
        part = _with_mechanism(problem, at(factor))
        tried[float(factor)] = search_start(part, part.targets, windows, [tried[nearest].best.q])
        return tried[float(factor)].cost

    for factors in (RATIO_FACTORS, [1.0 / factor for factor in RATIO_FACTORS]):
        for factor in factors:
            cost(factor)
    best = min(tried, key=lambda factor: tried[factor].cost)
    if tried[best].cost * PROMISING < declared.cost:
        around = sorted(tried)
        k = around.index(best)
        limits = around[max(k - 1, 0)], around[min(k + 1, len(around) - 1)]
        minimize_scalar(cost, bounds=limits, method="bounded", options={"xatol": 1e-3, "maxiter": 12})
        best = min(tried, key=lambda factor: tried[factor].cost)
    return at(best), tried[best]


def _is_known(mechanism: Mechanism, name: str) -> bool:
    return name in mechanism.parameters and mechanism.parameters[name].status is Status.KNOWN


def _looked_for(q: Parameter) -> Parameter:
    return replace(q, status=Status.FREE, min=q.value / FACTOR, max=q.value * FACTOR)


def _with_mechanism(problem: Problem, mechanism: Mechanism) -> Problem:
    return replace(problem, space=SearchSpace(mechanism))
