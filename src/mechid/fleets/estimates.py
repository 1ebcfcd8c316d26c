"""Estimates of each parameter in a fleet: values with usable errors, and why others have none."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scipy.special import ndtri, stdtrit

from mechid.analysis.hypothesis import entries_by_what_tells_them
from mechid.campaign.campaign import CAMPAIGN
from mechid.errors import InputFileError
from mechid.fleets.angles import UNKNOWN_DEG
from mechid.identification.result.estimate_file import FILE_NAME, is_synthetic, read_estimate
from mechid.identification.result.grade import GRADE_WORDS, Grade
from mechid.parameter import Status
from mechid.reports.fit.results import read_truth

DEGREES = "deg"
OF_THE_BENCH = ("record", CAMPAIGN)
"""First words of parameters that are of a record or of the recorder, not of the unit."""
STATUS_WORDS = {
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


def read_unit(folder: Path | str) -> Estimate:
    """Return the finished fit of a folder.

    Raises
    ------
    InputFileError
        There is none, or it is damaged.
    """
    path = Path(folder) / FILE_NAME
    content = read_estimate(path)
    try:
        grade = Grade(content["grade"])
        named = entries_by_what_tells_them(content["parameters"])
        reasons, provenance = content.get("grade_reasons", []), content.get("provenance", {})
        return Estimate(
            grade=grade,
            said=str(reasons[0]["text"]) if reasons else "" if grade.good else GRADE_WORDS[grade],
            values={n: _value(p, grade) for n, p in named.items() if n.partition(".")[0] not in OF_THE_BENCH},
            plant=str(provenance.get("plant", "")),
            version=str(provenance.get("versions", {}).get("mechid", "")),
            synthetic=is_synthetic(content) or _is_told_by_report(path.parent),
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputFileError(f"{path}: is damaged at {error}; identify anew") from error


def _is_told_by_report(folder: Path) -> bool:
    """Tell whether the report beside an estimate of an earlier version says that its records were simulated."""
    try:
        return read_truth(folder)[0]
    except InputFileError:  # no report beside it
        return False


def _value(p: Mapping[str, Any], grade: Grade) -> Value:
    sigma = p.get("std_error")
    error = math.nan if sigma is None else float(sigma) * _widening(p.get("dof"))
    return Value(
        value=float(p["value"]),
        std_error=None if sigma is None else float(sigma),
        error=error,
        unit=str(p["unit"]),
        status=str(p["status"]),
        left_out=_left_out(p, error, grade),
        near_threshold=bool(p.get("local_only", False)),
    )


def _left_out(p: Mapping[str, Any], error: float, grade: Grade) -> str:
    """Return why a value is not counted, empty where it is."""
    if p["status"] != Status.FREE:
        return STATUS_WORDS.get(p["status"], str(p["status"]))
    if not grade.good:
        return "failed" if grade is Grade.FAILED else f"grade {grade}"
    if not (math.isfinite(error) and error > 0.0):
        return "no error"
    return "angle not known" if p["unit"] == DEGREES and error >= UNKNOWN_DEG else ""


def _widening(dof: float | None) -> float:
    """Return by how much a 95 % interval of Student's t is wider than that of the normal distribution."""
    return 1.0 if dof is None else float(stdtrit(dof, 0.975) / ndtri(0.975))


def is_of_interest(estimates: Sequence[Estimate], name: str) -> bool:
    """Whether any campaign estimates a parameter or held it, or it is known and not the same everywhere."""
    values = [v for e in estimates if (v := e.values.get(name)) is not None and v.status != Status.TIED]
    return any(v.status != Status.KNOWN for v in values) or len({v.value for v in values}) > 1
