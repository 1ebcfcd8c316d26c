"""Finished fit as one hypothesis of a comparison."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mechid.analysis.fit_residuals import FitResiduals, ValidationSummary
from mechid.errors import InputFileError, UsageError
from mechid.identification.result.grade import FitOutcome, Grade
from mechid.parameter import Status
from mechid.plant.tables import TABLES, table_of

if TYPE_CHECKING:
    from mechid.identification.result.fit import Fit
    from mechid.identification.result.parameter_estimate import ParameterEstimate
    from mechid.identification.result.record_result import RecordFit

LEFT_OUT = "left out"
"""Use of a record meant for the estimation but excluded because it contradicts the others."""
DIGEST_DIGITS = 8
"""Digits of a digest that are shown in a message."""


@dataclass(frozen=True, kw_only=True)
class RecordEvidence:
    """Prediction of one record by a hypothesis, over all samples or the evaluated part of a held-out record.

    Attributes
    ----------
    name : str
    use : {"estimate", "validate", "left out"}
        The last if the fit excluded the record although the campaign file includes it.
    digest : str
        Digest of the compared samples.
    used : int
        Samples counted in the fit; fewer than `samples` if a window or a horizon shortened the record.
    samples : int
    effective_samples, residual_rms, fit_percent : float
        NaN if the simulation failed; the RMS in N m.
    projected : int
        Number of fitted offsets, drifts, and cosines and sines of lines.
    command : mapping
        Stepping assumed for the driver.
    judged_from_s : float or None
        Record time from which a held-out record is evaluated; its per-record parameters are fitted before that.
    """

    name: str
    use: str
    digest: str
    used: int
    samples: int
    effective_samples: float
    residual_rms: float
    fit_percent: float
    projected: int
    command: Mapping[str, Any]
    judged_from_s: float | None = None


@dataclass(frozen=True, kw_only=True)
class HypothesisParameter:
    """One parameter of a hypothesis, in the file's unit."""

    name: str
    unit: str
    value: float
    std_error: float | None
    status: str


@dataclass(frozen=True, kw_only=True)
class Hypothesis:
    """A finished fit.

    Attributes
    ----------
    name : str
        Name of its folder.
    grade : Grade
    synthetic : bool
        Whether the records were simulated.
    outcome : FitOutcome
    equations : str
        Digest of the plant equations.
    parameters, records : mapping by name
    fit_digest : str
        `Fit.mechanism_digest` of the fit.
    residuals : FitResiduals or None
        Residuals of the fit.
    """

    name: str
    grade: Grade
    synthetic: bool = False
    outcome: FitOutcome
    equations: str
    parameters: Mapping[str, HypothesisParameter]
    records: Mapping[str, RecordEvidence]
    fit_digest: str = ""
    residuals: FitResiduals | None = field(default=None, repr=False, compare=False)

    @property
    def free(self) -> frozenset[str]:
        """Names of the estimated parameters."""
        return frozenset(n for n, p in self.parameters.items() if p.status == Status.FREE)

    @property
    def adjustable(self) -> frozenset[str]:
        """Names of the estimated parameters, including those that ended at a bound."""
        return self.free | {n for n, p in self.parameters.items() if p.status == Status.AT_BOUND}

    def used_for(self, use: str) -> tuple[RecordEvidence, ...]:
        """Return the records with this use."""
        return tuple(r for r in self.records.values() if r.use == use)

    @property
    def fitted_count(self) -> int:
        """Number of fitted quantities: free parameters, offsets, drifts, lines, and one noise level per record."""
        return len(self.free) + sum(r.projected + 1 for r in self.used_for("estimate"))


def hypotheses_of(fits: Mapping[str, Fit]) -> tuple[Hypothesis, ...]:
    """Convert finished fits of the same records to hypotheses.

    Raises
    ------
    UsageError
        The fits have different records, or a fit in memory lacks its campaign.
    InputFileError
        An estimate.json is invalid or has no validation.
    """
    found = [_hypothesis(name, fit) for name, fit in fits.items()]
    for other in found[1:]:
        _refuse_other_records(found[0], other)
    return tuple(found)


def _hypothesis(name: str, fit: Fit) -> Hypothesis:
    residuals = FitResiduals(fit)
    summaries = residuals.summaries
    if fit.records.keys() - summaries.keys():
        raise InputFileError(f"{fit.source}: no 'validation'; it was written by another version, identify anew")
    return Hypothesis(
        name=name,
        grade=fit.grade,
        synthetic=fit.synthetic,
        outcome=fit.outcome,
        equations=str(fit.provenance.get("plant", "")),
        parameters={n: _parameter_of(n, p) for n, p in key_by_period_or_order(fit.parameters).items()},
        records={n: _evidence(r, summaries[n]) for n, r in fit.records.items()},
        fit_digest=fit.mechanism_digest,
        residuals=residuals,
    )


def key_by_period_or_order(parameters: Mapping[str, ParameterEstimate]) -> dict[str, ParameterEstimate]:
    """Replace the index of each list entry in parameter names by its period or order.

    A harmonic is the same parameter at any position in its list.
    """
    tables: dict[str, str] = {}
    for name, p in parameters.items():
        listed = TABLES.get(table_of(name))
        if listed and listed.entry and name.rpartition(".")[2] == listed.told_by:
            unit = "" if p.unit == "1" else p.unit
            tables[name.rpartition(".")[0]] = f"{listed.name}.{p.value:.9g}{unit}"
    # Two entries with the same period could not be told apart, so indices are kept.
    if len(set(tables.values())) < len(tables):
        return dict(parameters)
    split = ((*name.rpartition("."), p) for name, p in parameters.items())
    return {f"{tables.get(table, table)}{dot}{key}": p for table, dot, key, p in split}


def _parameter_of(name: str, p: ParameterEstimate) -> HypothesisParameter:
    return HypothesisParameter(name=name, unit=p.unit, value=p.value, std_error=p.std_error, status=p.status)


def _evidence(r: RecordFit, summary: ValidationSummary) -> RecordEvidence:
    channel = next(iter(summary.channels.values()))
    return RecordEvidence(
        name=r.name,
        use=LEFT_OUT if r.reading.left_out else r.use,
        digest=channel.samples_sha256,
        used=r.samples,
        samples=channel.samples,
        effective_samples=channel.effective_samples,
        residual_rms=channel.residual_rms,
        fit_percent=channel.fit_percent,
        projected=(r.offset is not None) + (r.drift is not None) + 2 * _lines(r),
        command=summary.command,
        judged_from_s=summary.judged_from_s,
    )


def _lines(r: RecordFit) -> int:
    """Return the largest number of lines removed from a channel of the record."""
    return max((len(channel.lines) for channel in r.channels.values()), default=0)


def short_names(folders: Sequence[Path]) -> list[str]:
    """Return the names of the folders, with as many parents as needed to make them unique.

    Examples
    --------
    >>> short_names([Path("/a/FM1"), Path("/a/FM2")]), short_names([Path("/FM1/hot"), Path("/FM2/hot")])
    (['FM1', 'FM2'], ['FM1/hot', 'FM2/hot'])
    """
    parts = [folder.resolve().parts for folder in folders]
    for depth in range(1, max(map(len, parts), default=0) + 1):
        names = ["/".join(p[-depth:]) for p in parts]
        if len(set(names)) == len(names):
            return names
    return list(map(str, folders))


def _refuse_other_records(first: Hypothesis, other: Hypothesis) -> None:
    """Refuse fits whose records differ in their samples or their use."""
    remedy = "compare fits of the same records"
    missing = first.records.keys() ^ other.records.keys()
    for name in sorted(missing):
        has, lacks = (first, other) if name in first.records else (other, first)
        raise UsageError(f'{lacks.name}: no record "{name}", which {has.name} has; {remedy}')
    for name, a in first.records.items():
        b = other.records[name]
        if a.digest != b.digest:
            digests = f"sha256 {b.digest[:DIGEST_DIGITS]}, {a.digest[:DIGEST_DIGITS]} in {first.name}"
            problem = f'record "{name}": other samples ({digests})'
            raise UsageError(f"{other.name}: {problem}: another file, column, unit, gain or clock; {remedy}")
        if a.judged_from_s != b.judged_from_s:
            here, there = (
                "as a whole" if x is None else f"from {x:.4g} s on" for x in (b.judged_from_s, a.judged_from_s)
            )
            problem = f'record "{name}": evaluated {here}, {there} in {first.name}, after a fit of own values'
            raise UsageError(
                f"{other.name}: {problem}; declare the same per-record parameters as free in both campaign files"
            )
        if LEFT_OUT in (a.use, b.use) and a.use != b.use:
            excluding = first if a.use == LEFT_OUT else other
            problem = f'record "{name}": {excluding.name} left it out, because it contradicts the others'
            remedy = 'give it use = "validate" in all campaign files, and identify anew'
            raise UsageError(f"{other.name}: {problem}; {remedy}")
        if a.use != b.use:
            problem = f'record "{name}": use = "{b.use}", "{a.use}" in {first.name}'
            raise UsageError(f"{other.name}: {problem}; estimate from the same records, hold the same ones out")
