"""Records of a campaign as its fit read them: corrected declarations, removed lines, values of their own."""

from __future__ import annotations

from dataclasses import replace

from mechid.campaign import Campaign, CampaignRecord
from mechid.identification.effects.campaign_disturbances import Declared, recalled_record
from mechid.identification.effects.disturbance import with_lines
from mechid.identification.output_error.declaration import record_as_read
from mechid.identification.result.fit import Fit


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
        record = record.holding(own.nuisance.values) if own.nuisance else record
        record = with_lines(record, own.lines)
    return recalled_record(record, _added_of_records(fit), fit.mechanism.plant) if disturbances else record


def _added_of_records(fit: Fit) -> dict[str, Declared]:
    """Return the parameters of disturbances that the fit added, as it started with them, by dotted name."""
    own = (fit.parameters[name] for one in fit.missing for name in one.parameters if name in fit.parameters)
    return {p.name: Declared.bounded(p.start, p.min, p.max, p.prior.sigma if p.prior else None) for p in own}
