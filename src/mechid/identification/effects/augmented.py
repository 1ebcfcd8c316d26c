"""Augmented model: a mechanism with added terms or a law, and records with disturbances, some of them free."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.effects.campaign_disturbances import widen_priors
from mechid.identification.effects.disturbance import Disturbance, missing_tables
from mechid.identification.effects.effect import (
    AddedTerms,
    add_terms,
    distance_from_null,
    lay_out,
    rename_values,
    share_kernel,
)
from mechid.identification.effects.pruning import groups_of, needed_groups
from mechid.identification.output_error.problem import Problem, Windows, transfer_values
from mechid.plant.superset import Superset


@dataclass(frozen=True, eq=False)
class AugmentedModel:
    """Problem in which some effects are free in addition to the mechanism as written.

    Attributes
    ----------
    name : str
        Name of the family of effects.
    problem : Problem
    added : AddedTerms
        Its terms, or its law.
    disturbances : tuple of Disturbance
    superset : Superset or None
        All terms that its mechanism may have; None if there are none.
    base : AddedTerms
        Model without its terms: the mechanism as written, or with a law.
    """

    name: str
    problem: Problem
    added: AddedTerms
    disturbances: tuple[Disturbance, ...]
    superset: Superset | None
    base: AddedTerms

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of its terms, its law and its disturbances."""
        return (*self.added.names, *(one.name for one in self.disturbances))

    @property
    def names_by_effect(self) -> dict[str, tuple[str, ...]]:
        """Dotted names of the parameters of each term and disturbance; a law cannot be dropped and is not included."""
        return self.added.names_by_term | {one.name: tuple(p.name for p in one.parameters) for one in self.disturbances}

    def point_of(self, other: AugmentedModel, q: FloatArray) -> FloatArray:
        """Return a point of another model in this one, (n,): new parameters start at their null value."""
        values = rename_values(other.problem.coordinates.values(q), other.added, self.added)
        return transfer_values(other.problem, q, self.problem, values)

    def lay_out(self, plain: Problem, tables: Collection[str] = ()) -> AugmentedModel:
        """Return the model without places for other terms, whose steps take a quarter of the time.

        Parameters
        ----------
        plain : Problem
            Problem of the records with the mechanism as written.
        tables : collection of str
            Tables that it has in any case, in addition to those that per-record values need.
        """
        return self._lay_out_terms(plain, self.added.terms, tables)

    def _lay_out_terms(self, plain: Problem, terms: Sequence[str], tables: Collection[str] = ()) -> AugmentedModel:
        added = lay_out(self.base, terms, {*tables, *missing_tables(self.base.mechanism, self.disturbances)})
        added = replace(added, widths=rename_values(self.added.widths, self.added, added))
        problem = added.problem(plain, self.disturbances)
        return replace(self, problem=problem, added=added, superset=None)

    def lay_out_with(self, plain: Problem, terms: Sequence[str], tables: Collection[str] = ()) -> AugmentedModel:
        """Return the model with some more terms, each with its small prior, without places for other terms."""
        needed = {*tables, *missing_tables(self.base.mechanism, self.disturbances)}
        added = lay_out(self.base, (*self.added.terms, *terms), needed, small=True)
        own = {name: width for name, width in added.widths.items() if added.new[name] in terms}
        added = replace(added, widths={**rename_values(self.added.widths, self.added, added), **own})
        return replace(self, problem=added.problem(plain, self.disturbances), added=added, superset=None)

    def keep_effects(self, plain: Problem, names: Collection[str], name: str) -> AugmentedModel:
        """Return the model with only some of its effects, under another name."""
        some = tuple(one for one in self.disturbances if one.name in names)
        terms = [term for term in self.added.terms if term in names]
        if self.superset is None:
            return replace(self, name=name, disturbances=some)._lay_out_terms(plain, terms)
        return augment(plain, self.base, self.superset, terms, some, name)

    def needed_effects(self, q: FloatArray, windows: Windows) -> dict[str, float] | None:
        """Return the effects without which the cost rises by more than k ln N, each with that rise.

        All other parameters are free to compensate. Disturbances that consist of lines only are always included. None
        if the point cannot be simulated.

        Parameters
        ----------
        q : (n,)
            An optimum over the windows.
        windows : mapping of record to (first, stop)
        """
        triangle = self.problem.joint(q, windows)
        if not np.all(np.isfinite(triangle.jacobian)):
            return None
        groups = groups_of(self.problem, self.names_by_effect)
        samples = sum(stop - first for first, stop in windows.values())
        rises = needed_groups(triangle, distance_from_null(self.problem, q), groups, samples)
        return rises | {one.name: 0.0 for one in self.disturbances if not one.parameters}

    def widen_priors(self, plain: Problem, q: FloatArray, edge: float, factor: float) -> AugmentedModel:
        """Return the model with wider priors of effects at the edge of theirs; the model itself if there are none.

        Parameters
        ----------
        plain : Problem
            Problem of the records with the mechanism as written.
        q : (n,)
        edge : float
            Deviation from its prior, in standard deviations, at which a coordinate counts as at the edge.
        factor : float
            Factor by which its prior is widened.
        """
        coordinates = self.problem.coordinates
        widths = self.added.widths
        at_edge = {
            c.name
            for c, value in zip(coordinates.space.coordinates, coordinates.of_mechanism(q), strict=True)
            if c.name in widths and abs(value) > edge * widths[c.name]
        }
        others = widen_priors(self.disturbances, self.problem, q, edge, factor)
        if not at_edge and others is self.disturbances:
            return self
        wider = {name: width * (factor if name in at_edge else 1.0) for name, width in widths.items()}
        added = replace(self.added, widths=wider)
        return replace(self, added=added, disturbances=others, problem=added.problem(plain, others))


def augment(
    plain: Problem,
    base: AddedTerms,
    superset: Superset | None,
    terms: Sequence[str],
    disturbances: Sequence[Disturbance],
    name: str,
) -> AugmentedModel:
    """Return a model with some terms of a superset and some disturbances free.

    Parameters
    ----------
    plain : Problem
        Problem of the records with the mechanism as written.
    base : AddedTerms
        That mechanism, or the one with a law in place of its own.
    superset : Superset or None
        All terms that may be added; None for no terms.
    terms : sequence of str
        Names of the free terms.
    disturbances : sequence of Disturbance
    name : str
        Name of the model.
    """
    added = add_terms(superset, terms, base) if superset else base
    problem = added.problem(plain, disturbances)
    if superset:
        problem = share_kernel(problem, superset)
    return AugmentedModel(name, problem, added, tuple(disturbances), superset, base)
