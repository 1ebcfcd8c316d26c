"""What speaks for the effects that a diagnosis names: the Bayesian criterion, and records that were held out."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mechid.analysis.preference import LEVELS, ComparisonOutcome
from mechid.identification.diagnosis.diagnosis import Diagnosis
from mechid.identification.diagnosis.held_out import HeldOut
from mechid.reports.digits import digits

TELLING = 0.01
"""Relative difference of two residuals from which one predicts better."""


def evidence_lines(found: Diagnosis) -> list[str]:
    """Return the verdict on the effects that are named, in the words of `mechid compare`, a line each."""
    if found.mechanism is None or not found.steps:
        return []
    fall = found.as_written.bic - found.steps[-1].bic
    level = next(word for limit, word in LEVELS if fall < limit or math.isinf(limit))
    by = (
        f"The Bayesian criterion prefers the mechanism with these effects {level}, by {digits(fall, 4)}: samples count "
    )
    lines = [f"{by}for what the residual's colour leaves of them, and each free number costs the logarithm of theirs."]
    lines += [
        f"Record {one.record}, held out: the residual is {digits(one.before, 4)} times its noise as written, "
        f"{digits(one.after, 4)} times with the effects."
        for one in found.held_out
    ]
    return [*lines, _outcome(found.held_out).value]


def _outcome(held_out: Sequence[HeldOut]) -> ComparisonOutcome:
    """Return how the prediction of records that were held out goes with the criterion."""
    if not held_out:
        return ComparisonOutcome.UNTESTED
    before, after = (math.hypot(*values) for values in zip(*((h.before, h.after) for h in held_out), strict=True))
    if not after < math.inf or after > (1.0 + TELLING) * before:
        return ComparisonOutcome.DISPUTED
    return ComparisonOutcome.AGREED if after < (1.0 - TELLING) * before else ComparisonOutcome.UNDECIDED_BY_PREDICTION
