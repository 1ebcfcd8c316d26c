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
from mechid.plant.superset import Law, Superset, rivals_of, superset_of


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
    """

    mechanism: Mechanism
    widths: Mapping[str, float] = field(default_factory=dict)
    new: Mapping[str, str] = field(default_factory=dict)

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
    return Beside(law.mechanism, {}, {p.name: law.name for p in law.mechanism.free if p.name not in plain.parameters})


def beside_again(plain: Mechanism, names: Sequence[str], widths: Mapping[str, float | None]) -> Beside:
    """Return what stood beside a mechanism in an earlier fit.

    Parameters
    ----------
    plain : Mechanism
        As written.
    names : sequence of str
        Of the terms, or of the one law.
    widths : mapping of str to (float or None)
        Of the small priors as the fit ended with them, by dotted name of all that was free; None: there was none.
    """
    known = {name: width for name, width in widths.items() if width is not None}
    superset = superset_of(plain, grown_only=True)
    if known and superset is not None:
        return replace(terms_beside(superset, names), widths=known)
    return next(law_beside(plain, law) for law in rivals_of(plain) if law.name in names)


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
