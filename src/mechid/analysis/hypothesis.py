"""A finished fit as one hypothesis among several: what a comparison rests on."""

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
"""The use of a record that the campaign file gives to estimate from, and that contradicted the others."""
SHOWN = 8
"""Digits of a digest that tell one from another in a message."""


@dataclass(frozen=True, kw_only=True)
class RecordEvidence:
    """One record as a hypothesis predicts it, over all of its samples or the rest of a held-out one.

    Attributes
    ----------
    name : str
    use : {"estimate", "validate", "left out"}
        The last where the fit left it out against its campaign file.
    digest : str
        Of the samples compared.
    used : int
        Samples that the fit itself counted; fewer than `samples` where a window or a horizon cut it short.
    samples : int
    effective_samples, residual_rms, fit_percent : float
        NaN where the simulation failed; the RMS in N m.
    projected : int
        How many of offset and drift, cosine and sine of lines were fitted.
    command : mapping
        How the driver was taken to step.
    judged_from_s : float or None
        Record time from which on a held-out record is judged, behind the part on which its own values were fitted.
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
class Believed:
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
        Of its folder.
    grade : Grade
    synthetic : bool
        Whether its records were simulated.
    outcome : FitOutcome
    equations : str
        Digest of the plant.
    parameters, records : mapping by name
    fit_digest : str
        `Fit.mechanism_digest` of the fit.
    residuals : FitResiduals or None
        What it left of its records.
    """

    name: str
    grade: Grade
    synthetic: bool = False
    outcome: FitOutcome
    equations: str
    parameters: Mapping[str, Believed]
    records: Mapping[str, RecordEvidence]
    fit_digest: str = ""
    residuals: FitResiduals | None = field(default=None, repr=False, compare=False)

    @property
    def free(self) -> frozenset[str]:
        """Names of the parameters that the records estimate."""
        return frozenset(n for n, p in self.parameters.items() if p.status == Status.FREE)

    @property
    def adjustable(self) -> frozenset[str]:
        """Names of the parameters that the fit could move, those that ended at a bound included."""
        return self.free | {n for n, p in self.parameters.items() if p.status == Status.AT_BOUND}

    def used_for(self, use: str) -> tuple[RecordEvidence, ...]:
        """Return the records of a use."""
        return tuple(r for r in self.records.values() if r.use == use)

    @property
    def counted(self) -> int:
        """Number of all that was fitted: free parameters, offsets, drifts, and a noise level a record."""
        return len(self.free) + sum(r.projected + 1 for r in self.used_for("estimate"))


def hypotheses_of(fits: Mapping[str, Fit]) -> tuple[Hypothesis, ...]:
    """Return finished fits of the same records as hypotheses, each with its name.

    Raises
    ------
    UsageError
        Fits of different records, or one in memory that does not hold its campaign.
    InputFileError
        An estimate.json is wrong or without validation.
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
        parameters={n: _believed(n, p) for n, p in key_by_period_or_order(fit.parameters).items()},
        records={n: _evidence(r, summaries[n]) for n, r in fit.records.items()},
        fit_digest=fit.mechanism_digest,
        residuals=residuals,
    )


def key_by_period_or_order(parameters: Mapping[str, ParameterEstimate]) -> dict[str, ParameterEstimate]:
    """Return parameters with the number of each entry of a list replaced by its period or order.

    It is the same harmonic wherever it stands in its list.
    """
    tables: dict[str, str] = {}
    for name, p in parameters.items():
        listed = TABLES.get(table_of(name))
        if listed and listed.entry and name.rpartition(".")[2] == listed.told_by:
            unit = "" if p.unit == "1" else p.unit
            tables[name.rpartition(".")[0]] = f"{listed.name}.{p.value:.9g}{unit}"
    if len(set(tables.values())) < len(tables):
        return dict(parameters)
    split = ((*name.rpartition("."), p) for name, p in parameters.items())
    return {f"{tables.get(table, table)}{dot}{key}": p for table, dot, key, p in split}


def _believed(name: str, p: ParameterEstimate) -> Believed:
    return Believed(name=name, unit=p.unit, value=p.value, std_error=p.std_error, status=p.status)


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
    """Return how many lines were removed of a record's leading channel."""
    return max((len(channel.lines) for channel in r.channels.values()), default=0)


def short_names(folders: Sequence[Path]) -> list[str]:
    """Return the folders' names, with as many of their parents as tells them apart.

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
    """Refuse fits whose records are not the same samples, or not put to the same use."""
    remedy = "compare fits of the same records"
    missing = first.records.keys() ^ other.records.keys()
    for name in sorted(missing):
        has, lacks = (first, other) if name in first.records else (other, first)
        raise UsageError(f'{lacks.name}: no record "{name}", which {has.name} has; {remedy}')
    for name, a in first.records.items():
        b = other.records[name]
        if a.digest != b.digest:
            digests = f"sha256 {b.digest[:SHOWN]}, {a.digest[:SHOWN]} in {first.name}"
            said = f'record "{name}": other samples ({digests})'
            raise UsageError(f"{other.name}: {said}: another file, column, unit, gain or clock; {remedy}")
        if a.judged_from_s != b.judged_from_s:
            here, there = (
                "as a whole" if x is None else f"from {x:.4g} s on" for x in (b.judged_from_s, a.judged_from_s)
            )
            said = (
                f'record "{name}": judged {here}, {there} in {first.name}, where values of its own were fitted before'
            )
            raise UsageError(f"{other.name}: {said}; declare the same of its values as free in both campaign files")
        if LEFT_OUT in (a.use, b.use) and a.use != b.use:
            of = first if a.use == LEFT_OUT else other
            said = f'record "{name}": {of.name} left it out, because it contradicts the others'
            raise UsageError(f'{other.name}: {said}; give it use = "validate" in all campaign files, and identify anew')
        if a.use != b.use:
            said = f'record "{name}": use = "{b.use}", "{a.use}" in {first.name}'
            raise UsageError(f"{other.name}: {said}; estimate from the same records, hold the same ones out")
