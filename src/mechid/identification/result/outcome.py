"""Outcome of the search of a fit."""

from __future__ import annotations

from enum import Enum

UNEXAMINED = (
    "The run was ended before this fit was examined: its records are not validated, what is left of them was not asked "
    "for missing effects, and there is no report. mechid identify with --resume goes on from here."
)
"""Warning of a fit whose search has ended, until all that is optional has been done; its grade is the search's."""


class FitOutcome(Enum):
    """How the search of a fit ended; the value is the sentence its reader sees. What it is worth is its grade."""

    CONVERGED = "The joint fit of all records has converged."
    STAGES_DONE = "The stages of the campaign file have been worked through."
    EVENT_MISSED = (
        "The joint fit has converged, but for a moment it leaves a record by more than its residual elsewhere: "
        "a stick/slip falls the other way there."
    )
    HORIZON = (
        "No start was found from which the model follows all records to their ends; the values come from the parts "
        "that it follows."
    )
    CLIFF = (
        "The joint fit stopped at a stick/slip threshold: beyond it a stick/slip falls the other way, and the cost "
        "rises where it should still fall."
    )
    NOT_CONVERGED = "The joint fit stopped at its limit of steps before it converged."
    FAILED = "No simulation from any start succeeded; the values are those of the mechanism file."
    INTERRUPTED = "Interrupted by the user; the values are the best found so far."

    @property
    def good(self) -> bool:
        """Whether the search came to its end."""
        return self in (FitOutcome.CONVERGED, FitOutcome.STAGES_DONE)

    @property
    def stopped_short(self) -> bool:
        """Whether the derivatives may still promise a step, which counts in the errors."""
        return self in (FitOutcome.CLIFF, FitOutcome.NOT_CONVERGED)

    @property
    def has_optimum(self) -> bool:
        """Whether all that was to be fitted was, up to an optimum or near it."""
        return self.good or self.stopped_short or self is FitOutcome.EVENT_MISSED

    @property
    def code(self) -> str:
        """Short name for programs."""
        return self.name.lower()
