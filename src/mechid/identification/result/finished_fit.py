"""Use of a finished fit: records as the fit read them, refusal of a failed fit, covariance of the estimates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign import Campaign, CampaignRecord
from mechid.errors import MechidError
from mechid.identification.effects.campaign_disturbances import Declared, restore_found_record
from mechid.identification.effects.disturbance import with_lines
from mechid.identification.output_error.declaration import reinterpret_record
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import GRADE_WORDS, Grade


def campaign_as_fitted(campaign: Campaign, fit: Fit, *, disturbances: bool = True) -> Campaign:
    """Return a campaign with its records as the fit read them."""
    records = (record_as_fitted(record, fit, disturbances=disturbances) for record in campaign.records)
    return replace(campaign, records=tuple(records))


def record_as_fitted(record: CampaignRecord, fit: Fit, *, disturbances: bool = True) -> CampaignRecord:
    """Return a record as a fit read it.

    The record gets the sign, command and use that the fit found, and no mains hum. A held-out record gets the
    parameters fitted on its first part as known values. With `disturbances`, the parameters of the disturbances that
    the fit added become free parameters.
    """
    own = fit.records.get(record.name)
    if own is not None:
        record = reinterpret_record(record, own.reading)
        record = record.with_known_values(own.nuisance.values) if own.nuisance else record
        record = with_lines(record, own.lines)
    return restore_found_record(record, _added_declarations(fit), fit.mechanism.plant) if disturbances else record


def _added_declarations(fit: Fit) -> dict[str, Declared]:
    """Return the declarations of the added disturbances' parameters, with their start values, by dotted name."""
    own = (fit.parameters[name] for one in fit.missing for name in one.parameters if name in fit.parameters)
    return {p.name: Declared.from_file(p.start, p.min, p.max, p.prior.sigma if p.prior else None) for p in own}


def refuse_failed(fit: Fit, error: type[MechidError], remedy: str = "Identify anew") -> None:
    """Raise an error if the fit failed: it has no values to use."""
    if fit.grade is Grade.FAILED:
        raise error(f"{fit.source}: {GRADE_WORDS[fit.grade]} {fit.outcome.value} {remedy}")


def error_covariance(fit: Fit) -> tuple[tuple[str, ...], FloatArray]:
    """Return the parameters that have a standard error, and their covariance in the file's units.

    It is the correlation times the standard errors, so it includes model error, as they do. `Fit.covariance` counts
    noise alone.
    """
    errors = np.array([fit.parameters[name].std_error for name in fit.correlation_names], dtype=np.float64)
    # Unknown entries are null in the file and NaN here.
    known = np.flatnonzero(np.isfinite(errors) & np.isfinite(np.diag(fit.correlation)))
    covariance = fit.correlation * np.outer(errors, errors)
    return tuple(fit.correlation_names[k] for k in known), covariance[np.ix_(known, known)]
