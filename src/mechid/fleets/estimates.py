"""Estimates of each parameter in a fleet: values with usable errors, and reasons for excluding others."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from scipy.special import ndtri, stdtrit

from mechid.analysis.fit_residuals import is_simulated
from mechid.analysis.hypothesis import key_by_period_or_order
from mechid.campaign.campaign import CAMPAIGN
from mechid.fleets.angles import UNKNOWN_DEG
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import GRADE_WORDS, Grade
from mechid.identification.result.parameter_estimate import ParameterEstimate
from mechid.parameter import Status

DEGREES = "deg"
OF_THE_BENCH = ("record", CAMPAIGN)
"""First words of parameters that belong to a record or the recorder instead of the unit."""
STATUS_WORDS: Mapping[str, str] = {
    Status.KNOWN: "known",
    Status.TIED: "tied",
    Status.FROZEN: "frozen",
    Status.AT_BOUND: "at bound",
}


@dataclass(frozen=True, kw_only=True)
class Value:
    """Parameter value of one campaign, in the file's unit.

    Attributes
    ----------
    value : float
    std_error : float or None
    error : float
        Standard deviation of a normal distribution with the same 95 % interval; above `std_error` if that has few
        degrees of freedom. NaN without a standard error.
    status : str
    left_out : str
        Why it is not counted; empty if it is.
    near_threshold : bool
        Whether its error is valid on one side of a stick-slip threshold only.
    """

    value: float
    std_error: float | None
    error: float
    unit: str
    status: str
    left_out: str
    near_threshold: bool

    @property
    def counts(self) -> bool:
        """Whether it is an estimate with an error, from a fit with usable values."""
        return not self.left_out


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """A finished fit as a fleet uses it.

    Attributes
    ----------
    grade : Grade
    said : str
        First reason for a grade below A; empty for A.
    values : mapping of str to Value
        By name; entries of a list are identified by their period or order instead of their number.
    plant : str
        Digest of the equations.
    version : str
        Version of mechid.
    synthetic : bool
        Whether its report states that the records were simulated.
    """

    grade: Grade
    said: str
    values: Mapping[str, Value]
    plant: str
    version: str
    synthetic: bool = False


def estimate_of(fit: Fit) -> Estimate:
    """Return the parts of a campaign's finished fit that a fleet uses."""
    # Numbers of list entries depend on the order in each file; periods and orders do not.
    named = key_by_period_or_order(fit.parameters)
    versions = fit.provenance.get("versions")
    return Estimate(
        grade=fit.grade,
        said=fit.reasons[0].text if fit.reasons else "" if fit.grade.good else GRADE_WORDS[fit.grade],
        values={n: _value(p, fit.grade) for n, p in named.items() if n.partition(".")[0] not in OF_THE_BENCH},
        plant=str(fit.provenance.get("plant", "")),
        version=str(versions.get("mechid", "")) if isinstance(versions, Mapping) else "",
        synthetic=is_simulated(fit),
    )


def _value(p: ParameterEstimate, grade: Grade) -> Value:
    error = math.nan if p.std_error is None else p.std_error * _interval_factor(p.dof)
    return Value(
        value=p.value,
        std_error=p.std_error,
        error=error,
        unit=p.unit,
        status=p.status,
        left_out=_exclusion_reason(p, error, grade),
        near_threshold=p.local_only,
    )


def _exclusion_reason(p: ParameterEstimate, error: float, grade: Grade) -> str:
    """Return why a value is not counted, empty if it is."""
    if p.status != Status.FREE:
        return STATUS_WORDS.get(p.status, p.status)
    if not grade.good:
        return "failed" if grade is Grade.FAILED else f"grade {grade}"
    if not (math.isfinite(error) and error > 0.0):
        return "no error"
    return "angle not known" if p.unit == DEGREES and error >= UNKNOWN_DEG else ""


def _interval_factor(dof: float | None) -> float:
    """Return the ratio of the 95 % interval of Student's t to that of the normal distribution."""
    return 1.0 if dof is None else float(stdtrit(dof, 0.975) / ndtri(0.975))


def is_of_interest(estimates: Sequence[Estimate], name: str) -> bool:
    """Return whether any campaign estimated or held a parameter, or its known value differs between campaigns."""
    # A tied parameter follows its master and would repeat the master's findings.
    values = [v for e in estimates if (v := e.values.get(name)) is not None and v.status != Status.TIED]
    return any(v.status != Status.KNOWN for v in values) or len({v.value for v in values}) > 1
