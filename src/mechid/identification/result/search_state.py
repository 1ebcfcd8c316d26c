"""Where a search stands: what its next step begins from, and what its conclusion is drawn from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Self

from mechid.arrays import FloatArray
from mechid.identification.effects.disturbance import Found
from mechid.identification.effects.effect import AddedTerms
from mechid.identification.output_error.declaration import Reading
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.result.fit import StageReport
from mechid.identification.result.grade import FitOutcome
from mechid.identification.search.solve import Solution


@dataclass(frozen=True)
class Frozen:
    """A parameter held for a dependence: at which value, how well that is known, and why."""

    name: str
    value: float
    sigma: float | None
    reason: str


@dataclass(frozen=True, eq=False)
class SearchState:
    """Where a search stands; each of its steps takes one and returns the next.

    Attributes
    ----------
    problem : Problem
        With the weights, the records and the free parameters of the step at work.
    q : (n,)
        The best point of it so far.
    windows : mapping of record to (first, stop)
        What of the records counts.
    outcome : FitOutcome
        How the fit would end if nothing came after.
    taken : mapping of record to Reading
        Records that are taken otherwise than declared.
    stages : tuple of StageReport
        Those finished.
    warnings : tuple of str
    frozen : tuple of Frozen
        Parameters held, in the order in which they were.
    solution : Solution or None
        Of the last joint fit.
    searched : bool
        Whether the search came to its end, so that only the conclusion is left.
    before_raised : mapping of record to str
        How far it was followed before any noise level was raised, in words; empty where none was.
    found : tuple of Found
        Disturbances that the problem has because its records ask for them.
    added : AddedTerms or None
        Terms that the problem's mechanism has beside the one written, because that does not follow the records alone.
    path : tuple of str
        Names of the ways by which the search has tried to come to the records' ends, in order; the last one led.
    contradicted : mapping of dotted name to str
        Values of the mechanism file with which no start explains the records, and with which one does, in a sentence.
    """

    problem: Problem
    q: FloatArray
    windows: Windows
    outcome: FitOutcome = FitOutcome.FAILED
    taken: Mapping[str, Reading] = field(default_factory=dict)
    stages: tuple[StageReport, ...] = ()
    warnings: tuple[str, ...] = ()
    frozen: tuple[Frozen, ...] = ()
    solution: Solution | None = None
    searched: bool = False
    before_raised: Mapping[str, str] = field(default_factory=dict)
    found: tuple[Found, ...] = ()
    added: AddedTerms | None = None
    path: tuple[str, ...] = ()
    contradicted: Mapping[str, str] = field(default_factory=dict)

    def at(self, q: FloatArray, gates: Mapping[str, int] | None = None) -> Self:
        """Return it at a better point; with how far that follows the records where this is what makes it better."""
        windows = self.windows if gates is None else {name: (0, n) for name, n in gates.items()}
        return replace(self, q=q, windows=windows)

    def of(self, problem: Problem) -> Self:
        """Return it with another problem; where that has other coordinates, its point is to be set by `at`."""
        return replace(self, problem=problem)

    def ending(self, outcome: FitOutcome) -> Self:
        """Return it with another outcome."""
        return replace(self, outcome=outcome)

    def saying(self, *warnings: str) -> Self:
        """Return it with further warnings."""
        return replace(self, warnings=(*self.warnings, *warnings))

    @property
    def values(self) -> dict[str, float]:
        """The file's values of all that is free, by name."""
        return self.problem.coordinates.values(self.q)

    @property
    def converged(self) -> bool:
        """Whether the last joint fit has."""
        return self.solution is not None and self.solution.converged
