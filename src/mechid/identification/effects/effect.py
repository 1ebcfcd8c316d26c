"""Terms and laws added to a mechanism: the problem in which they are free, and their distance from the null value."""

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
class AddedTerms:
    """A mechanism with terms or a law that the one as written does not have.

    Attributes
    ----------
    mechanism : Mechanism
        With the terms free, or with the law.
    widths : mapping of str to float
        Standard deviations of their small priors, by dotted name; those of a law that has no null have none.
    new : mapping of str to str
        Dotted names of the free parameters that the mechanism as written does not have, each with the name of its term.
    is_law : bool
        Whether it is a law in place of another one; a law has no null value.
    aliases : mapping of str to tuple of str
        Names of the terms that explain as much in place of an added one, by the name of that one.
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

    @property
    def names_by_term(self) -> dict[str, tuple[str, ...]]:
        """Dotted names of the free parameters of each term."""
        return {term: tuple(name for name, of in self.new.items() if of == term) for term in self.terms}

    def problem(self, plain: Problem, disturbances: Sequence[Disturbance] = ()) -> Problem:
        """Return the problem of the same records with the terms free, and with some disturbances of the records."""
        wider = replace(plain, space=SearchSpace(self.mechanism, plain.space.polar), shrinkage=self.widths)
        return with_disturbances(wider, disturbances)


def add_terms(superset: Superset, names: Collection[str]) -> AddedTerms:
    """Return a mechanism with some terms of its superset free."""
    new = {name: term for name, term in superset.term_of.items() if term in names}
    widths = {name: width for term in superset.terms if term.name in names for name, width in term.widths.items()}
    return AddedTerms(superset.freeing(names), widths, new)


def substitute_law(plain: Mechanism, law: Law) -> AddedTerms:
    """Return a mechanism with a law in place of its own one."""
    new = {p.name: law.name for p in law.mechanism.free if p.name not in plain.parameters}
    return AddedTerms(law.mechanism, new=new, is_law=True)


def distance_from_null(problem: Problem, q: FloatArray) -> FloatArray:
    """Return how far each coordinate of an effect is from its null value, (n,).

    That of a term is 0; that of a record's own parameter the mechanism's value where it replaces one, else the value
    that the record was declared with.
    """
    values = problem.space.values(problem.coordinates.of_mechanism(q))
    nulls = [values.get(c.parameter.replaces, c.parameter.value) for c in problem.coordinates.own]
    return np.concatenate([problem.coordinates.of_mechanism(q), problem.coordinates.of_records(q) - nulls])
