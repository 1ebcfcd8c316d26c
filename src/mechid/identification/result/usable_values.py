"""Values of a finished fit that are carried on: refusal of a failed fit, covariance by the standard errors."""

from __future__ import annotations

import numpy as np

from mechid.arrays import FloatArray
from mechid.errors import MechidError
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import GRADE_WORDS, Grade


def refuse_failed(fit: Fit, error: type[MechidError], remedy: str = "Identify anew") -> None:
    """Raise an error where a fit has failed: it has no values to carry on."""
    if fit.grade is Grade.FAILED:
        raise error(f"{fit.source}: {GRADE_WORDS[fit.grade]} {fit.outcome.value} {remedy}")


def error_covariance(fit: Fit) -> tuple[tuple[str, ...], FloatArray]:
    """Return the parameters that have a standard error, and their covariance in the file's units.

    It is the correlation times the standard errors, so it holds where the model lacks something too, as they do.
    `Fit.covariance` is of noise alone.
    """
    errors = np.array([fit.parameters[name].std_error for name in fit.correlation_names], dtype=np.float64)
    known = np.flatnonzero(np.isfinite(errors) & np.isfinite(np.diag(fit.correlation)))
    covariance = fit.correlation * np.outer(errors, errors)
    return tuple(fit.correlation_names[k] for k in known), covariance[np.ix_(known, known)]
