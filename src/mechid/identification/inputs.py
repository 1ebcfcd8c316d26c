"""Digests of all that the search of a campaign sees, by name, to tell whether two runs have the same inputs."""

from __future__ import annotations

import hashlib
from dataclasses import astuple

import numpy as np

from mechid.campaign import Campaign
from mechid.identification.journal import digest
from mechid.identification.problem import Target
from mechid.identification.target import target_of
from mechid.plant.mechanism import Mechanism


def campaign_digests(campaign: Campaign) -> dict[str, str]:
    """Return a digest of the mechanism, of each record that is estimated from, of stages and options."""
    return {
        "mechanism": _of_mechanism(campaign.mechanism),
        "stages": digest([list(astuple(stage)) for stage in campaign.stages]),
        "options": digest(list(astuple(campaign.options))),
        **{f"record {r.name}": _of_target(target_of(r)) for r in campaign.estimated if r.data is not None},
    }


def _of_mechanism(mechanism: Mechanism) -> str:
    entries = [
        [p.name, p.value, p.min, p.max, p.sigma, str(p.status), p.tied_to] for p in mechanism.parameters.values()
    ]
    return digest([mechanism.plant.digest, entries])


def _of_target(target: Target) -> str:
    """Return a digest of samples, their clock, the step edges, and what is known of offset, drift and delay."""
    total = hashlib.sha256()
    for array in (target.measured, target.excitation.initial, target.excitation.times, target.excitation.values):
        total.update(np.ascontiguousarray(array, dtype=np.float64).tobytes())
    base, bounds = target.base, target.time_offset_bounds
    command = [target.command.start_angle_deg, target.command.start]
    known = [base.sample_rate_hz, base.start_s, target.sigma, target.linear, target.time_offset_s, bounds, command]
    total.update(digest(known).encode())
    return total.hexdigest()
