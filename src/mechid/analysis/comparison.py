"""Comparison of finished fits of the same records by criteria, residuals and parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mechid.analysis.criteria import Score, score, shared_effective_samples
from mechid.analysis.hypothesis import Hypothesis, HypothesisParameter, hypotheses_of
from mechid.analysis.preference import Preference, cautions, preference
from mechid.display import DisplayedResult
from mechid.parameter import Status
from mechid.units import angle_difference

if TYPE_CHECKING:
    from mechid.identification.result.fit import Fit


@dataclass(frozen=True, kw_only=True)
class RecordComparison:
    """One record under each hypothesis, in order; residuals in N m, effective samples as used in the criteria."""

    name: str
    use: str
    samples: int
    effective_samples: float
    residual_rms: tuple[float, ...]
    fit_percent: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class ParameterComparison:
    """One parameter under each hypothesis, None if a hypothesis lacks the parameter.

    `differences_sigmas` are differences to the first hypothesis, divided by the larger of the two standard
    errors: both estimates come from the same records and share their noise, so the errors do not add. None if
    neither estimate has an error.
    """

    name: str
    unit: str
    values: tuple[HypothesisParameter | None, ...]
    differences_sigmas: tuple[float | None, ...]


@dataclass(frozen=True, kw_only=True, repr=False)
class Comparison(DisplayedResult):
    """Comparison of finished fits.

    Attributes
    ----------
    hypotheses : tuple of Hypothesis
        In the given order.
    scores : tuple of Score
    records : tuple of RecordComparison
    parameters : tuple of ParameterComparison
        Parameters that any hypothesis estimates, or whose values differ.
    preference : Preference
    cautions : tuple of str
        Limitations of the comparison.
    """

    hypotheses: tuple[Hypothesis, ...]
    scores: tuple[Score, ...]
    records: tuple[RecordComparison, ...]
    parameters: tuple[ParameterComparison, ...]
    preference: Preference
    cautions: tuple[str, ...]


def compare(fits: Mapping[str, Fit]) -> Comparison:
    """Compare finished fits of the same records, given by name; `mechid.compare` reads them.

    Raises
    ------
    UsageError
        The fits have different records, or a fit in memory lacks its campaign.
    InputFileError
        An estimate.json is invalid or has no validation.
    """
    hypotheses = hypotheses_of(fits)
    effective = shared_effective_samples(hypotheses)
    scores = tuple(score(h, effective) for h in hypotheses)
    return Comparison(
        hypotheses=hypotheses,
        scores=scores,
        records=tuple(_record(name, hypotheses, effective[name]) for name in hypotheses[0].records),
        parameters=_parameters(hypotheses),
        preference=preference(hypotheses, scores),
        cautions=cautions(hypotheses, scores),
    )


def _record(name: str, hypotheses: Sequence[Hypothesis], effective: float) -> RecordComparison:
    each = [h.records[name] for h in hypotheses]
    return RecordComparison(
        name=name,
        use=each[0].use,
        samples=each[0].samples,
        effective_samples=effective,
        residual_rms=tuple(r.residual_rms for r in each),
        fit_percent=tuple(r.fit_percent for r in each),
    )


def _parameters(hypotheses: Sequence[Hypothesis]) -> tuple[ParameterComparison, ...]:
    names = dict.fromkeys(name for h in hypotheses for name in h.parameters)
    rows = (_parameter(name, [h.parameters.get(name) for h in hypotheses]) for name in names)
    return tuple(row for row in rows if _is_of_interest(row))


def _is_of_interest(row: ParameterComparison) -> bool:
    """Return whether a parameter is estimated anywhere or differs between hypotheses."""
    known = {None if p is None or p.status != Status.KNOWN else p.value for p in row.values}
    return known == {None} or len(known) > 1


def _parameter(name: str, values: Sequence[HypothesisParameter | None]) -> ParameterComparison:
    unit = next(p.unit for p in values if p is not None)
    first, *others = values
    differences = (None, *(_difference(first, other) for other in others))
    return ParameterComparison(name=name, unit=unit, values=tuple(values), differences_sigmas=differences)


def _difference(first: HypothesisParameter | None, other: HypothesisParameter | None) -> float | None:
    """Return other - first in units of the larger standard error; angles differ by at most half a turn."""
    if first is None or other is None:
        return None
    # Both estimates share the noise of the records, so the errors do not add.
    sigma = max(first.std_error or 0.0, other.std_error or 0.0)
    difference = angle_difference(other.value, first.value) if first.unit == "deg" else other.value - first.value
    return difference / sigma if sigma > 0.0 and math.isfinite(difference) else None
