"""Missing effects of a search: disturbances that the data support, and laws in place of disturbances that imitate them.

They are added only if a fit without them leaves more than noise.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from mechid.campaign import Campaign
from mechid.identification.effects.campaign_disturbances import possible_disturbances, widen_priors
from mechid.identification.effects.disturbance import (
    Disturbance,
    FoundDisturbance,
    missing_tables,
    remove_disturbances,
    with_disturbances,
)
from mechid.identification.effects.effect import lay_out, substitute_law
from mechid.identification.effects.scores import Score, bayesian_penalty, count_effective_samples, scores
from mechid.identification.effects.selection import add_likeliest, better_law, drop_unneeded, gain
from mechid.identification.effects.settings import DURING_FIT, EffectRules
from mechid.identification.output_error.problem import transfer_coordinates, transfer_values
from mechid.identification.output_error.target import Target
from mechid.identification.result.search_state import SearchState
from mechid.identification.stages.joint_fit import joint_fit
from mechid.identification.stages.release import fit_with_noise_released
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.watch import Watch, residual_to_noise
from mechid.identification.uncertainty.model_error import deviations_from_null
from mechid.identification.uncertainty.settings import NOISE
from mechid.plant.law import Law
from mechid.plant.mechanism import Mechanism
from mechid.plant.superset import rivals_of


@dataclass(frozen=True, eq=False)
class SearchedModel:
    """State of a search as a candidate of the selection of effects; its fits are stages of the search.

    Attributes
    ----------
    watch : Watch
    state : SearchState
        Its `found` are the effects.
    names : tuple of str
        Names of the other free parameters.
    possible : tuple of Disturbance
        Disturbances that the records may have.
    released : bool
        Whether the noise is that released by the fit, not the level known before the search.
    """

    watch: Watch
    state: SearchState
    names: tuple[str, ...]
    possible: tuple[Disturbance, ...] = ()
    released: bool = False
    _less: dict[str, SearchedModel] = field(default_factory=dict, init=False)

    @property
    def rules(self) -> EffectRules:
        """Thresholds that an effect must exceed."""
        return DURING_FIT

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of its disturbances."""
        return tuple(found.disturbance.name for found in self.state.found)

    @cached_property
    def cost(self) -> float:
        """Sum of squares: of whole records at the noise known before the search, or at the released noise."""
        if self.released:
            return self.state.problem.total_norm(self.state.q, self.state.windows) ** 2
        ratios = _residual_to_noise(self.watch, self.state)
        return sum(ratios[t.name] ** 2 * t.samples for t in self.state.problem.targets)

    @property
    def misfit(self) -> float:
        """Part of the cost beyond noise."""
        return max(self.cost - sum(t.samples for t in self.state.problem.targets), 0.0)

    @cached_property
    def effective_samples(self) -> float:
        """Effective samples of all records."""
        return count_effective_samples(self.state.problem, self.state.q, self.state.windows)

    @property
    def freedom(self) -> int:
        """Degrees of freedom of its disturbances and of its law."""
        new = self.state.added.new if self.state.added else ()
        return sum(found.disturbance.dof for found in self.state.found) + len(new)

    def scores(self) -> Mapping[str, Score]:
        """Return the score of each possible disturbance."""
        return scores(self.state.problem, self.state.q, self.state.windows, self.possible) if self.possible else {}

    def drop_duplicate_candidates(self) -> SearchedModel:
        """Return the model without possible disturbances that free the same as its own.

        Its clock in another form is an example.
        """
        own = [found.disturbance for found in self.state.found]
        return replace(self, possible=tuple(one for one in self.possible if not any(map(one.overlaps, own))))

    def with_effect(self, effect: str) -> SearchedModel:
        """Return the model fitted with one more disturbance, whose improvement is stored with it."""
        one = next(one for one in self.possible if one.name == effect)
        problem = with_disturbances(self.state.problem, [one])
        begun = self.state.with_problem(problem).at(transfer_coordinates(self.state.problem, self.state.q, problem))
        names = (*self.names, *(p.name for p in one.parameters))
        more = self._fit(begun, f"with {one.name}", names, FoundDisturbance(one, math.nan, math.nan))
        # A prior that is too narrow would limit the effect and so its score: it is widened once.
        (wider,) = widen_priors((one,), problem, more.state.q, STAGES.at_edge, STAGES.wider)
        if wider is not one:
            one, problem = wider, with_disturbances(self.state.problem, [wider])
            begun = self.state.with_problem(problem).at(more.state.q)
            more = self._fit(begun, f"with {one.name}, wider", names, FoundDisturbance(one, math.nan, math.nan))
        score = gain(self, more)
        found = FoundDisturbance(one, score.chi_square, score.share)
        return replace(more, state=replace(more.state, found=(*self.state.found, found)))

    def without(self, effect: str) -> SearchedModel:
        """Return the model fitted without one of its disturbances; each fit is cached."""
        if effect not in self._less:
            self._less[effect] = self._fit(self._state_without(effect), f"without {effect}", self.names)
        return self._less[effect]

    def with_law(self, plain: Mechanism, law: Law, *, beside: bool = False) -> SearchedModel:
        """Return the model fitted with a law, in place of the disturbance that imitates it or beside it."""
        replaces = law.imitated_by in self.effects and not beside
        alone = self._state_without(law.imitated_by) if replaces else self.state
        terms = self.state.added.terms if self.state.added else ()
        own = [found.disturbance for found in alone.found]
        added = lay_out(substitute_law(plain, law), terms, missing_tables(plain, own))
        problem = added.problem(alone.problem)
        begun = replace(alone.with_problem(problem).at(transfer_values(alone.problem, alone.q, problem)), added=added)
        how = "beside" if beside else "in place of"
        return self._fit(begun, f"{law.name} {how} {self._imitation_of(law)}", (*self.names, *sorted(added.new)))

    def _imitation_of(self, law: Law) -> str:
        return law.imitated_by if law.imitated_by in self.effects else self.state.added.law if self.state.added else ""

    def _state_without(self, effect: str) -> SearchState:
        one = next(found.disturbance for found in self.state.found if found.disturbance.name == effect)
        rest = tuple(found for found in self.state.found if found.disturbance is not one)
        problem, q = remove_disturbances(self.state.problem, self.state.q, [one])
        return replace(self.state.with_problem(problem).at(q), found=rest)

    def _fit(self, begun: SearchState, name: str, names: tuple[str, ...], *further: FoundDisturbance) -> SearchedModel:
        state = joint_fit(self.watch, self.watch.note(begun), name, names, tolerance=self.rules.tolerance)
        return replace(self, state=replace(state, found=(*state.found, *further)))

    def is_better_than(self, other: SearchedModel) -> bool:
        """Tell whether the Bayesian criterion prefers this model to another one, at the released noise."""
        penalty = bayesian_penalty(other.effective_samples)
        return self.cost < other.cost + (other.freedom - self.freedom) * penalty


def fit_with_disturbances(watch: Watch, state: SearchState, campaign: Campaign, names: tuple[str, ...]) -> SearchState:
    """Fit with the noise released, and with the disturbances that the data support.

    If the residuals are white and within their noise, no disturbance is tried, and the fit is identical to one without
    this step. Otherwise the score of each possible disturbance is computed at the optimum, the best ones are fitted one
    at a time, and a disturbance is kept if it explains most of the misfit beyond noise. The noise is then released
    again, from its known level.
    """
    plain = fit_with_noise_released(watch, state, campaign.options, names)
    at = replace(restore_known_noise(watch, state), q=plain.q)
    model = SearchedModel(watch, at, names)
    if needs_more_effects(watch, plain):
        watch.tell("disturbances", "disturbances of the records are looked for")
        model = _add_needed_disturbances(
            replace(model, possible=possible_disturbances(plain.problem, campaign, plain.q))
        )
    fitted = _release_noise(model, state, plain, campaign)
    # The last one found is dropped first: it explains the least.
    while doubted := [found.disturbance for found in fitted.found if not _exceeds_its_error(fitted, found.disturbance)]:
        model = model.without(doubted[-1].name)
        fitted = _release_noise(model, state, plain, campaign)
    return watch.note(fitted)


def _add_needed_disturbances(model: SearchedModel) -> SearchedModel:
    """Return the model with the disturbances that explain the misfit of a fit without them."""
    while better := add_likeliest(model, {}):
        model = better
        for _, fewer in drop_unneeded(better, better.effects[:-1]):
            model = fewer
        model.watch.note(model.state)
        model = model.drop_duplicate_candidates()
    return model


def _release_noise(model: SearchedModel, state: SearchState, plain: SearchState, campaign: Campaign) -> SearchState:
    """Return a model fitted with its noise released; the plain fit if nothing was found."""
    if model.state.found == state.found:
        return plain
    return _refit_with_released_noise(model, campaign)


def _refit_with_released_noise(model: SearchedModel, campaign: Campaign) -> SearchState:
    """Fit with the noise released from its known level, with the parameters of the found disturbances free."""
    own = [p.name for found in model.state.found for p in found.disturbance.parameters]
    names = tuple(dict.fromkeys((*model.names, *own)))
    return fit_with_noise_released(model.watch, model.watch.note(model.state), campaign.options, names)


def replace_imitations(watch: Watch, state: SearchState, campaign: Campaign, names: tuple[str, ...]) -> SearchState:
    """Return the state with a law in place of its imitation, if the Bayesian criterion prefers it.

    The effect of a filter beyond its delay would bias the mechanism's values, and the record parameters would not show
    it, since all records have the same. A law is also compared with those of its own table: a filter of order 4
    imitates one of order 2.
    """
    if not campaign.options.terms:
        return state
    model = SearchedModel(watch, state, names, released=True)
    chosen = state.added.law if state.added else ""
    plain = campaign.mechanism
    imitated = [law for law in rivals_of(plain) if _is_imitated(law, chosen, model.effects)]
    better, beside = better_law(model, ((law, model.with_law(plain, law)) for law in imitated)), False
    if better is None and not chosen and needs_more_effects(watch, state):
        # The records may have both, such as a trigger's scatter and a filter.
        better = better_law(model, ((law, model.with_law(plain, law, beside=True)) for law in imitated))
        beside = True
    if better is None:
        return state
    at = restore_known_noise(watch, better[1].state)
    at = _refit_with_released_noise(SearchedModel(watch, at, names), campaign)
    return state if beside and needs_more_effects(watch, at) else at


def _is_imitated(law: Law, chosen: str, effects: Collection[str]) -> bool:
    """Tell whether the chosen law, or else a disturbance, may imitate a law."""
    if chosen:
        return law.name != chosen and law.name.partition(":")[0] == chosen.partition(":")[0]
    return law.imitated_by in effects


def _exceeds_its_error(state: SearchState, one: Disturbance) -> bool:
    """Tell whether a disturbance exceeds its own error, including the model error."""
    if not one.parameters:
        return True
    off = deviations_from_null(state.problem, state.q, state.windows, one)
    return float(off.max(initial=0.0)) > DURING_FIT.least_deviation


def needs_more_effects(watch: Watch, state: SearchState) -> bool:
    """Tell whether a residual is coloured, or larger than its noise allows."""
    return any(c.prefilter for t in state.problem.targets for c in t.channels) or not _is_within_noise(watch, state)


def restore_known_noise(watch: Watch, state: SearchState) -> SearchState:
    """Return the state with each channel's noise as known before the search, unless growth has raised it."""

    def restore(target: Target) -> Target:
        floors = {c.quantity: watch.noise.floors[target.name, c.quantity] for c in target.channels}
        return target.map_channels(lambda c: c if c.raised else replace(c, sigma=floors[c.quantity], prefilter=None))

    return state.with_problem(replace(state.problem, targets=tuple(map(restore, state.problem.targets))))


def _is_within_noise(watch: Watch, state: SearchState) -> bool:
    """Tell whether no residual exceeds its noise, or some record cannot be simulated."""
    ratios = _residual_to_noise(watch, state).values()
    return max(ratios) <= NOISE.misfit or not np.all(np.isfinite(list(ratios)))


def _residual_to_noise(watch: Watch, state: SearchState) -> dict[str, float]:
    """Return the residual-to-noise ratio by record, relative to the noise known before the search."""
    return residual_to_noise(state.problem, state.q, watch.noise.floors)
