"""Optimum of a finished fit: the problem that was solved, its point, and the parameters that moved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from mechid.arrays import FloatArray
from mechid.errors import UsageError, did_you_mean
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import Triangle
from mechid.identification.result.parameter_estimate import ParameterEstimate
from mechid.parameter import Status

MOVED = (Status.FREE, Status.AT_BOUND)


@dataclass(frozen=True, eq=False)
class Optimum:
    """The optimum of a fit.

    Attributes
    ----------
    problem : Problem
        Its free parameters are those that the fit moved; the records have the weights of the last fit.
    q : (n,)
    windows : mapping of str to (int, int)
    triangle : Triangle
        At `q`.
    parameters : mapping of str to ParameterEstimate
        Those of the fit.
    """

    problem: Problem
    q: FloatArray
    windows: Windows
    triangle: Triangle
    parameters: Mapping[str, ParameterEstimate]

    @property
    def moved(self) -> tuple[str, ...]:
        """Names of the parameters that the fit moved."""
        return tuple(name for name, p in self.parameters.items() if p.status in MOVED)

    def one(self, name: str) -> ParameterEstimate:
        """Return the estimate of a parameter; UsageError where the fit did not move it."""
        if name not in self.moved:
            known = self.parameters.get(name)
            state = f"is {known.status}" if known else f"is not in the fit{did_you_mean(name, self.moved)}"
            raise UsageError(f"--parameter {name}: {state}; the fit moved {', '.join(self.moved)}")
        return self.parameters[name]

    def values(self, q: FloatArray) -> dict[str, float]:
        """Return the file's values of the parameters that the fit moved, at a point."""
        return self.problem.coordinates.values(q)
