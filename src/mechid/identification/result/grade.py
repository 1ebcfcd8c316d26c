"""Grade of a fit, and the reasons for it, each with the next step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any, Self


class Grade(StrEnum):
    """What a fit is worth; `GRADE_WORDS` say it."""

    A = "A"
    B = "B"
    C = "C"
    FAILED = "failed"

    @property
    def good(self) -> bool:
        """Whether the values may be used with their error bars."""
        return self in (Grade.A, Grade.B)


GRADE_WORDS: Mapping[Grade, str] = {
    Grade.A: "Grade A: the model follows all records, and their parts agree on the values.",
    Grade.B: "Grade B: the model follows all records, but not all of them is explained; its reasons say what is not.",
    Grade.C: "Grade C: use no value before its reasons are settled.",
    Grade.FAILED: "Failed: there is no estimate to use.",
}
"""A grade as its reader sees it, everywhere."""


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
    HELD_OUT = "held_out"
    HELD_OUT_LOST = "held_out_lost"

    @property
    def grade(self) -> Grade:
        """The best grade that it allows."""
        if self in (Cause.NOT_SIMULATED, Cause.INTERRUPTED):
            return Grade.FAILED
        return Grade.B if self in OF_USE else Grade.C


OF_USE = (
    Cause.INCOMPLETE,
    Cause.PHYSICAL_LIMIT,
    Cause.PARTS_DISAGREE,
    Cause.THRESHOLD,
    Cause.NEAR_OPTIMUM,
    Cause.EVENT_MISSED,
    Cause.UNEXPLAINED,
    Cause.HELD_OUT,
)
"""Causes that leave the values of use."""
OF_MECHANISM_FILE = (Cause.VALUE_CONTRADICTED, Cause.BOUND_CONTRADICTED)
"""Causes that stand in the mechanism file, and are mostly why records are not followed."""
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
        What was found, where, as a sentence.
    record, parameter : str or None
        Whom it concerns; of parts that disagree what is contested most.
    instant_s : float or None
        Record time at which it begins.
    next_command : str
        What to do next, as typed.
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
        """Return what an entry of estimate.json says."""
        return cls(**{**entry, "cause": Cause(entry["cause"])})


def grade_of(reasons: tuple[Reason, ...]) -> Grade:
    """Return the grade that some reasons leave, A without any.

    Examples
    --------
    >>> str(grade_of(())), str(grade_of((Reason(cause=Cause.THRESHOLD, text=""),)))
    ('A', 'B')
    """
    order = list(Grade)
    return max((reason.cause.grade for reason in reasons), key=order.index, default=Grade.A)
