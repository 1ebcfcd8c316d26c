"""What each effect of the library would take of what a model leaves: one pass of derivatives for all of them.

At an optimum the residual has no component along what is free. What a further effect would take of it follows from
its derivative less what the free ones can imitate (Rao's score test), each record's samples counted for their worth.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.beside.beside import lifted
from mechid.identification.beside.groups import groups_of, needed
from mechid.identification.diagnosis.candidate import Model
from mechid.identification.disturbance.scores import Score, by_own_residuals, following, score_of
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.reduction import combine_triangles


@dataclass(frozen=True, eq=False)
class Landscape:
    """Derivatives at a model's optimum to what is free, and to all effects that it has not.

    Attributes
    ----------
    residual : (m,)
    free : (m, n)
        Derivatives to what is free.
    effects : mapping of str to (m, k)
        Derivatives to each effect.
    worth : float
        Effective samples of all records.
    failed : tuple of str
        Effects of which there are no derivatives: the simulation with them fails.
    """

    residual: FloatArray
    free: FloatArray
    effects: Mapping[str, FloatArray]
    worth: float
    failed: tuple[str, ...] = ()

    @property
    def too_wide(self) -> tuple[str, ...]:
        """Effects with which as much would be free as there are effective samples: a fit explains anything then."""
        free = self.free.shape[1]
        return tuple(name for name, J in self.effects.items() if free + J.shape[1] >= self.worth)

    def score(self, *names: str) -> Score:
        """Return what some effects together would take."""
        further = np.column_stack([self.effects[name] for name in names])
        return score_of(self.residual, self.free, further, further.shape[1], self.worth)

    def scores(self) -> dict[str, Score]:
        """Return what each effect by itself would take."""
        return {name: self.score(name) for name in self.effects if name not in self.too_wide}

    def like(self, name: str) -> Iterator[str]:
        """Yield the effects that take as much as one does, and with it no more: which of them it is remains open."""
        own = self.score(name)
        for other in self.effects:
            if other != name:
                both, alone = self.score(name, other), self.score(other)
                if both.over < own.over and both.over < alone.over:
                    yield other


def landscape_of(model: Model) -> Landscape:
    """Return the landscape at a model's optimum.

    The terms and disturbances that the model has are free; the effects are those of the library that it has not, as far
    as they are looked for.
    """
    plain, worth = by_own_residuals(model.problem, model.q, model.setting.windows)
    looked_for = [name for name in model.parameters if name in model.setting.considered - {*model.effects}]
    found = _derivatives(model, plain, looked_for)
    failed = [] if found else [name for name in looked_for if not _derivatives(model, plain, [name])]
    if found is None:
        found = _derivatives(model, plain, [name for name in looked_for if name not in failed])
    if found is None:
        none = np.zeros((0, 0))
        return Landscape(np.zeros(0), none, {}, worth, tuple(looked_for))
    return Landscape(*found, worth, tuple(failed))


def _derivatives(
    model: Model, plain: Problem, effects: Sequence[str]
) -> tuple[FloatArray, FloatArray, dict[str, FloatArray]] | None:
    """Return the residual and its derivatives to what is free and to some effects; None where the simulation fails."""
    wide = model.widened(plain, effects)
    triangles = wide.triangles(lifted(model.problem, model.q, wide), model.setting.windows)
    if not triangles or not all(np.all(np.isfinite(t.jacobian)) for t in triangles):
        return None
    records, priors = combine_triangles(triangles), plain.prior_triangles(model.q)
    moved = ~plain.coordinates.on_bound(model.q)
    follows = following(plain, model.q, wide)[:, moved]
    residual = np.concatenate([records.fun, *(t.fun for t in priors)])
    free = np.vstack([records.jacobian @ follows, *(t.jacobian[:, moved] for t in priors)])
    below = residual.size - records.fun.size
    columns = {
        name: [j for j, p in enumerate(wide.coordinates.names) if p in model.parameters[name]] for name in effects
    }
    further = {
        effect: np.vstack([records.jacobian[:, places], np.zeros((below, len(places)))])
        for effect, places in columns.items()
        if places
    }
    return residual, free, further


def needed_effects(model: Model, wanted_small: Mapping[str, float] | None = None) -> frozenset[str]:
    """Return the terms and disturbances of a model that its optimum needs, as its derivatives have it.

    Parameters
    ----------
    model : Model
    wanted_small : mapping of str to float, or None
        Widths of small priors by dotted name, where the model was fitted with such.
    """
    problem = replace(model.problem, shrinkage=wanted_small or {})
    weighted, worth = by_own_residuals(problem, model.q, model.setting.windows)
    triangle = weighted.joint(model.q, model.setting.windows)
    effects = (*model.terms, *model.disturbances)
    if not np.all(np.isfinite(triangle.jacobian)):
        return frozenset(effects)
    groups = groups_of(weighted, {name: model.parameters[name] for name in effects})
    return frozenset(needed(triangle, model.away, groups, worth))
