"""Finished fit for the page: values, standard errors, and the verdict of the report."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mechid.analysis import validate
from mechid.campaign import Campaign, CampaignRecord
from mechid.identification.result.finished_fit import record_as_fitted
from mechid.identification.result.fit import Fit
from mechid.identification.result.fit_file import read_fit
from mechid.plant.mechanism import Mechanism
from mechid.reports.contents import report_contents
from mechid.reports.noise import compare_with_noise
from mechid.reports.numbers import report_data
from mechid.units import angle_difference


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """A finished fit.

    Attributes
    ----------
    source : str
        Where it comes from, in words.
    values : mapping of str to float
        Of all parameters, by dotted name, and of what held-out records have of their own.
    sigmas : mapping of str to float
        Standard errors, by dotted name.
    summary : mapping
        Verdict of the report: grade, tone, headline, questions with answers.
    angles : frozenset of str
        Names of the parameters that are angles in degrees.
    records : tuple of CampaignRecord
        Records as interpreted by the fit.
    left_out : frozenset of str
        Records that the fit excluded although the campaign file includes them.
    over_noise : mapping of str to float
        Residual-to-noise ratio of each fitted record.
    mechanism : Mechanism or None
        Mechanism with the terms that the fit added, at its initial values; None if it added none.
    """

    source: str
    values: Mapping[str, float]
    sigmas: Mapping[str, float]
    summary: Mapping[str, Any]
    angles: frozenset[str] = frozenset()
    records: tuple[CampaignRecord, ...] = ()
    left_out: frozenset[str] = frozenset()
    over_noise: Mapping[str, float] = field(default_factory=dict)
    mechanism: Mechanism | None = None

    def mechanism_among(self, own: Mechanism, written: Mechanism) -> Mechanism:
        """Return the mechanism of the estimate: that with added terms, else the first given one that it covers."""
        if self.mechanism is not None:
            return self.mechanism
        return own if own.parameters.keys() <= self.values.keys() else written

    def sigmas_from(self, name: str, value: float) -> float | None:
        """Return the signed distance to the estimate in standard errors, the short way for angles; None without one."""
        if name not in self.sigmas:
            return None
        here = self.values[name]
        off = angle_difference(value, here) if name in self.angles else value - here
        return off / self.sigmas[name]


def estimate_of(fit: Fit, campaign: Campaign, source: str) -> Estimate:
    """Convert a fit of the campaign, simulating its records again for the verdict."""
    data = report_data(fit, validation=validate(campaign, fit))
    nuisance = {n: own for r in fit.records.values() if r.nuisance for n, own in r.nuisance.parameters.items()}
    return Estimate(
        source=source,
        values={n: p.value for n, p in fit.parameters.items()} | {n: own.value for n, own in nuisance.items()},
        sigmas={n: p.std_error for n, p in fit.parameters.items() if p.std_error}
        | {n: own.std_error for n, own in nuisance.items() if own.std_error},
        summary=report_contents(data, campaign, fit)["summary"],
        angles=frozenset(name for name, p in fit.parameters.items() if p.unit == "deg"),
        records=tuple(record_as_fitted(record, fit) for record in campaign.records),
        over_noise=_noise_ratios(data),
        left_out=frozenset(name for name, r in fit.records.items() if r.reading.left_out),
        mechanism=fit.start_mechanism if fit.added_terms else None,
    )


def _noise_ratios(data: Mapping[str, Any]) -> dict[str, float]:
    """Return the residual-to-noise ratio of each fitted record, averaged over its channels."""
    squares: dict[str, list[float]] = {}
    for row in data["validation"]:
        if row["use"] == "estimate":
            squares.setdefault(row["name"], []).append(compare_with_noise(data, row).ratio ** 2)
    return {name: math.sqrt(sum(own) / len(own)) for name, own in squares.items()}


def read_estimated(path: Path, campaign: Campaign) -> Estimate:
    """Read an estimate.json.

    Raises
    ------
    InputFileError
        The file is damaged or does not belong to the current campaign.
    """
    return estimate_of(read_fit(path, campaign), campaign, str(path))
