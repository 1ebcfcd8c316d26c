"""Terms and laws added to a mechanism: the problem in which they are free, and their distance from the null value."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.effects.disturbance import Disturbance, with_disturbances
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.plant.law import Law
from mechid.plant.mechanism import Mechanism
from mechid.plant.superset import Superset, superset_of, unlisted_extensions, with_tables


@dataclass(frozen=True)
class AddedTerms:
    """Mechanism with terms or a law that the mechanism as written does not have.

    Attributes
    ----------
    mechanism : Mechanism
        With the terms free, and with the law.
    widths : mapping of str to float
        Standard deviations of the terms' small priors, by dotted name; a law has no null value and no such prior.
    new : mapping of str to str
        Term or law of each additional free parameter, by the parameter's dotted name.
    law : str
        Name of the law that replaces another one; empty if there is none. It has no null value.
    aliases : mapping of str to tuple of str
        Names of the terms that explain as much in place of an added one, by the name of that one.
    """

    mechanism: Mechanism
    widths: Mapping[str, float] = field(default_factory=dict)
    new: Mapping[str, str] = field(default_factory=dict)
    law: str = ""
    aliases: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of its terms and its law, as in a diagnosis."""
        return tuple(dict.fromkeys(self.new.values()))

    @property
    def terms(self) -> tuple[str, ...]:
        """Names of its terms, which have a null value."""
        return tuple(name for name in self.names if name != self.law)

    @property
    def names_by_term(self) -> dict[str, tuple[str, ...]]:
        """Dotted names of the free parameters of each term."""
        return {term: self.parameters_of(term) for term in self.terms}

    def parameters_of(self, name: str) -> tuple[str, ...]:
        """Return the dotted names of the free parameters of a term or a law."""
        return tuple(parameter for parameter, of in self.new.items() if of == name)

    def problem(self, plain: Problem, disturbances: Sequence[Disturbance] = ()) -> Problem:
        """Return the problem of the same records with the terms free, and with some disturbances."""
        wider = replace(plain, space=SearchSpace(self.mechanism, plain.space.polar), shrinkage=self.widths)
        return with_disturbances(wider, disturbances)


def add_terms(superset: Superset, names: Collection[str], base: AddedTerms | None = None) -> AddedTerms:
    """Return a mechanism with some terms of its superset free, in addition to those of `base`, such as a law."""
    before = base or AddedTerms(superset.mechanism)
    new = {name: term for name, term in superset.term_of.items() if term in names}
    widths = {name: width for term in superset.terms if term.name in names for name, width in term.widths.items()}
    return AddedTerms(superset.with_free_terms(names), widths, {**before.new, **new}, before.law)


def share_kernel(problem: Problem, superset: Superset) -> Problem:
    """Return a problem with some terms of a superset free, on the one kernel that serves any choice of them."""
    # Unused lanes take no time; a kernel with fewer would take ten seconds to compile.
    return replace(problem, capacity=len(superset.mechanism.plant.parameters))


def substitute_law(plain: Mechanism, law: Law) -> AddedTerms:
    """Return a mechanism with a law in place of its own one."""
    new = {p.name: law.name for p in law.mechanism.free if p.name not in plain.parameters}
    return AddedTerms(law.mechanism, new=new, law=law.name)


def lay_out(
    base: AddedTerms, names: Collection[str], tables: Collection[str] = (), *, small: bool = False
) -> AddedTerms:
    """Return a mechanism with some terms as a file would declare them, without places for other terms.

    Parameters
    ----------
    base : AddedTerms
        Mechanism without terms: as written, or with a law.
    names : collection of str
        Names of terms.
    tables : collection of str
        Optional tables that it has in any case, with their defaults.
    small : bool
        Whether the terms have small priors, as those of a superset.
    """
    mechanism = with_tables(base.mechanism, tables)
    base = replace(base, mechanism=mechanism)
    if not names:
        return base
    unlisted = unlisted_extensions(mechanism)
    # Sets have no fixed order, but the order of terms is part of the plant and of its kernel.
    further = [unlisted[name] for name in sorted(unlisted.keys() & set(names))]
    superset = superset_of(mechanism, only=names, further=further)
    if superset is None:
        return base
    added = add_terms(superset, names, base)
    return added if small else replace(added, widths={})


def rename_values(values: Mapping[str, float], of: AddedTerms, other: AddedTerms) -> dict[str, float]:
    """Return values with the parameter names of another mechanism; terms that it lacks are left out.

    The index of a list entry depends on the other terms in the list.
    """
    here, there = other.names_by_term, of.names_by_term
    common = here.keys() & there.keys()
    moved = {old: new for term in common for old, new in zip(there[term], here[term], strict=True)}
    lost = {name for name, term in of.new.items() if term not in common and term != of.law}
    return {moved.get(name, name): value for name, value in values.items() if name not in lost}


def distance_from_null(problem: Problem, q: FloatArray) -> FloatArray:
    """Return the distance of each coordinate of an effect from its null value, (n,).

    The null value of a term is 0. That of a record parameter is the mechanism's value if it replaces one, otherwise the
    declared value of the record.
    """
    values = problem.space.values(problem.coordinates.of_mechanism(q))
    nulls = [values.get(c.parameter.replaces, c.parameter.value) for c in problem.coordinates.own]
    return np.concatenate([problem.coordinates.of_mechanism(q), problem.coordinates.of_records(q) - nulls])
