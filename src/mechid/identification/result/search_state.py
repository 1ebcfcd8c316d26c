"""State of a search: the start of its next step and the basis of its conclusion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Self

from mechid.arrays import FloatArray
from mechid.identification.effects.disturbance import FoundDisturbance
from mechid.identification.effects.effect import AddedTerms
from mechid.identification.output_error.declaration import Reading
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.result.fit import StageReport
from mechid.identification.result.grade import FitOutcome
from mechid.identification.search.solve import Solution


@dataclass(frozen=True)
class HeldParameter:
    """A parameter held for a dependence: its value, the value's sigma if known, and the reason."""

    name: str
    value: float
    sigma: float | None
    reason: str


@dataclass(frozen=True, eq=False)
class SearchState:
    """State of a search; each step takes a state and returns the next one.

    Attributes
    ----------
    problem : Problem
        Weights, records and free parameters of the current step.
    q : (n,)
        Best point of that step so far.
    windows : mapping of record to (first, stop)
        Samples of the records that count.
    outcome : FitOutcome
        Outcome of the fit if the search ended now.
    readings : mapping of record to Reading
        Reinterpretation of each record that is read otherwise than declared.
    stages : tuple of StageReport
        Finished stages.
    warnings : tuple of str
    frozen : tuple of HeldParameter
        Held parameters, in the order in which they were held.
    solution : Solution or None
        Solution of the last joint fit.
    searched : bool
        Whether the search reached its end, so that only the conclusion is left.
    before_raised : mapping of record to str
        Description of how far each record was followed before its noise level was raised; empty where none was raised.
    found : tuple of FoundDisturbance
        Disturbances that were added to the problem because the data support them.
    added : AddedTerms or None
        Terms added to the mechanism as written, because that alone does not follow the records.
    path : tuple of str
        Names of the strategies that the search tried, in order; the last one reached the records' ends.
    contradicted : mapping of dotted name to str
        Values of the mechanism file with which no start explains the records; a sentence gives a value that does.
    """

    problem: Problem
    q: FloatArray
    windows: Windows
    outcome: FitOutcome = FitOutcome.FAILED
    readings: Mapping[str, Reading] = field(default_factory=dict)
    stages: tuple[StageReport, ...] = ()
    warnings: tuple[str, ...] = ()
    frozen: tuple[HeldParameter, ...] = ()
    solution: Solution | None = None
    searched: bool = False
    before_raised: Mapping[str, str] = field(default_factory=dict)
    found: tuple[FoundDisturbance, ...] = ()
    added: AddedTerms | None = None
    path: tuple[str, ...] = ()
    contradicted: Mapping[str, str] = field(default_factory=dict)

    def at(self, q: FloatArray, gates: Mapping[str, int] | None = None) -> Self:
        """Return the state at a better point, and with new windows if `gates` gives the samples that it follows."""
        windows = self.windows if gates is None else {name: (0, n) for name, n in gates.items()}
        return replace(self, q=q, windows=windows)

    def with_problem(self, problem: Problem) -> Self:
        """Return the state with another problem; if that has other coordinates, set its point by `at`."""
        return replace(self, problem=problem)

    def with_outcome(self, outcome: FitOutcome) -> Self:
        """Return the state with another outcome."""
        return replace(self, outcome=outcome)

    def with_warnings(self, *warnings: str) -> Self:
        """Return the state with further warnings."""
        return replace(self, warnings=(*self.warnings, *warnings))

    @property
    def values(self) -> dict[str, float]:
        """Values of the free parameters by name, in the file's units."""
        return self.problem.coordinates.values(self.q)

    @property
    def has_converged(self) -> bool:
        """Whether the last joint fit has converged."""
        return self.solution is not None and self.solution.converged
