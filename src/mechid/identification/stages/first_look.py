"""Look at a model: a short robust fit over the first moments or other windows, and its pruning."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from mechid.arrays import FloatArray
from mechid.identification.computation.journal import Journal
from mechid.identification.effects.augmented import AugmentedModel
from mechid.identification.effects.scores import bayesian_penalty
from mechid.identification.output_error.digests import identity
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.search.first_moments import first_window
from mechid.identification.search.multistart import NO_WINDOWS, Candidate, cost_with_priors, refine
from mechid.identification.search.settings import SEARCH
from mechid.identification.stages.families import (
    Families,
)
from mechid.identification.stages.settings import STAGES


@dataclass(frozen=True, eq=False)
class FirstLook:
    """Model refined over the first moments.

    Attributes
    ----------
    model : AugmentedModel
    q : (n,)
    cost : float
        Robust cost including priors, in sigmas squared.
    samples : int
        Number of samples of all channels.
    """

    model: AugmentedModel
    q: FloatArray
    cost: float
    samples: int

    @property
    def cost_per_sample(self) -> float:
        """Robust cost per sample, in sigmas squared: about 1 if only noise is left."""
        return self.cost / self.samples

    @property
    def explains(self) -> bool:
        """Whether no more than noise is left of the first moments."""
        return self.cost_per_sample < SEARCH.explained

    @property
    def explains_surely(self) -> bool:
        """Whether the misfit is within the uncertainty of a record's noise level."""
        return self.cost_per_sample < STAGES.surely_explained

    @property
    def settles(self) -> bool:
        """Whether effects of the mechanism alone leave only noise; values of records imitate laws, and do not count."""
        return bool(self.model.added.names) and not self.model.disturbances and self.explains_surely

    def explains_misfit_of(self, other: FirstLook) -> bool:
        """Tell whether no more than noise is left, or only little of another look's misfit beyond noise.

        A record's noise is known only to some per cent until a model follows it.
        """
        return self.explains or self.cost_per_sample - 1.0 < STAGES.left_of_excess * (other.cost_per_sample - 1.0)

    @property
    def criterion(self) -> float:
        """Bayesian criterion: the cost plus ln N for each free parameter (Schwarz 1978)."""
        return self.cost + self.model.problem.size * bayesian_penalty(self.samples)


def fit_look(
    model: AugmentedModel,
    q: FloatArray,
    journal: Journal,
    windows: Windows = NO_WINDOWS,
    steps: int = SEARCH.robust_steps,
) -> FirstLook:
    """Return a model refined over the first moments, or over other windows, from a point of it.

    The first half of each window is fitted before the whole, because fewer switches between sticking and sliding are
    wrong there. If the result costs more than the point itself, the whole is fitted from the point directly.
    """
    windows = windows or first_windows(model.problem)
    halves = {name: (first, first + (stop - first) // 2) for name, (first, stop) in windows.items()}

    def work() -> dict[str, object]:
        at_point = cost_with_priors(model.problem, q, windows)
        initial = refine(model.problem, Candidate(q, 0.0), steps // 2, halves, priors=True)
        found = refine(model.problem, initial, steps, windows, priors=True)
        if found.cost > at_point:
            found = refine(model.problem, Candidate(q, 0.0), steps, windows, priors=True)
        return {"q": found.q, "cost": found.cost}

    found = journal.step("first look", [identity(model.problem), q, windows, steps], work)
    samples = sum((windows[t.name][1] - windows[t.name][0]) * len(t.channels) for t in model.problem.targets)
    return FirstLook(model, found["q"], found["cost"], samples)


def first_windows(problem: Problem) -> Windows:
    """Return the windows of the first moments of all records."""
    return {t.name: first_window(t) for t in problem.targets}


def prune_look(
    families: Families, look: FirstLook, tell: Callable[[str], None], journal: Journal, windows: Windows = NO_WINDOWS
) -> FirstLook:
    """Refit a look without the effects that are not needed; return it unchanged if its misfit is too large."""
    if look.cost_per_sample >= STAGES.prunable or not look.model.names_by_effect:
        return look
    needed = look.model.needed_effects(look.q, windows or first_windows(families.plain))
    if needed is None:
        return look
    tell(f"needed there: {effect_words(needed)}")
    less = look.model.keep_effects(families.plain, needed, ", ".join(needed) or "as written")
    q = less.point_of(look.model, look.q)
    # Nothing is pruned: past a stall, where a fit takes seconds of the budget, the growth itself fits it further.
    is_whole = bool(windows) and set(needed) == set(look.model.effects)
    found = replace(look, model=less, q=q) if is_whole else fit_look(less, q, journal, windows)
    # Effects that have reached the edge of their prior get a wider one, since pruning leaves them more to explain.
    wider = less.widen_priors(families.plain, found.q, STAGES.at_edge, STAGES.wider)
    return found if wider is less else fit_look(wider, wider.point_of(less, found.q), journal, windows)


def effect_words(needed: Mapping[str, float]) -> str:
    """Return the names of effects, each with the cost that it explains."""
    return ", ".join(f"{name} ({rise:.0f})" if rise else name for name, rise in needed.items()) or "none"
