"""Digests of a campaign's files, and of all that its search sees, to tell whether two runs have the same inputs."""

from __future__ import annotations

from dataclasses import astuple
from pathlib import Path

from mechid.campaign import Campaign
from mechid.identification.computation.journal import digest
from mechid.identification.output_error.identity import target_digest
from mechid.identification.output_error.target import target_of
from mechid.plant.mechanism import Mechanism
from mechid.reading.whole import is_file
from mechid.records.formats import digest_of


def campaign_digests(campaign: Campaign) -> dict[str, str]:
    """Return a digest of the mechanism, of each record that is estimated from, of stages and options."""
    return {
        "mechanism": _of_mechanism(campaign.mechanism),
        "stages": digest([list(astuple(stage)) for stage in campaign.stages]),
        "options": digest(list(astuple(campaign.options))),
        **{f"record {r.name}": target_digest(target_of(r)) for r in campaign.estimated if r.data is not None},
    }


def file_digests(campaign: Campaign) -> dict[str, str]:
    """Return SHA-256 by file name: of the campaign's two files as they are, of the records as they were read."""
    own = {path.name: file_digest(path) for path in (campaign.path, campaign.mechanism_path)}
    return own | {r.data.path.name: r.data.digest for r in campaign.records if r.data is not None}


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file's bytes; empty where there is none."""
    return digest_of(path) if is_file(path) else ""


def _of_mechanism(mechanism: Mechanism) -> str:
    entries = [
        [p.name, p.value, p.min, p.max, p.sigma, str(p.status), p.tied_to] for p in mechanism.parameters.values()
    ]
    return digest([mechanism.plant.digest, entries])
