"""Grade of a fit: outcome of the search, agreement between parts of the records, and reasons with the next step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from enum import Enum, StrEnum
from typing import Any, Self

from mechid.identification.result.settings import GRADE

UNEXAMINED = (
    "The run ended before this fit was examined: its records are not validated, its residuals were not searched for "
    "missing effects, and there is no report. mechid identify with --resume continues from here."
)
"""Warning of a fit whose search has ended, until all optional steps are done; its grade is that of the search."""


class FitOutcome(Enum):
    """Outcome of the search of a fit; the value is the sentence for the user. The grade judges the result."""

    CONVERGED = "The joint fit of all records has converged."
    STAGES_DONE = "The stages of the campaign file have been completed."
    EVENT_MISSED = (
        "The joint fit has converged, but for a moment it misses a record by more than its residual elsewhere: "
        "a stick-slip event there turns out differently than measured."
    )
    HORIZON = (
        "No start was found from which the model follows all records to their ends; the values come from the parts "
        "that it follows."
    )
    CLIFF = (
        "The joint fit stopped at a stick/slip threshold: beyond it a stick-slip event turns out differently, and the "
        "cost rises where the derivatives predict a fall."
    )
    NOT_CONVERGED = "The joint fit stopped at its limit of steps before it converged."
    FAILED = "No simulation from any start succeeded; the values are those of the mechanism file."
    INTERRUPTED = "Interrupted by the user; the values are the best found so far."

    @property
    def good(self) -> bool:
        """Whether the search reached its end."""
        return self in (FitOutcome.CONVERGED, FitOutcome.STAGES_DONE)

    @property
    def has_stopped_short(self) -> bool:
        """Whether the derivatives may still predict a step, which then counts in the errors."""
        return self in (FitOutcome.CLIFF, FitOutcome.NOT_CONVERGED)

    @property
    def has_optimum(self) -> bool:
        """Whether all records and parameters were fitted, up to an optimum or near it."""
        return self.good or self.has_stopped_short or self is FitOutcome.EVENT_MISSED

    @property
    def code(self) -> str:
        """Short name for programs."""
        return self.name.lower()


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """Scatter between the parts of one kind, relative to the scatter that noise alone explains.

    Attributes
    ----------
    ratio : float
        Scatter of the parts' scores over the scatter by noise; 1 without model error.
    z : float
        Excess of its square over the expectation, in standard deviations of chance.
    clusters : int
        Number of compared parts.
    by_ratio : float or None
        Limit of the ratio where the noise has no white model for a z score; None where it has one.
    """

    ratio: float
    z: float
    clusters: int
    by_ratio: float | None = None

    @property
    def agrees(self) -> bool:
        """Whether noise alone explains the scatter."""
        return self.z <= GRADE.consistency_z_limit if self.by_ratio is None else self.ratio < self.by_ratio


@dataclass(frozen=True, kw_only=True)
class Consistency:
    """Scatter between the phases of a step, between records and over time, each None where it was not tested.

    `parameter` and `contested_record` name the parameter and the record that disagree most; None where all agree.
    """

    phase: Scatter | None = None
    record: Scatter | None = None
    time: Scatter | None = None
    parameter: str | None = None
    contested_record: str | None = None

    @property
    def agrees(self) -> bool:
        """Whether noise alone explains the scatter of the records' parts.

        Stretches of time count only where there are neither phases nor several records: mains hum, which stays in phase
        over a stretch, scatters them without shifting any value.
        """
        tests = [test for test in (self.phase, self.record) if test is not None]
        if tests:
            return all(test.agrees for test in tests)
        return self.time is None or self.time.agrees

    def to_dict(self) -> dict[str, Any]:
        """Return the entry of estimate.json."""
        return asdict(self)

    @classmethod
    def from_dict(cls, entry: Mapping[str, Any]) -> Self:
        """Read an entry of estimate.json."""
        tests = {key: Scatter(**entry[key]) if entry[key] else None for key in ("phase", "record", "time")}
        return cls(parameter=entry["parameter"], contested_record=entry["contested_record"], **tests)


class Grade(StrEnum):
    """Usability of a fit; `GRADE_WORDS` describes each grade."""

    A = "A"
    B = "B"
    C = "C"
    FAILED = "failed"

    @property
    def good(self) -> bool:
        """Whether the values may be used with their standard errors."""
        return self in (Grade.A, Grade.B)


GRADE_WORDS: Mapping[Grade, str] = {
    Grade.A: "Grade A: the model follows all records, and their parts agree on the values.",
    Grade.B: "Grade B: the model follows all records, but not all of them is explained; its reasons say what is not.",
    Grade.C: "Grade C: use no value before its reasons are settled.",
    Grade.FAILED: "Failed: there is no estimate to use.",
}
"""A grade as its reader sees it, everywhere."""
NOTHING_EXPLAINS = "Grade C: nothing that was tried explains all records; use no value before its reasons are settled."


def grade_words(grade: Grade, outcome: FitOutcome) -> str:
    """Return a report's first line: the grade, and whether nothing explains all records."""
    return NOTHING_EXPLAINS if grade is Grade.C and outcome is FitOutcome.HORIZON else GRADE_WORDS[grade]


class Cause(StrEnum):
    """Why a fit has no better grade; `CAUSE_WORDS` say it."""

    NOT_SIMULATED = "not_simulated"
    INTERRUPTED = "interrupted"
    LEFT_OUT = "left_out"
    USED_IN_PART = "used_in_part"
    NOT_FOLLOWED = "not_followed"
    OUT_OF_STEP = "out_of_step"
    VALUE_CONTRADICTED = "value_contradicted"
    BOUND_CONTRADICTED = "bound_contradicted"
    PHYSICAL_LIMIT = "physical_limit"
    NOT_CONVERGED = "not_converged"
    INCOMPLETE = "incomplete"
    PARTS_DISAGREE = "parts_disagree"
    THRESHOLD = "threshold"
    NEAR_OPTIMUM = "near_optimum"
    EVENT_MISSED = "event_missed"
    UNEXPLAINED = "unexplained"
    MASKED = "masked"
    HELD_OUT = "held_out"
    HELD_OUT_LOST = "held_out_lost"

    @property
    def grade(self) -> Grade:
        """The best grade that the cause allows."""
        if self in (Cause.NOT_SIMULATED, Cause.INTERRUPTED):
            return Grade.FAILED
        return Grade.B if self in USABLE_CAUSES else Grade.C


USABLE_CAUSES = (
    Cause.INCOMPLETE,
    Cause.PHYSICAL_LIMIT,
    Cause.PARTS_DISAGREE,
    Cause.THRESHOLD,
    Cause.NEAR_OPTIMUM,
    Cause.EVENT_MISSED,
    Cause.MASKED,
    Cause.UNEXPLAINED,
    Cause.HELD_OUT,
)
"""Causes that leave the values usable."""
MECHANISM_FILE_CAUSES = (Cause.VALUE_CONTRADICTED, Cause.BOUND_CONTRADICTED)
"""Causes in the mechanism file, which mostly explain why records are not followed."""
CAUSE_WORDS: Mapping[Cause, str] = {
    Cause.NOT_SIMULATED: "no simulation",
    Cause.INTERRUPTED: "interrupted",
    Cause.LEFT_OUT: "record left out",
    Cause.USED_IN_PART: "followed in part",
    Cause.NOT_FOLLOWED: "not followed",
    Cause.OUT_OF_STEP: "out of step",
    Cause.HELD_OUT: "held-out record predicted badly",
    Cause.HELD_OUT_LOST: "held-out record not followed",
    Cause.VALUE_CONTRADICTED: "value contradicted",
    Cause.BOUND_CONTRADICTED: "bound contradicted",
    Cause.PHYSICAL_LIMIT: "at a limit of physics",
    Cause.NOT_CONVERGED: "not converged",
    Cause.INCOMPLETE: "mechanism incomplete",
    Cause.PARTS_DISAGREE: "model error",
    Cause.THRESHOLD: "stick/slip threshold",
    Cause.NEAR_OPTIMUM: "stopped near the optimum",
    Cause.EVENT_MISSED: "stick/slip missed",
    Cause.MASKED: "moment left out",
    Cause.UNEXPLAINED: "residual unexplained",
}
"""A cause in two or three words; docs/glossary.md explains each."""


@dataclass(frozen=True, kw_only=True)
class Reason:
    """One reason why a fit has no better grade.

    Attributes
    ----------
    cause : Cause
    text : str
        The finding and its place, as a sentence.
    record, parameter : str or None
        The record and the parameter concerned; where parts disagree, those that disagree most.
    instant_s : float or None
        Record time at which the problem begins.
    next_command : str
        The next command to type.
    widened_most, widened_median : float or None
        Ratio of the standard error to that of noise alone, largest and median over the parameters.
    """

    cause: Cause
    text: str
    record: str | None = None
    parameter: str | None = None
    instant_s: float | None = None
    next_command: str = ""
    widened_most: float | None = None
    widened_median: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the entry of estimate.json."""
        return {**asdict(self), "cause": str(self.cause)}

    @classmethod
    def from_dict(cls, entry: Mapping[str, Any]) -> Self:
        """Read an entry of estimate.json."""
        return cls(**{**entry, "cause": Cause(entry["cause"])})


def grade_of(reasons: tuple[Reason, ...]) -> Grade:
    """Return the worst grade of some reasons, A without any.

    Examples
    --------
    >>> str(grade_of(())), str(grade_of((Reason(cause=Cause.THRESHOLD, text=""),)))
    ('A', 'B')
    """
    # Grades are declared from best to worst.
    order = list(Grade)
    return max((reason.cause.grade for reason in reasons), key=order.index, default=Grade.A)
