"""A mechanism with terms beside it, and the problem of its records: what is free, and how small it is wanted."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.effects.disturbance import Disturbance, with_disturbances
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.plant.mechanism import Mechanism
from mechid.plant.superset import Law, Superset


@dataclass(frozen=True)
class Beside:
    """What a fit has beside the mechanism as written.

    Attributes
    ----------
    mechanism : Mechanism
        With the terms free.
    widths : mapping of str to float
        Standard deviations of their small priors, by dotted name; those of a law that has no null have none.
    new : mapping of str to str
        Free parameters that the mechanism as written has not, by dotted name, each with the term that it is of.
    is_law : bool
        Whether it is a law in place of another, which no null value leads to.
    aliases : mapping of str to tuple of str
        Terms that explain as much in place of one that is here, by its name.
    """

    mechanism: Mechanism
    widths: Mapping[str, float] = field(default_factory=dict)
    new: Mapping[str, str] = field(default_factory=dict)
    is_law: bool = False
    aliases: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def terms(self) -> tuple[str, ...]:
        """Names of the terms, as diagnosis calls them."""
        return tuple(dict.fromkeys(self.new.values()))

    def problem(self, plain: Problem, disturbances: Sequence[Disturbance] = ()) -> Problem:
        """Return the problem of the same records with the terms free, and with some disturbances of the records."""
        wider = replace(plain, space=SearchSpace(self.mechanism, plain.space.polar), shrinkage=self.widths)
        return with_disturbances(wider, disturbances)


def terms_beside(superset: Superset, names: Collection[str]) -> Beside:
    """Return what stands beside a mechanism where some terms of its superset are free."""
    new = {name: term for name, term in superset.term_of.items() if term in names}
    return Beside(superset.freeing(names), superset.widths, new)


def law_beside(plain: Mechanism, law: Law) -> Beside:
    """Return what stands beside a mechanism where a law is in place of what it has."""
    new = {p.name: law.name for p in law.mechanism.free if p.name not in plain.parameters}
    return Beside(law.mechanism, new=new, is_law=True)


def lifted(plain: Problem, q: FloatArray, other: Problem) -> FloatArray:
    """Return a point of a problem in one of the same records whose mechanism and records have more that is free.

    What is new begins at its start: the null of a term, and the mechanism's value where a record has one of its own.
    """
    values = plain.space.values(plain.coordinates.of_mechanism(q))
    owned = {
        c.parameter.name: values[c.parameter.replaces] for c in other.coordinates.own if c.parameter.replaces in values
    }
    return other.coordinates.point({**owned, **plain.coordinates.values(q)})


def distance_from_null(problem: Problem, q: FloatArray) -> FloatArray:
    """Return how far each coordinate of an effect is from its null value, (n,).

    That of a term is 0; that of a record's own parameter the mechanism's value where it replaces one, else the value
    that the record was declared with.
    """
    values = problem.space.values(problem.coordinates.of_mechanism(q))
    nulls = [values.get(c.parameter.replaces, c.parameter.value) for c in problem.coordinates.own]
    return np.concatenate([problem.coordinates.of_mechanism(q), problem.coordinates.of_records(q) - nulls])
