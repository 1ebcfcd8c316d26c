"""Digests of all that the search of a campaign sees, by name, to tell whether two runs have the same inputs."""

from __future__ import annotations

from dataclasses import astuple

from mechid.campaign import Campaign
from mechid.identification.computation.journal import digest
from mechid.identification.output_error.identity import target_digest
from mechid.identification.output_error.target import target_of
from mechid.plant.mechanism import Mechanism


def campaign_digests(campaign: Campaign) -> dict[str, str]:
    """Return a digest of the mechanism, of each record that is estimated from, of stages and options."""
    return {
        "mechanism": _of_mechanism(campaign.mechanism),
        "stages": digest([list(astuple(stage)) for stage in campaign.stages]),
        "options": digest(list(astuple(campaign.options))),
        **{f"record {r.name}": target_digest(target_of(r)) for r in campaign.estimated if r.data is not None},
    }


def _of_mechanism(mechanism: Mechanism) -> str:
    entries = [
        [p.name, p.value, p.min, p.max, p.sigma, str(p.status), p.tied_to] for p in mechanism.parameters.values()
    ]
    return digest([mechanism.plant.digest, entries])
