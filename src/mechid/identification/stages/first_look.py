"""A look at a model: refined over the first moments of the records, or over other windows, and pruned there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from mechid.arrays import FloatArray
from mechid.identification.computation.journal import Journal
from mechid.identification.effects.augmented import AugmentedModel
from mechid.identification.effects.scores import bayesian_penalty
from mechid.identification.output_error.identity import identity
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
    """A model refined over the first moments.

    Attributes
    ----------
    model : AugmentedModel
    q : (n,)
    cost : float
        Robust cost, priors counted, in sigmas squared.
    samples : int
        Of all channels.
    """

    model: AugmentedModel
    q: FloatArray
    cost: float
    samples: int

    @property
    def left(self) -> float:
        """Cost a sample."""
        return self.cost / self.samples

    @property
    def explains(self) -> bool:
        """Whether it leaves no more than noise of the first moments."""
        return self.left < SEARCH.explained

    @property
    def explains_surely(self) -> bool:
        """Whether it leaves no more than what the noise of a record is uncertain by."""
        return self.left < STAGES.surely_explained

    def explains_what_is_left_of(self, other: FirstLook) -> bool:
        """Whether it leaves no more than noise, or little of what another one leaves beyond noise.

        The noise of a record is known to some per cent only until a model follows it.
        """
        return self.explains or self.left - 1.0 < STAGES.left_of_excess * (other.left - 1.0)

    @property
    def criterion(self) -> float:
        """Bayesian criterion: the cost, and ln N for each freedom (Schwarz 1978)."""
        return self.cost + self.model.problem.size * bayesian_penalty(self.samples)


def refined_look(
    model: AugmentedModel,
    q: FloatArray,
    journal: Journal,
    windows: Windows = NO_WINDOWS,
    steps: int = SEARCH.robust_steps,
) -> FirstLook:
    """Return a model refined over the first moments, or over other windows, from a point of it.

    Over the first half of them before the whole: there fewer switches between sticking and sliding have gone wrong.
    Over the whole from the point itself where that has led to more than it leaves.
    """
    windows = windows or first_windows(model.problem)
    halves = {name: (first, first + (stop - first) // 2) for name, (first, stop) in windows.items()}

    def work() -> dict[str, object]:
        at_point = cost_with_priors(model.problem, q, windows)
        begun = refine(model.problem, Candidate(q, 0.0), steps // 2, halves, priors=True)
        found = refine(model.problem, begun, steps, windows, priors=True)
        if found.cost > at_point:
            found = refine(model.problem, Candidate(q, 0.0), steps, windows, priors=True)
        return {"q": found.q, "cost": found.cost}

    found = journal.step("first look", [identity(model.problem), q, windows, steps], work)
    samples = sum((windows[t.name][1] - windows[t.name][0]) * len(t.channels) for t in model.problem.targets)
    return FirstLook(model, found["q"], found["cost"], samples)


def first_windows(problem: Problem) -> Windows:
    """Return the windows of the first moments of all records."""
    return {t.name: first_window(t) for t in problem.targets}


def pruned_look(
    families: Families, look: FirstLook, tell: Callable[[str], None], journal: Journal, windows: Windows = NO_WINDOWS
) -> FirstLook:
    """Return a look without the effects that are not needed there, refined again; itself where it leaves too much."""
    if look.left >= STAGES.prunable or not look.model.names_by_effect:
        return look
    needed = look.model.needed(look.q, windows or first_windows(families.plain))
    if needed is None:
        return look
    tell(f"needed there: {effect_words(needed)}")
    less = look.model.keeping(families.plain, needed, ", ".join(needed) or "as written")
    found = refined_look(less, less.point_of(look.model, look.q), journal, windows)
    wider = less.widened(families.plain, found.q, STAGES.at_edge, STAGES.wider)
    return found if wider is less else refined_look(wider, wider.point_of(less, found.q), journal, windows)


def effect_words(needed: Mapping[str, float]) -> str:
    """Return the names of effects, each with what it explains."""
    return ", ".join(f"{name} ({rise:.0f})" if rise else name for name, rise in needed.items()) or "none"
