"""Candidate model of a diagnosis: the mechanism as written plus some effects of the library, at its optimum."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.effects.disturbance import Disturbance, missing_tables
from mechid.identification.effects.effect import AddedTerms, add_terms, lay_out, share_kernel
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
    """Setting common to all models of a diagnosis.

    Attributes
    ----------
    problem : Problem
        Problem of the mechanism as written, with the per-record parameters of the fit. Its noise levels are the initial
        ones, or the residuals of a model where these are lower.
    windows : mapping of record to (first, stop)
        Samples of the records that the fit follows.
    disturbances : tuple of Disturbance
        Candidate disturbances of the records.
    considered : frozenset of str
        Names of the candidate effects.
    rules : EffectRules
    libraries : dict
        Cache of the libraries by identity of the mechanism and number of further terms; building one takes a second.
        Each entry also holds its mechanism.
    """

    problem: Problem
    windows: Windows
    disturbances: tuple[Disturbance, ...]
    considered: frozenset[str]
    rules: EffectRules = IN_DIAGNOSIS
    libraries: dict[tuple[int, int], tuple[Mechanism, Superset | None]] = field(default_factory=dict)

    @property
    def samples(self) -> int:
        """Number of samples of all windows and channels."""
        channels = {t.name: len(t.channels) for t in self.problem.targets}
        return sum(channels[name] * (stop - first) for name, (first, stop) in self.windows.items())


@dataclass(frozen=True, eq=False)
class CandidateModel:
    """A mechanism with some effects, at its optimum.

    Attributes
    ----------
    setting : Setting
    base : Mechanism
        The mechanism as written, with alternative laws in place of its own.
    laws : tuple of str
        Names of the alternative laws.
    terms, disturbances : tuple of str
        Names of the added effects.
    further : tuple of Extension
        Candidate terms beyond those that the blocks list.
    q : (n,)
    cost : float
        In sigmas squared, at the setting's noise levels.
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
        """Names of all effects that the mechanism as written lacks."""
        return (*self.laws, *self.terms, *self.disturbances)

    @property
    def misfit(self) -> float:
        """Cost beyond noise, in sigmas squared."""
        return max(self.cost - self.setting.samples, 0.0)

    @property
    def over_noise(self) -> float:
        """Residual-to-noise ratio, by RMS."""
        return math.sqrt(self.cost / self.setting.samples)

    @property
    def rules(self) -> EffectRules:
        """Thresholds that an effect has to reach."""
        return self.setting.rules

    @property
    def freedom(self) -> int:
        """Number of coordinates."""
        return self.problem.size

    @property
    def is_of_whole_records(self) -> bool:
        """Whether the windows cover the whole records."""
        return dict(self.setting.windows) == dict(self.setting.problem.whole_windows())

    @property
    def share(self) -> float:
        """Share of the records' samples that lie in the windows."""
        return self.setting.samples / replace(self.setting, windows=self.setting.problem.whole_windows()).samples

    def move_to(self, other: CandidateModel) -> CandidateModel:
        """Move the model to the point of another one, in that one's windows and at its noise levels."""
        there = replace(self, setting=other.setting)
        return there._at_point(transfer_values(other.problem, other.q, there.problem))

    def restrict_windows(self, horizons: Mapping[str, int]) -> CandidateModel:
        """Restrict the windows to the first samples of each record; the point stays."""
        windows = {name: (0, n) for name, n in horizons.items()}
        return replace(self, setting=replace(self.setting, windows=windows))._at_point(self.q)

    def lower_levels(self) -> CandidateModel:
        """Lower the noise levels to the residuals within the windows; return the same model where none is above."""
        problem = lower_levels(self.problem, self.q, self.setting.windows)
        return self if problem is self.problem else self.at_levels(problem)

    def at_levels(self, problem: Problem) -> CandidateModel:
        """Take over the noise levels of a problem; the point stays."""
        setting = replace(self.setting, problem=copy_levels(self.setting.problem, problem))
        return replace(self, setting=setting)._at_point(self.q)

    def _at_point(self, q: FloatArray) -> CandidateModel:
        return replace(self, q=q, cost=self.problem.total_norm(q, self.setting.windows) ** 2)

    def keep_effects(self, effects: Collection[str]) -> CandidateModel:
        """Keep only some terms and disturbances, and fit."""
        return self.restrict_to(effects).fit(self)

    def restrict_to(self, effects: Collection[str]) -> CandidateModel:
        """Keep only some terms and disturbances, without a fit."""
        terms, disturbances = ([n for n in names if n in effects] for names in (self.terms, self.disturbances))
        return replace(self, terms=tuple(terms), disturbances=tuple(disturbances))

    @cached_property
    def library(self) -> Superset | None:
        """The mechanism with all terms of the library, most at their null values."""
        # The entry keeps its mechanism alive: the identity of a freed object may be given to another one.
        known, key = self.setting.libraries, (id(self.base), len(self.further))
        if key not in known:
            known[key] = self.base, superset_of(self.base, further=self.further)
        return known[key][1]

    @cached_property
    def problem(self) -> Problem:
        """The problem with the effects' parameters free."""
        if self.terms:
            return self._problem_of_terms(self.setting.problem, self.terms, self.disturbances)
        # The mechanism's own plant takes a quarter of the time of one with places for all terms.
        some = self._of(self.disturbances)
        return lay_out(AddedTerms(self.base), (), missing_tables(self.base, some)).problem(self.setting.problem, some)

    @cached_property
    def landscape(self) -> Landscape:
        """Derivatives at the optimum, by the free parameters and by those of each further candidate."""
        looked_for = self.setting.considered - {*self.effects}

        def widen(plain: Problem, names: Sequence[str]) -> tuple[Problem, FloatArray]:
            others = [name for name in names if name not in self.disturbances]
            wide = self._problem_of_terms(plain, (*self.terms, *names), others)
            return wide, transfer_values(self.problem, self.q, wide)

        effects = {name: own for name, own in self.parameters.items() if name in looked_for}
        return landscape_at(self.problem, self.q, self.setting.windows, effects, widen)

    def scores(self) -> Mapping[str, Score]:
        """Return the score of each further candidate effect."""
        return self.landscape.scores()

    def needed_effects(self, shrinkage: Mapping[str, float] | None = None) -> frozenset[str]:
        """Return the terms and disturbances that the optimum needs by its derivatives; all where there are none.

        `shrinkage` holds the widths of small priors by dotted name, if the model was fitted with such priors.
        """
        problem = replace(self.problem, shrinkage=shrinkage or {})
        named = {name: self.parameters[name] for name in (*self.terms, *self.disturbances)}
        found = linearise(problem, self.q, self.setting.windows, named) if named else None
        return found.needed_effects if found else frozenset(named)

    def _problem_of_terms(self, problem: Problem, terms: Collection[str], disturbances: Collection[str]) -> Problem:
        added = replace(add_terms(self.library, terms), widths={}) if self.library else AddedTerms(self.base)
        freed = added.problem(problem, self._of(disturbances))
        return share_kernel(freed, self.library) if self.library else freed

    def _of(self, names: Collection[str]) -> list[Disturbance]:
        return [one for one in self.setting.disturbances if one.name in names]

    @cached_property
    def parameters(self) -> Mapping[str, tuple[str, ...]]:
        """Dotted names of the parameters of each candidate term and disturbance, by its name."""
        terms = {t.name: tuple(t.widths) for t in self.library.terms} if self.library else {}
        own = {one.name: tuple(p.name for p in one.parameters) for one in self.setting.disturbances if one.parameters}
        return terms | own

    @property
    def words(self) -> Mapping[str, str]:
        """Description of each effect by its name, including those of the mechanism as written."""
        words = words_of(self.setting.problem.space.mechanism)
        words |= {one.name: one.words for one in self.setting.disturbances}
        return words | {t.name: t.words for t in (self.library.terms if self.library else ())}

    @property
    def other_laws(self) -> Iterator[Law]:
        """Candidate laws that the model does not have."""
        return (law for law in rivals_of(self.base) if law.name in self.setting.considered - {*self.laws})

    @property
    def law_parameters(self) -> tuple[str, ...]:
        """Dotted names of the free parameters of the alternative laws."""
        known = self.setting.problem.space.mechanism.parameters
        return tuple(p.name for p in self.base.free if p.name not in known)

    def with_effect(self, effect: str) -> CandidateModel:
        """Add an effect, fit, and grow the horizons again."""
        return self.add_effect(effect).fit(self).regrow()

    def add_effect(self, effect: str) -> CandidateModel:
        """Add an effect at its null value, or a law at its start, without a fit."""
        if effect in self._library_names:
            return replace(self, terms=(*self.terms, effect))
        if effect in {one.name for one in self.setting.disturbances}:
            return replace(self, disturbances=(*self.disturbances, effect))
        law = next(law for law in self.other_laws if law.name == effect)
        return self.use_law(law, law.mechanism)

    def remove_effect(self, effect: str) -> CandidateModel:
        """Remove an effect, without a fit."""
        rest = [name for name in self.effects if name != effect]
        return self._without_law(effect) if effect in self.laws else self.restrict_to(rest)

    def without(self, effect: str) -> CandidateModel:
        """Remove an effect and fit; the result is cached."""
        if effect not in self._fits_without:
            self._fits_without[effect] = self.remove_effect(effect).fit(self)
        return self._fits_without[effect]

    @cached_property
    def _fits_without(self) -> dict[str, CandidateModel]:
        return {}

    @cached_property
    def effective_samples(self) -> float:
        """Effective sample count of all records at the point; all samples where the simulation fails."""
        if not math.isfinite(self.cost):
            return float(self.setting.samples)
        return count_effective_samples(self.problem, self.q, self.setting.windows)

    def _without_law(self, name: str) -> CandidateModel:
        base, values = self.setting.problem.space.mechanism, self.problem.coordinates.values(self.q)
        rest = tuple(law for law in self.laws if law != name)
        for other in rest:
            law = next(one for one in rivals_of(base) if one.name == other)
            base = law.mechanism.with_values({n: values[n] for n in law.own if n in values})
        return replace(self, base=base, laws=rest)

    def use_law(self, law: Law, mechanism: Mechanism) -> CandidateModel:
        """Take a mechanism with an alternative law, without the terms that it does not list; no fit."""
        other = replace(self, base=mechanism, laws=(*self.laws, law.name))
        return replace(other, terms=tuple(name for name in self.terms if name in other._library_names))

    def is_better_than(self, other: CandidateModel) -> bool:
        """Tell whether the Bayesian criterion prefers this model, with the noise of the better one of the two."""
        better = min(self, other, key=lambda one: one.cost)
        penalty = bayesian_penalty(better.effective_samples)
        mine, others = (
            better.effective_samples * one.cost / better.cost + one.freedom * penalty for one in (self, other)
        )
        return mine < others

    def at(self, values: Mapping[str, float]) -> CandidateModel:
        """Move the model to values by dotted name, without a fit."""
        return self._at_point(self.problem.coordinates.point(values))

    def add_candidates(self, some: Sequence[Extension]) -> CandidateModel:
        """Add further candidate terms; the point stays."""
        wider = replace(self, further=(*self.further, *some))
        names = {t.name for t in wider.library.terms} if wider.library else set()
        setting = replace(self.setting, considered=self.setting.considered | names - self._library_names)
        wider = replace(wider, setting=setting)
        return replace(wider, q=transfer_values(self.problem, self.q, wider.problem))

    @property
    def _library_names(self) -> set[str]:
        return {t.name for t in self.library.terms} if self.library else set()

    def fit(self, near: CandidateModel, *, steps: int | None = None) -> CandidateModel:
        """Fit the model from the optimum of another one, in at most `steps` steps."""
        most = self.rules.steps if steps is None else steps
        return self._fit_from(transfer_values(near.problem, near.q, self.problem), near.effective_samples, most)

    def regrow(self) -> CandidateModel:
        """Grow the horizons and fit again, since a joint fit alone may have stopped on a wrong branch.

        A model with a residual at the noise level is on the right branch. Windows shorter than the records come from a
        growth already. A branch that does not follow all records is not better.
        """
        if self.over_noise <= self.rules.noise_limit or not self.is_of_whole_records:
            return self
        # A fixed seed, so that a diagnosis of the same fit repeats.
        growth = grow_horizons(self.problem, self.q, np.random.default_rng(0), escapes=self.rules.escapes)
        other = self._fit_from(growth.q, self.effective_samples, self.rules.steps) if growth.complete else self
        return other if other.cost < self.cost else self

    def _fit_from(self, q: FloatArray, samples: float, steps: int) -> CandidateModel:
        """Fit the model from a point, with a tolerance that suits the effective sample count."""
        problem, windows = self.problem, self.setting.windows

        def solve_from(x: FloatArray) -> Solution:
            return solve(problem, x, windows, steps=steps, tolerance=self.rules.tolerance / samples)

        found = leave_corner(problem, solve_from(q), solve_from)
        # A better fit leaves whiter residuals with more effective samples, which ask for a finer tolerance.
        there = self._at_point(found.q)
        return (
            there._fit_from(there.q, there.effective_samples, steps)
            if there.effective_samples > self.rules.finer * samples
            else there
        )
