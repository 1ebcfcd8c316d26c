"""Forward selection of missing effects: the likeliest one by the score test is fitted, and kept if the fit confirms it.

Selection, pruning and exchange are the same during a fit and in a diagnosis. A candidate defines how it is fitted, and
its rules define the thresholds.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Protocol, Self, TypeVar

from scipy.special import chdtrc

from mechid.identification.effects.scores import Score
from mechid.identification.effects.settings import EffectRules
from mechid.plant.law import Law

Say = Callable[[str], object]


def silent(words: str) -> None:
    """Ignore the words."""


class Candidate(Protocol):
    """Model with some effects, at its optimum."""

    @property
    def rules(self) -> EffectRules:
        """Thresholds that an effect must exceed."""

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of its effects."""

    @property
    def cost(self) -> float:
        """Sum of squares, in sigmas squared of the known noise."""

    @property
    def misfit(self) -> float:
        """Part of the cost beyond noise."""

    @property
    def effective_samples(self) -> float:
        """Effective samples of all records."""

    @property
    def freedom(self) -> int:
        """Degrees of freedom; only differences count."""

    def scores(self) -> Mapping[str, Score]:
        """Return the score of each further effect that it may have."""

    def with_effect(self, effect: str) -> Self:
        """Return the model fitted with one more effect."""

    def without(self, effect: str) -> Self:
        """Return the model fitted without one of its effects."""

    def is_better_than(self, other: Self) -> bool:
        """Tell whether the Bayesian criterion prefers this model to another one."""


Model = TypeVar("Model", bound=Candidate)


def gain(less: Model, more: Model) -> Score:
    """Score the improvement of one model over another, using effective sample counts."""
    fall = max(less.cost - more.cost, 0.0)
    freedom = max(more.freedom - less.freedom, 1)
    return Score(
        more.effective_samples * fall / more.cost, freedom, share_of_misfit(less, fall), more.effective_samples
    )


def share_of_misfit(model: Candidate, fall: float) -> float:
    """Return a reduction of the cost as a share of a model's misfit beyond noise, part of which noise may hide."""
    return fall / max(model.misfit, fall, 1.0)


def is_significant(score: Score, rules: EffectRules, least_share: float = 0.0) -> bool:
    """Tell whether a score exceeds chance and the cost of its degrees of freedom."""
    enough = least_share <= 0.0 or score.share >= least_share
    return score.chi_square > rules.least_chi_square and score.excess > 0.0 and enough


def is_confirmed(less: Model, more: Model) -> bool:
    """Tell whether a fit with a further effect explains enough to keep the effect."""
    return is_significant(gain(less, more), more.rules, more.rules.share)


def is_needed(less: Model, model: Model) -> bool:
    """Tell whether a fit without an effect of a model is clearly worse."""
    return is_significant(gain(less, model), model.rules, model.rules.share_to_stay)


def scores_of_misfit(model: Candidate, scores: Mapping[str, Score]) -> dict[str, Score]:
    """Return scores whose shares refer to the misfit instead of the sum of squares."""
    return {name: replace(s, share=share_of_misfit(model, s.share * model.cost)) for name, s in scores.items()}


def likely_effects(model: Candidate, scores: Mapping[str, Score]) -> list[str]:
    """Return the effects that the score test supports, the likeliest first."""
    rules, found = model.rules, scores_of_misfit(model, scores)
    sure: Collection[str] = found.keys()
    if found and rules.false_discoveries < 1.0:
        from scipy.stats import false_discovery_control  # loads in 0.4 s, needed only if the fit lacks something

        chances = false_discovery_control([chdtrc(s.dof, s.chi_square) for s in found.values()])
        sure = {name for name, chance in zip(found, chances, strict=True) if chance <= rules.false_discoveries}
    likely = [name for name, s in found.items() if name in sure and is_significant(s, rules, rules.share_of_score)]
    return sorted(likely, key=lambda name: -found[name].excess)


def add_likeliest(model: Model, tried: dict[str, str], say: Say = silent) -> Model | None:
    """Return the model with the likeliest further effect that a fit confirms; `tried` receives the rejected ones."""
    for name in likely_effects(model, model.scores())[: model.rules.tries]:
        if name in tried:
            continue
        say(f"{name} is fitted")
        more = model.with_effect(name)
        if is_confirmed(model, more):
            return more
        tried[name] = f"explains {100.0 * gain(model, more).share:.3g} % of the misfit in a fit"
    return None


def drop_unneeded(model: Model, order: Iterable[str], say: Say = silent) -> Iterator[tuple[str, Model]]:
    """Yield each effect that a fit does not need with the model without it, in some order of trial.

    The last effect is kept.
    """
    left = list(order)
    while len(model.effects) > 1:
        lost = next((name for name in left if not is_needed(model.without(name), model)), None)
        if lost is None:
            break
        say(f"without {lost}")
        model = model.without(lost)
        # The others are tried again without it, since dropping one effect may make another one necessary.
        left.remove(lost)
        yield lost, model


def better_law(model: Model, fitted: Iterable[tuple[Law, Model]]) -> tuple[Law, Model] | None:
    """Return the best law in place of the disturbance that imitates it, with its model; None if no law is better.

    A low-pass delays all records alike: delays of the records imitate it down to the noise, with more parameters.

    Parameters
    ----------
    model : Candidate
        Model with the disturbance.
    fitted : iterable of (Law, Candidate)
        Each law, and the model fitted with it in place of the disturbance.
    """
    law, other = min(fitted, key=lambda pair: pair[1].cost, default=(None, model))
    return (law, other) if law and other.is_better_than(model) else None
