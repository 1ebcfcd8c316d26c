"""Estimates of each parameter in a fleet: values with usable errors, and why others have none."""

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
"""First words of parameters that are of a record or of the recorder, not of the unit."""
STATUS_WORDS: Mapping[str, str] = {
    Status.KNOWN: "known",
    Status.TIED: "tied",
    Status.FROZEN: "frozen",
    Status.AT_BOUND: "at bound",
}


@dataclass(frozen=True, kw_only=True)
class Value:
    """A parameter as one campaign has it, in the file's unit.

    Attributes
    ----------
    value : float
    std_error : float or None
    error : float
        Standard deviation of a normal distribution with the same 95 % interval; above `std_error` where that rests on
        few degrees of freedom. NaN where there is none.
    status : str
    left_out : str
        Why it does not count; empty where it does.
    near_threshold : bool
        Its error holds on one side of a stick/slip threshold only.
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
        """Whether it is an estimate with an error, of a fit whose values may be used."""
        return not self.left_out


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """A finished fit of a fleet.

    Attributes
    ----------
    grade : Grade
    said : str
        The first reason for a grade below A; empty of A.
    values : mapping of str to Value
        By names that tell the entry of a list by its period or order, not by its number.
    plant : str
        Digest of the equations.
    version : str
        Of mechid.
    synthetic : bool
        Whether its report says that the records were simulated.
    """

    grade: Grade
    said: str
    values: Mapping[str, Value]
    plant: str
    version: str
    synthetic: bool = False


def estimate_of(fit: Fit) -> Estimate:
    """Return what a fleet takes of the finished fit of a campaign."""
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
    error = math.nan if p.std_error is None else p.std_error * _widening(p.dof)
    return Value(
        value=p.value,
        std_error=p.std_error,
        error=error,
        unit=p.unit,
        status=p.status,
        left_out=_left_out(p, error, grade),
        near_threshold=p.local_only,
    )


def _left_out(p: ParameterEstimate, error: float, grade: Grade) -> str:
    """Return why a value is not counted, empty where it is."""
    if p.status != Status.FREE:
        return STATUS_WORDS.get(p.status, p.status)
    if not grade.good:
        return "failed" if grade is Grade.FAILED else f"grade {grade}"
    if not (math.isfinite(error) and error > 0.0):
        return "no error"
    return "angle not known" if p.unit == DEGREES and error >= UNKNOWN_DEG else ""


def _widening(dof: float | None) -> float:
    """Return by how much a 95 % interval of Student's t is wider than that of the normal distribution."""
    return 1.0 if dof is None else float(stdtrit(dof, 0.975) / ndtri(0.975))


def is_of_interest(estimates: Sequence[Estimate], name: str) -> bool:
    """Whether any campaign estimates a parameter or held it, or it is known and not the same everywhere."""
    values = [v for e in estimates if (v := e.values.get(name)) is not None and v.status != Status.TIED]
    return any(v.status != Status.KNOWN for v in values) or len({v.value for v in values}) > 1
