"""A finished fit in use: records as it read them, refusal of a failed fit, covariance by the standard errors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign import Campaign, CampaignRecord
from mechid.errors import MechidError
from mechid.identification.effects.campaign_disturbances import Declared, recalled_record
from mechid.identification.effects.disturbance import with_lines
from mechid.identification.output_error.declaration import record_as_read
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import GRADE_WORDS, Grade


def campaign_as_fitted(campaign: Campaign, fit: Fit, *, disturbances: bool = True) -> Campaign:
    """Return a campaign with each of its records as its fit read it."""
    records = (record_as_fitted(record, fit, disturbances=disturbances) for record in campaign.records)
    return replace(campaign, records=tuple(records))


def record_as_fitted(record: CampaignRecord, fit: Fit, *, disturbances: bool = True) -> CampaignRecord:
    """Return a record as a fit read it.

    It has the sign, command and use that the fit found, no mains hum, and as known values what was fitted of it on its
    first part if it is held out. With `disturbances` it also has, as free parameters, those that the fit added because
    the records ask for them.
    """
    own = fit.records.get(record.name)
    if own is not None:
        record = record_as_read(record, own.taken)
        record = record.with_known_values(own.nuisance.values) if own.nuisance else record
        record = with_lines(record, own.lines)
    return recalled_record(record, _added_of_records(fit), fit.mechanism.plant) if disturbances else record


def _added_of_records(fit: Fit) -> dict[str, Declared]:
    """Return the parameters of disturbances that the fit added, as it started with them, by dotted name."""
    own = (fit.parameters[name] for one in fit.missing for name in one.parameters if name in fit.parameters)
    return {p.name: Declared.bounded(p.start, p.min, p.max, p.prior.sigma if p.prior else None) for p in own}


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
