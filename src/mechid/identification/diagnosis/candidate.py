"""Augmented model of a campaign: the mechanism as written with some effects of the library, at its optimum."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.effects.disturbance import Disturbance
from mechid.identification.effects.effect import AddedTerms, add_terms
from mechid.identification.effects.pruning import linearise
from mechid.identification.effects.scores import (
    Landscape,
    Score,
    bayesian_penalty,
    count_effective_samples,
    landscape_at,
)
from mechid.identification.effects.settings import IN_DIAGNOSIS, EffectRules
from mechid.identification.output_error.problem import Problem, Windows, transfer_values
from mechid.identification.search.gates import grow_horizons
from mechid.identification.search.solve import Solution, solve
from mechid.identification.stages.joint_fit import leave_corner
from mechid.identification.uncertainty.noise_levels import copy_levels, lower_levels
from mechid.plant.block import Extension
from mechid.plant.law import Law
from mechid.plant.mechanism import Mechanism
from mechid.plant.superset import Superset, rivals_of, superset_of, words_of


@dataclass(frozen=True, eq=False)
class Setting:
    """What all models of a diagnosis share.

    Attributes
    ----------
    problem : Problem
        Of the mechanism as written, with what the fit's records have of their own, the noise as known before the fit,
        or what a model leaves of them, where that is less.
    windows : mapping of record to (first, stop)
        What of the records the fit follows.
    disturbances : tuple of Disturbance
        That the records may have beside.
    considered : frozenset of str
        Names of the effects that are looked for.
    rules : EffectRules
    libraries : dict
        Libraries of mechanisms so far, each with its mechanism, whose identity and further terms tell it: making one
        takes a second.
    """

    problem: Problem
    windows: Windows
    disturbances: tuple[Disturbance, ...]
    considered: frozenset[str]
    rules: EffectRules = IN_DIAGNOSIS
    libraries: dict[tuple[int, int], tuple[Mechanism, Superset | None]] = field(default_factory=dict)

    @property
    def samples(self) -> int:
        """Samples of all windows and channels."""
        channels = {t.name: len(t.channels) for t in self.problem.targets}
        return sum(channels[name] * (stop - first) for name, (first, stop) in self.windows.items())


@dataclass(frozen=True, eq=False)
class Model:
    """A mechanism with some effects, at its optimum.

    Attributes
    ----------
    setting : Setting
    base : Mechanism
        As written, with the laws that stand in place of its own.
    laws : tuple of str
        Names of these.
    terms, disturbances : tuple of str
        Names of the effects that it has beside.
    further : tuple of Extension
        Terms that it may have beside, beyond those that its blocks list.
    q : (n,)
    cost : float
        In sigmas squared, the noise as known.
    """

    setting: Setting
    base: Mechanism
    laws: tuple[str, ...] = ()
    terms: tuple[str, ...] = ()
    disturbances: tuple[str, ...] = ()
    further: tuple[Extension, ...] = ()
    q: FloatArray = field(default_factory=lambda: np.zeros(0))
    cost: float = np.inf

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of all that it has and the mechanism as written has not."""
        return (*self.laws, *self.terms, *self.disturbances)

    @property
    def misfit(self) -> float:
        """What it leaves beyond noise, in sigmas squared."""
        return max(self.cost - self.setting.samples, 0.0)

    @property
    def over_noise(self) -> float:
        """RMS of what it leaves over that of the noise."""
        return math.sqrt(self.cost / self.setting.samples)

    @property
    def rules(self) -> EffectRules:
        """How much an effect has to explain."""
        return self.setting.rules

    @property
    def freedom(self) -> int:
        """Number of coordinates."""
        return self.problem.size

    @property
    def is_of_whole_records(self) -> bool:
        """Whether its windows leave nothing of the records out."""
        return dict(self.setting.windows) == dict(self.setting.problem.whole())

    @property
    def share(self) -> float:
        """Share of all samples of its records that its windows hold."""
        return self.setting.samples / replace(self.setting, windows=self.setting.problem.whole()).samples

    def where(self, other: Model) -> Model:
        """Return it where another one is, in its windows and at its noise levels."""
        there = replace(self, setting=other.setting)
        return there._at_point(transfer_values(other.problem, other.q, there.problem))

    def within(self, horizons: Mapping[str, int]) -> Model:
        """Return it over so many first samples of each record, where it is."""
        windows = {name: (0, n) for name, n in horizons.items()}
        return replace(self, setting=replace(self.setting, windows=windows))._at_point(self.q)

    def lowered(self) -> Model:
        """Return it with noise levels no higher than what it leaves within its windows; itself where none is."""
        problem = lower_levels(self.problem, self.q, self.setting.windows)
        return self if problem is self.problem else self.at_levels(problem)

    def at_levels(self, problem: Problem) -> Model:
        """Return it, where it is, with the noise levels of a problem."""
        setting = replace(self.setting, problem=copy_levels(self.setting.problem, problem))
        return replace(self, setting=setting)._at_point(self.q)

    def _at_point(self, q: FloatArray) -> Model:
        return replace(self, q=q, cost=self.problem.total_norm(q, self.setting.windows) ** 2)

    def keeping(self, effects: Collection[str]) -> Model:
        """Return it with some of its terms and disturbances alone, fitted."""
        return self.restricted_to(effects).fitted(self)

    def restricted_to(self, effects: Collection[str]) -> Model:
        """Return it with some of its terms and disturbances alone, not fitted."""
        terms, disturbances = ([n for n in names if n in effects] for names in (self.terms, self.disturbances))
        return replace(self, terms=tuple(terms), disturbances=tuple(disturbances))

    @cached_property
    def library(self) -> Superset | None:
        """The mechanism with all terms of the library, most at their null."""
        known, key = self.setting.libraries, (id(self.base), len(self.further))
        if key not in known:
            known[key] = self.base, superset_of(self.base, further=self.further)
        return known[key][1]

    @cached_property
    def problem(self) -> Problem:
        """The problem in which its effects are free."""
        return self._with_terms(self.terms).problem(self.setting.problem, self._of(self.disturbances))

    def _widened(self, problem: Problem, effects: Collection[str]) -> Problem:
        """Return its problem, or that with other weights, with some further effects free."""
        others = [name for name in effects if name not in self.disturbances]
        return self._with_terms((*self.terms, *effects)).problem(problem, self._of(others))

    def landscape(self) -> Landscape:
        """Return the derivatives at its optimum: to all that it has, and to each effect that is looked for beside."""
        looked_for = self.setting.considered - {*self.effects}

        def widened(plain: Problem, names: Sequence[str]) -> tuple[Problem, FloatArray]:
            wide = self._widened(plain, names)
            return wide, transfer_values(self.problem, self.q, wide)

        effects = {name: own for name, own in self.parameters.items() if name in looked_for}
        return landscape_at(self.problem, self.q, self.setting.windows, effects, widened)

    def scores(self) -> Mapping[str, Score]:
        """Return the score of each effect that is looked for beside."""
        return self.landscape().scores()

    def needed_effects(self, shrinkage: Mapping[str, float] | None = None) -> frozenset[str]:
        """Return the terms and disturbances that its optimum needs, as its derivatives have it; all where it has none.

        `shrinkage` holds the widths of small priors by dotted name, where it was fitted with such.
        """
        problem = replace(self.problem, shrinkage=shrinkage or {})
        named = {name: self.parameters[name] for name in (*self.terms, *self.disturbances)}
        found = linearise(problem, self.q, self.setting.windows, named)
        return found.needed if found else frozenset(named)

    def _with_terms(self, terms: Collection[str]) -> AddedTerms:
        return replace(add_terms(self.library, terms), widths={}) if self.library else AddedTerms(self.base)

    def _of(self, names: Collection[str]) -> list[Disturbance]:
        return [one for one in self.setting.disturbances if one.name in names]

    @cached_property
    def parameters(self) -> Mapping[str, tuple[str, ...]]:
        """Dotted names behind the coordinates of each term and disturbance that it may have, by its name."""
        terms = {t.name: tuple(t.widths) for t in self.library.terms} if self.library else {}
        own = {one.name: tuple(p.name for p in one.parameters) for one in self.setting.disturbances if one.parameters}
        return terms | own

    @property
    def words(self) -> Mapping[str, str]:
        """What each effect is in words, by its name: those of the mechanism as written, and disturbances."""
        words = words_of(self.setting.problem.space.mechanism)
        words |= {one.name: one.words for one in self.setting.disturbances}
        return words | {t.name: t.words for t in (self.library.terms if self.library else ())}

    @property
    def other_laws(self) -> Iterator[Law]:
        """Laws that are looked for and that it has not."""
        return (law for law in rivals_of(self.base) if law.name in self.setting.considered - {*self.laws})

    @property
    def law_parameters(self) -> tuple[str, ...]:
        """Dotted names of what is free of its laws."""
        known = self.setting.problem.space.mechanism.parameters
        return tuple(p.name for p in self.base.free if p.name not in known)

    def with_effect(self, effect: str) -> Model:
        """Return it with one more effect, fitted and grown anew."""
        return self.put_in(effect).fitted(self).regrown()

    def put_in(self, effect: str) -> Model:
        """Return it with one more effect where that is nothing, or a law at its start; not fitted."""
        if effect in self._listed:
            return replace(self, terms=(*self.terms, effect))
        if effect in {one.name for one in self.setting.disturbances}:
            return replace(self, disturbances=(*self.disturbances, effect))
        law = next(law for law in self.other_laws if law.name == effect)
        return self.in_place_of(law, law.mechanism)

    def take_out(self, effect: str) -> Model:
        """Return it without one of its effects, not fitted."""
        rest = [name for name in self.effects if name != effect]
        return self._without_law(effect) if effect in self.laws else self.restricted_to(rest)

    def without(self, effect: str) -> Model:
        """Return it without one of its effects, fitted; what has been fitted once is kept."""
        if effect not in self._less:
            self._less[effect] = self.take_out(effect).fitted(self)
        return self._less[effect]

    @cached_property
    def _less(self) -> dict[str, Model]:
        return {}

    @cached_property
    def effective_samples(self) -> float:
        """Effective samples of all records where it is; all samples where it cannot be simulated."""
        whole = float(self.setting.samples)
        return (
            count_effective_samples(self.problem, self.q, self.setting.windows) if math.isfinite(self.cost) else whole
        )

    def _without_law(self, name: str) -> Model:
        base, values = self.setting.problem.space.mechanism, self.problem.coordinates.values(self.q)
        rest = tuple(law for law in self.laws if law != name)
        for other in rest:
            law = next(one for one in rivals_of(base) if one.name == other)
            base = law.mechanism.with_values({n: values[n] for n in law.own if n in values})
        return replace(self, base=base, laws=rest)

    def in_place_of(self, law: Law, mechanism: Mechanism) -> Model:
        """Return it with a mechanism that has a law, without the terms that are none beside it, not fitted."""
        other = replace(self, base=mechanism, laws=(*self.laws, law.name))
        return replace(other, terms=tuple(name for name in self.terms if name in other._listed))

    def is_better_than(self, other: Model) -> bool:
        """Tell whether the Bayesian criterion prefers it, the noise being what the better of the two leaves."""
        better = min(self, other, key=lambda one: one.cost)
        penalty = bayesian_penalty(better.effective_samples)
        mine, others = (
            better.effective_samples * one.cost / better.cost + one.freedom * penalty for one in (self, other)
        )
        return mine < others

    def at(self, values: Mapping[str, float]) -> Model:
        """Return it at values by dotted name, not fitted."""
        return self._at_point(self.problem.coordinates.point(values))

    def with_further(self, some: Sequence[Extension]) -> Model:
        """Return it, where it is, with further terms that are looked for."""
        wider = replace(self, further=(*self.further, *some))
        names = {t.name for t in wider.library.terms} if wider.library else set()
        setting = replace(self.setting, considered=self.setting.considered | names - self._listed)
        wider = replace(wider, setting=setting)
        return replace(wider, q=transfer_values(self.problem, self.q, wider.problem))

    @property
    def _listed(self) -> set[str]:
        return {t.name for t in self.library.terms} if self.library else set()

    def fitted(self, near: Model, *, steps: int | None = None) -> Model:
        """Return it at its optimum, sought from that of another in so many steps at most."""
        most = self.rules.steps if steps is None else steps
        return self._fitted_from(transfer_values(near.problem, near.q, self.problem), near.effective_samples, most)

    def regrown(self) -> Model:
        """Return it fitted from where it follows the records: a joint fit alone may have stopped on a wrong branch.

        A model that leaves no more than noise has not; and where no other branch follows all records, none is better.
        Of windows that are not whole records growth has said already how far they go.
        """
        if self.over_noise <= self.rules.followed or not self.is_of_whole_records:
            return self
        growth = grow_horizons(self.problem, self.q, np.random.default_rng(0), escapes=self.rules.escapes)
        other = self._fitted_from(growth.q, self.effective_samples, self.rules.steps) if growth.complete else self
        return other if other.cost < self.cost else self

    def _fitted_from(self, q: FloatArray, samples: float, steps: int) -> Model:
        """Return it at its optimum, sought from a point of its problem, as near as so many samples let it be judged."""
        problem, windows = self.problem, self.setting.windows

        def solved(x: FloatArray) -> Solution:
            return solve(problem, x, windows, steps=steps, tolerance=self.rules.tolerance / samples)

        found = leave_corner(problem, solved(q), solved)
        there = self._at_point(found.q)
        return (
            there._fitted_from(there.q, there.effective_samples, steps)
            if there.effective_samples > self.rules.finer * samples
            else there
        )
